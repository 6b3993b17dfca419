"""Forces, torques, energies and inductances between sources, and moments induced in spheres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import MagneticBody
from ..base.arguments import takes
from .dipole_cells import as_cells
from .sources import as_list

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
    """Force (3) [N] on a body and torque (3) [N m] about the body's centre, in world axes, with the
    estimated error [N] that `force` defines.
    """

    force: Floats
    torque: Floats
    error: float


class Forces(NamedTuple):
    """Forces (n, 3) [N] on n bodies and torques (n, 3) [N m] about the bodies' centres, in world
    axes, with the estimated errors (n) [N] that `force` defines.
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
    """Returns force and torque on one body, exerted by another.

    tolerance [1], 1e-12 to 0.1: requested error relative to the force, or to torque / radius if
    that is larger. In general, the charge or current of one body is integrated in the field of the
    other; torque and radius are those of the integrated body. Dipoles and hard spheres need no
    integral. The reaction follows from the balance of linear and angular momentum: the force with
    on=b and by=a is minus that with on=a and by=b, to the last bit.

    `error` [N] estimates the error of the force, or of torque / radius if that is larger. It
    exceeds the requested error if 2,000,000 evaluations of the field do not suffice. For induced
    bodies it includes the error of their charge, which is estimated for cuboids and cylinders by
    comparing several grids of panels, and for spheres from the end of their series. For an induced
    body near a magnet (at the gaps that `soft_cuboid` states) and for cuboids that magnetise each
    other, the estimate is between half and ten times the true error in nine of ten cases (for
    spheres, if the degree is at least 3). For a sphere of degree 10 or more whose series has not
    converged, it is at least the force between a dipole with the moment of the other body and a
    plane of ideal iron. For two spheres, the estimate can be too small. For induced meshes, which
    have only one grid, it is nan.

    engine "cells" represents both magnets by dipole cells of `density` [1/m^3]. The tolerance then
    has no effect on the result, and overlap is not detected. The error is estimated by comparison
    with cells of an eighth of the density. For many calls, build the cells once with `cells`; the
    error is then 0, because it refers to the sum over these cells only.

    Raises InvalidInput for solid magnets that overlap (they may touch), for loops or polylines that
    meet, for polylines that are not closed, and for an invalid tolerance, engine or density. Bodies
    that overlap by at most 1e-6 of the sum of their radii exert the forces of bodies that touch.
    Larger overlap is always found if both bodies are hard cuboids or one is a sphere. Between other
    bodies it is found if one of about 300 points (more on meshes with many triangles) on the
    surface of either body lies in the other.

    >>> import loomstone as ls
    >>> a = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    >>> f = ls.magnetics.force(on=a.moved((0, 0, 0.01)), by=a, tolerance=1e-6)
    >>> print(f"{f.force[2]:.3f} N")
    -32.379 N
    """
    fine = _force(on, by, tolerance, engine, density)
    if density is None:
        return fine
    # Halving the width of the cells usually at least halves the error. The difference of the two
    # results is then at least the error of the finer one. The factor of two is a margin.
    coarse = _force(on, by, tolerance, engine, density / 8)
    force_error = np.linalg.norm(fine.force - coarse.force)
    torque_error = np.linalg.norm(fine.torque - coarse.torque) / on.radius
    return fine._replace(error=2.0 * float(max(force_error, torque_error)))


def _force(
    on: MagneticBody, by: MagneticBody, tolerance: float, engine: str, density: float | None
) -> Force:
    on, by = as_cells(on, engine, density), as_cells(by, engine, density)
    return Force(*_core.magnetic_force(on, by, tolerance))


