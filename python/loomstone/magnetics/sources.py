"""Magnets and currents as objects at poses.

Every function returns a `MagneticBody` whose centre lies at the origin and whose axes are those of
the world (meshes and polylines: where their vertices are); `body.moved(by)`, `body.rotated(by)` and
`body.at(position, orientation)` give copies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import MagneticBody, TriangleMesh
from ..base.arguments import explained

__all__ = [
    "Force",
    "Forces",
    "cell_front",
    "cell_level",
    "cells",
    "cuboid",
    "cylinder",
    "dipoles",
    "energy",
    "field",
    "force",
    "forces",
    "gradient",
    "induced_moments",
    "loop",
    "mesh",
    "mutual_inductance",
    "polyline",
    "potential",
    "solenoid",
    "sphere",
]

Floats = NDArray[np.float64]
Bodies = MagneticBody | Sequence[MagneticBody]


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


def as_list(bodies: Bodies) -> list[MagneticBody]:
    """One body or several as a list."""
    return [bodies] if isinstance(bodies, MagneticBody) else list(bodies)


def box_of(bodies: list[MagneticBody]) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates (3), (3) [m] of the balls about bodies."""
    places, radii = np.array([b.position for b in bodies]), np.array([b.radius for b in bodies])
    return (places - radii[:, None]).min(axis=0), (places + radii[:, None]).max(axis=0)


@explained
def cuboid(*, size: ArrayLike, polarization: ArrayLike) -> MagneticBody:
    """Cuboid magnet: edges `size` (3) [m], polarization J = mu0 M (3) [T] in its own axes."""
    return _core.magnetic_cuboid(size=size, polarization=polarization)


@explained
def cylinder(
    *, radius: float, height: float, polarization: ArrayLike, inner_radius: float = 0.0
) -> MagneticBody:
    """Cylinder magnet about its z axis, a ring where inner_radius > 0: lengths [m], polarization J
    (3) [T], any direction.
    """
    return _core.magnetic_cylinder(
        radius=radius, height=height, polarization=polarization, inner_radius=inner_radius
    )


@explained
def sphere(*, radius: float, polarization: ArrayLike) -> MagneticBody:
    """Spherical magnet: radius [m], polarization J (3) [T]."""
    return _core.magnetic_sphere(radius=radius, polarization=polarization)


@explained
def mesh(mesh: TriangleMesh, *, polarization: ArrayLike) -> MagneticBody:
    """Magnet of any shape inside a closed `TriangleMesh` [m]; its centre is that of the volume.

    Polarization J (3) [T].
    """
    return _core.magnetic_mesh(mesh, polarization=polarization)


@explained
def dipoles(points: ArrayLike, moments: ArrayLike) -> MagneticBody:
    """Point dipoles moments (n, 3) [A m^2] at points (n, 3) [m] in the body's axes."""
    return _core.magnetic_dipoles(points, moments)


@explained
def loop(*, radius: float, current: float) -> MagneticBody:
    """Circular loop in z = 0: radius [m], current [A] counter-clockwise seen from +z."""
    return _core.magnetic_loop(radius=radius, current=current)


@explained
def solenoid(*, radius: float, length: float, turns: float, current: float) -> MagneticBody:
    """Ideal solenoid about z, a sheet of current: radius, length [m], number of turns [1], current
    of each [A].
    """
    return _core.magnetic_solenoid(radius=radius, length=length, turns=turns, current=current)


@explained
def polyline(vertices: ArrayLike, *, current: float) -> MagneticBody:
    """Straight conductors between vertices (n, 3) [m], current [A] from the first to the last;
    closed where these are equal.

    The body's centre is the mean of the vertices.
    """
    return _core.magnetic_polyline(vertices, current=current)


