"""Forces, torques and energies between sources, and the moments of spheres that magnetise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import MagneticBody
from ..base.arguments import takes
from .dipole_cells import as_cells

__all__ = [
    "Force",
    "Forces",
    "energy",
    "force",
    "forces",
    "induced_moments",
    "mutual_inductance",
]

Floats = NDArray[np.float64]


class Force(NamedTuple):
    """What one body feels: force (3) [N], torque (3) about its centre [N m], world axes; estimated
    error [N].
    """

    force: Floats
    torque: Floats
    error: float


class Forces(NamedTuple):
    """What each of n bodies feels: forces (n, 3) [N], torques (n, 3) about their centres [N m];
    errors (n) [N].
    """

    forces: Floats
    torques: Floats
    errors: Floats


@takes(tolerance="1", density="1/m^3")
def force(
    *,
    on: MagneticBody,
    by: MagneticBody,
    tolerance: float = 1e-4,
    engine: Literal["exact", "cells"] = "exact",
    density: float | None = None,
) -> Force:
    """Force and torque on one body by another.

    tolerance [1]: error asked for, relative to the force, or to the torque over the radius of the
    body where that is larger; 1e-12 to 0.1. One body's charge or current is integrated in the exact
    field of the other, and what the other feels follows from the balance of linear and angular
    momentum: force(on=b, by=a) is minus force(on=a, by=b) to the last bit. Dipoles and spheres are
    exact. `error` [N] is an estimate, above what was asked for where 2,000,000 evaluations of the
    field did not suffice. Bodies that overlap feel the finite forces between their surface charges.
    Raises InvalidInput for another tolerance and for polylines that are not closed. engine "cells":
    both magnets as dipole cells of `density` [1/m^3], see `cells`, which builds them once for many
    calls; tolerance then means nothing and error is 0, as no estimate is made.

    >>> import loomstone as ls
    >>> a = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    >>> f = ls.magnetics.force(on=a.moved((0, 0, 0.01)), by=a, tolerance=1e-6)
    >>> print(f"{f.force[2]:.3f} N")
    -32.379 N
    """
    on, by = as_cells(on, engine, density), as_cells(by, engine, density)
    return Force(*_core.magnetic_force(on, by, tolerance))


@takes(tolerance="1")
def forces(bodies: Sequence[MagneticBody], *, tolerance: float = 1e-4, threads: int = 0) -> Forces:
    """Forces and torques on every body by all others.

    tolerance [1]: error of each pair relative to the largest force between two of the bodies.
    Linear and angular momentum are kept to rounding. Bodies made by cells() act on one another as
    such. threads 0: all processors; the result does not depend on it. For bodies that move, give
    their poses:

    >>> import loomstone as ls
    >>> magnets = [ls.magnetics.sphere(radius=0.005, polarization=(0, 0, 1)) for _ in range(2)]
    >>> poses = [((0, 0, 0), (1, 0, 0, 0)), ((0, 0, 0.02), (1, 0, 0, 0))]
    >>> f = ls.magnetics.forces([m.at(x, q) for m, (x, q) in zip(magnets, poses)])
    >>> print(f"{f.forces[0, 2]:.4f} {f.forces[1, 2]:.4f} N")
    0.6510 -0.6510 N
    """
    return Forces(*_core.magnetic_forces(list(bodies), tolerance, threads))


@takes(tolerance="1")
def energy(bodies: Sequence[MagneticBody], *, tolerance: float = 1e-4, threads: int = 0) -> float:
    """Energy of hard magnets in one another's field [J], zero when they are infinitely far apart.

    Minus the sum over pairs of the integral of M.B over one magnet in the field of the other.
    Forces are minus its derivative by positions. tolerance [1]: of each pair's energy, or of 1e-3
    of the energy that two dipoles of their moments have at the sum of their radii where that is
    larger; with an induced body, that of its charge in the magnet's potential at the points of its
    panels, which needs none. threads 0: all processors; the result does not depend on it. Raises
    Unsupported for currents, which need work to be held constant.

    >>> import loomstone as ls
    >>> a = ls.magnetics.sphere(radius=0.005, polarization=(0, 0, 1))
    >>> print(f"{ls.magnetics.energy([a, a.moved((0, 0, 0.01))]):.4f} J")
    -0.0347 J
    """
    return float(_core.magnetic_energy(list(bodies), tolerance, threads))


@takes(tolerance="1")
def mutual_inductance(a: MagneticBody, b: MagneticBody, *, tolerance: float = 1e-6) -> float:
    """Flux that one of two loops or solenoids sends through the other, over the product of their
    currents [H].

    With turns and one ampere each, as they were made: with other currents the product of these is
    contained. tolerance [1]: of the integral of the vector potential's absolute value along the
    winding. Raises InvalidInput for other bodies.

    >>> import loomstone as ls
    >>> a, b = (ls.magnetics.loop(radius=radius, current=1.0) for radius in (0.1, 0.01))
    >>> print(f"{1e9 * ls.magnetics.mutual_inductance(a, b):.3f} nH")
    1.981 nH
    """
    return _core.mutual_inductance(a, b, tolerance=tolerance)


@takes(points="m", radii="m", susceptibilities="1", applied="T", tolerance="1")
def induced_moments(
    points: ArrayLike,
    *,
    radii: ArrayLike,
    susceptibilities: ArrayLike,
    applied: ArrayLike,
    tolerance: float = 1e-12,
    threads: int = 0,
) -> Floats:
    """Moments (n, 3) [A m^2] of spheres that magnetise in an applied field and in the field of one
    another.

    points (n, 3) centres [m], radii (n) [m], susceptibilities (n) chi >= -1 [1] (inf: ideal iron,
    -1: superconductor), applied (n, 3) flux density at the centres without the spheres [T]. Each
    sphere is taken as a point dipole 4 pi R^3 / mu0 chi / (3 + chi) B: exact for one sphere in a
    uniform field and for spheres far apart beside their radius. The linear system is solved to a
    relative residual of `tolerance`. threads 0: all processors; the result does not depend on it.
    Raises InvalidInput for values outside these ranges and SolverFailure where spheres lie so deep
    in one another that there is no equilibrium.

    >>> import loomstone as ls
    >>> iron = {"radii": [0.01], "susceptibilities": [float("inf")]}
    >>> m = ls.magnetics.induced_moments([[0, 0, 0]], applied=[[0, 0, 0.1]], **iron)
    >>> print(f"{m[0, 2]:.3f} A m^2")
    1.000 A m^2
    """
    radii, susceptibilities = np.ravel(radii).tolist(), np.ravel(susceptibilities).tolist()
    return _core.induced_moments(points, radii, susceptibilities, applied, tolerance, threads)