@takes(tolerance="1")
def forces(bodies: Sequence[MagneticBody], *, tolerance: float = 1e-4, threads: int = 0) -> Forces:
    """Returns forces and torques on every body, exerted by all others.

    tolerance [1]: error of each pair relative to the largest force that a rough first pass finds,
    or to the pair's own force or torque / radius if that is larger. Linear and angular momentum are
    conserved to rounding. Between bodies made by cells(), the forces are sums over their cells. As
    in `force`, errors are estimated, and magnets that overlap and wires that meet raise
    InvalidInput. threads 0: OMP_NUM_THREADS or all processors; the result does not depend on it.

    The method `at` places each body at its pose:

    >>> import loomstone as ls
    >>> magnets = [ls.magnetics.sphere(radius=0.005, polarization=(0, 0, 1)) for _ in range(2)]
    >>> poses = [((0, 0, 0), (1, 0, 0, 0)), ((0, 0, 0.02), (1, 0, 0, 0))]
    >>> f = ls.magnetics.forces([m.at(x, q) for m, (x, q) in zip(magnets, poses)])
    >>> print(f"{f.forces[0, 2]:.4f} {f.forces[1, 2]:.4f} N")
    0.6510 -0.6510 N
    """
    return Forces(*_core.magnetic_forces(as_list(bodies), tolerance, threads))


@takes(tolerance="1")
def energy(bodies: Sequence[MagneticBody], *, tolerance: float = 1e-4, threads: int = 0) -> float:
    """Returns the interaction energy of magnets [J], which vanishes at infinite distance.

    It is minus the sum over pairs of the integral of M.B over one magnet, where B is the field of
    the other. Forces are its negative derivatives with respect to positions at constant M.
    tolerance [1]: error relative to the energy of each pair or, if that is larger, to
    1e-3 mu0 m1 m2 / (4 pi r^3) with the moments m1 and m2 and the sum r of both radii. The energy
    of an induced body is that of its charge in the potential of the magnet, and does not depend on
    the tolerance.
    threads 0: OMP_NUM_THREADS or all processors; the result does not depend on it. Raises
    Unsupported for currents, because keeping them constant requires work, and for two bodies with
    the mutual response of `induce`.

    >>> import loomstone as ls
    >>> a = ls.magnetics.sphere(radius=0.005, polarization=(0, 0, 1))
    >>> print(f"{ls.magnetics.energy([a, a.moved((0, 0, 0.01))]):.4f} J")
    -0.0347 J
    """
    return float(_core.magnetic_energy(list(bodies), tolerance, threads))


@takes(tolerance="1")
def mutual_inductance(a: MagneticBody, b: MagneticBody, *, tolerance: float = 1e-6) -> float:
    """Returns the mutual inductance [H] of two loops or solenoids made with 1 A per turn.

    With other currents, the result is the inductance times the product of both currents per turn
    [J]. tolerance [1]: error relative to the integral, along one winding, of the norm of the vector
    potential of the other. The error can be larger if the windings touch. Raises InvalidInput for
    other bodies, and for two loops that coincide, because the inductance of infinitely thin wire is
    infinite.

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
    """Returns the moments (n, 3) [A m^2] of spheres in an applied field and in one another's field.

    points: (n, 3) centres [m]. radii: (n) [m]. susceptibilities: (n) chi >= -1 [1] (inf: ideal
    iron, -1: superconductor). applied: (n, 3) flux density at the centres without the spheres [T].
    Each sphere is modelled as a point dipole (4 pi R^3 / mu0) chi / (3 + chi) B. This is exact for
    one sphere in a uniform field, and accurate for spheres whose distances are large compared with
    their radii. The linear system is solved to a relative residual of `tolerance`. threads 0:
    OMP_NUM_THREADS or all processors; the result does not depend on it. Raises InvalidInput for
    values out of range, and SolverFailure if the solution does not converge, as can happen if
    spheres overlap deeply.

    >>> import loomstone as ls
    >>> iron = {"radii": [0.01], "susceptibilities": [float("inf")]}
    >>> m = ls.magnetics.induced_moments([[0, 0, 0]], applied=[[0, 0, 0.1]], **iron)
    >>> print(f"{m[0, 2]:.3f} A m^2")
    1.000 A m^2
    """
    radii, susceptibilities = np.ravel(radii).tolist(), np.ravel(susceptibilities).tolist()
    return _core.induced_moments(points, radii, susceptibilities, applied, tolerance, threads)