def field(
    bodies: Bodies, points: ArrayLike, *, quantity: Literal["B", "H"] = "B", threads: int = 0
) -> Floats:
    """Field of one body or of several together.

    points (n, 3) [m], world axes. Returns (n, 3): flux density B [T], or field strength H [A/m];
    they differ inside magnets, where B = mu0 H + J. A point on a surface gets the value outside. On
    edges and wires, where the field is infinite, it is that 1e-15 of the size beside them. threads
    0: all processors; the result does not depend on it. Raises InvalidInput for points that are not
    finite (n, 3), and other quantities.

    >>> import loomstone as ls
    >>> loop = ls.magnetics.loop(radius=1, current=2)
    >>> ls.magnetics.field(loop, [[0, 0, 0]], quantity="H").tolist()
    [[0.0, 0.0, 1.0]]
    """
    return _core.magnetic_field(as_list(bodies), points, quantity, threads)


def gradient(bodies: Bodies, points: ArrayLike, *, threads: int = 0) -> Floats:
    """Gradient of the field of one body or of several together.

    points (n, 3) [m], world axes. Returns (n, 3, 3), [k, i, j] = mu0 dH_i/dx_j at points[k] [T/m],
    which off currents and surfaces is dB_i/dx_j. Symmetric. threads as in `field`. A polyline must
    be closed.
    """
    return _core.magnetic_gradient(as_list(bodies), points, threads)


@explained
def potential(bodies: Bodies, points: ArrayLike, *, threads: int = 0) -> Floats:
    """Scalar potential of hard magnets and dipoles, one or several together, whose descent is H,
    inside them too.

    points (n, 3) [m], world axes. Returns (n) [A], zero infinitely far away and continuous
    everywhere. threads as in `field`. Raises Unsupported for currents, which have none, and for
    induced bodies.

    >>> import loomstone as ls
    >>> ls.magnetics.potential(ls.magnetics.dipoles([[0, 0, 0]], [[0, 0, 1]]), [[0, 0, 0.5]])
    array([0.31830989])
    """
    return _core.magnetic_potential(as_list(bodies), points, threads)


@explained
def cells(body: MagneticBody, *, density: float, separation: float = 3.0) -> MagneticBody:
    """A solid hard magnet as a hierarchy of dipole cells, as in the thesis (section 6.3.2): same
    pose, same moment.

    The bounding box is bisected along the longest axis until leaves have `density` [1/m^3]; leaves
    outside or closer to the surface than half their diameter v^(1/3) are dropped, and every level
    carries the whole moment (where none is left, one dipole does). Between two such bodies force()
    and forces() sum over fronts: a cell of longest edge e serves at distances from separation * e
    on, which is eq. (6.19) with r_0 = separation / density^(1/3). Fast at interactive rates, 40 %
    off in contact and 2 % at a twentieth of the body's size away (10 x 10 x 10 cells); the magnet
    itself is exact. field() sums over the leaves. Raises InvalidInput for currents and dipoles,
    density <= 0 and separation < 1.

    >>> import loomstone as ls
    >>> magnet = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    >>> body = ls.magnetics.cells(magnet, density=8e6)
    >>> len(ls.magnetics.cell_level(body, 99)[0])
    8
    """
    return _core.magnetic_cells(body, density=density, separation=separation)


@explained
def cell_level(body: MagneticBody, level: int) -> tuple[Floats, Floats]:
    """Positions [m] and moments [A m^2] (n, 3) of the cells of one level, 0 the whole body; leaves
    stand for levels below.
    """
    return _core.magnetic_cell_level(body, level)


@explained
def cell_front(body: MagneticBody, other: MagneticBody) -> tuple[Floats, Floats]:
    """Positions [m] and moments [A m^2] (n, 3) of the cells of `body` that serve towards `other`;
    both made by cells().
    """
    return _core.magnetic_cell_front(body, other)


def as_cells(body: MagneticBody, engine: str, density: float | None) -> MagneticBody:
    """The body for an engine."""
    if engine == "exact" and density is None:
        return body
    if engine == "exact":
        raise _core.InvalidInput('density belongs to engine="cells", got it with engine="exact"')
    if engine != "cells":
        raise _core.InvalidInput(f'engine must be "exact" or "cells", got {engine!r}')
    if density is None:
        raise _core.InvalidInput(
            'density [1/m^3] must be given with engine="cells"; 8e6 is eight cells a cubic'
            " centimetre"
        )
    return cells(body, density=density)


@explained
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


@explained
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


@explained
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


@explained
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


@explained
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
