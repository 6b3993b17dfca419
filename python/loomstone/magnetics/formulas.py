"""Fields and gradients of sources in their own axes, and dipole forces, as functions of arrays.

`*_field` and `*_gradient` take observers (n, 3) [m]. `*_field` returns (n, 3): flux density B [T]
or, with quantity="H" (except dipole_field), field strength H [A/m]. `*_gradient` returns (n, 3, 3),
where [k, i, j] = mu0 dH_i/dx_j [T/m] at observers[k], which equals dB_i/dx_j away from surfaces and
currents. The argument threads, the values on surfaces, edges and wires, and the errors raised are
those of `loomstone.magnetics.field`. The relative rounding error of the field of a closed polyline
grows with distance / size, because the fields of its segments cancel. Equation numbers refer to
[Thomaszewski2010].

>>> from loomstone import magnetics
>>> b = magnetics.dipole_field([[0, 0, 0]], [[0, 0, 1.0]], [[0, 0, 1.0], [1.0, 0, 0]])
>>> [f"{bz:.3e}" for bz in b[:, 2]]
['2.000e-07', '-1.000e-07']
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import TriangleMesh
from ..base.arguments import takes
from . import sources
from .fields import field, gradient

__all__ = [
    "cuboid_field",
    "cuboid_gradient",
    "cylinder_field",
    "cylinder_gradient",
    "dipole_energy",
    "dipole_field",
    "dipole_forces",
    "dipole_gradient",
    "loop_field",
    "loop_gradient",
    "mesh_field",
    "mesh_gradient",
    "polyline_field",
    "polyline_gradient",
    "solenoid_field",
    "solenoid_gradient",
    "sphere_field",
    "sphere_gradient",
]

Floats = NDArray[np.float64]
Quantity = Literal["B", "H"]


@takes(points="m", moments="A m^2", observers="m", tolerance="1")
def dipole_field(
    points: ArrayLike,
    moments: ArrayLike,
    observers: ArrayLike,
    *,
    tolerance: float | None = None,
    threads: int = 0,
) -> Floats:
    """Returns B (k, 3) [T] of point dipoles at observers (k, 3) [m], eq. (6.5).

    The dipoles have moments (n, 3) [A m^2] at points (n, 3) [m]. A dipole located exactly at an
    observer contributes nothing there. With observers=points, the result at each dipole is
    therefore the field of all other dipoles.

    tolerance: None sums all pairs directly. A number in [1e-10, 0.1] selects a treecode, whose time
    grows like N log N for N dipoles and N observers. Other numbers raise InvalidInput. The number
    bounds the root mean square error, relative to the root mean square of the result, as measured
    against direct sums for up to 128 observers. With a number, all pairs are still summed directly
    if there are at most 6e7 of them (about 7,700 dipoles and as many observers), or if the treecode
    does not meet the tolerance.
    """
    if tolerance is None:
        return field(_core.magnetic_dipoles(points, moments), observers, threads=threads)
    return _core.dipole_tree_field(points, moments, observers, tolerance, threads)


@takes(points="m", moments="A m^2", observers="m", tolerance="1")
def dipole_gradient(
    points: ArrayLike,
    moments: ArrayLike,
    observers: ArrayLike,
    *,
    tolerance: float | None = None,
    threads: int = 0,
) -> Floats:
    """Returns dB_i/dx_j (k, 3, 3) [T/m] of point dipoles at observers (k, 3) [m].

    The arguments are those of `dipole_field`. The error of the gradient meets the tolerance.
    """
    if tolerance is None:
        return gradient(_core.magnetic_dipoles(points, moments), observers, threads=threads)
    return _core.dipole_tree_gradient(points, moments, observers, tolerance, threads)


@takes(points="m", moments="A m^2", by_points="m", by_moments="A m^2", tolerance="1")
def dipole_forces(
    points: ArrayLike,
    moments: ArrayLike,
    by_points: ArrayLike | None = None,
    by_moments: ArrayLike | None = None,
    *,
    tolerance: float | None = None,
    threads: int = 0,
) -> tuple[Floats, Floats]:
    """Returns forces [N] and torques [N m], each (n, 3), on point dipoles, eqs. (6.10) and (6.11).

    The dipoles have moments (n, 3) [A m^2] at points (n, 3) [m]. The forces are exerted by the
    dipoles by_moments at by_points or, if these are omitted, by all other dipoles of the same set.
    Each torque is about the dipole's own position. The torque about another point x has the
    additional term cross(point - x, force).

    tolerance as in `dipole_field`; both forces and torques meet it. Forces and torques within one
    set conserve linear and angular momentum to rounding at any tolerance. Raises InvalidInput if
    only one of by_points and by_moments is given.
    """
    if (by_points is None) != (by_moments is None):
        raise _core.InvalidInput("by_points and by_moments must be given together or not at all")
    if by_points is None or by_moments is None:
        by_points, by_moments = points, moments
    return _core.dipole_forces(points, moments, by_points, by_moments, tolerance, threads)


@takes(points="m", moments="A m^2")
def dipole_energy(points: ArrayLike, moments: ArrayLike, *, threads: int = 0) -> float:
    """Returns the interaction energy [J] of dipoles: moments (n, 3) [A m^2] at points (n, 3) [m].

    This is minus the sum over pairs k < l of the scalar product of moment k and the field of dipole
    l at point k.
    """
    return _core.dipole_energy(points, moments, threads)


@takes(observers="m", size="m", polarization="T")
def cuboid_field(
    observers: ArrayLike,
    *,
    size: ArrayLike,
    polarization: ArrayLike,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of a cuboid magnet: edges `size` (3) [m] along the axes, polarization J (3) [T].

    Inside, B = mu0 H + J.
    """
    return field(
        sources.cuboid(size=size, polarization=polarization),
        observers,
        quantity=quantity,
        threads=threads,
    )


@takes(observers="m", size="m", polarization="T")
def cuboid_gradient(
    observers: ArrayLike, *, size: ArrayLike, polarization: ArrayLike, threads: int = 0
) -> Floats:
    """Gradient of the field of a cuboid magnet; arguments as in `cuboid_field`."""
    return gradient(
        sources.cuboid(size=size, polarization=polarization), observers, threads=threads
    )


@takes(observers="m", radius="m", height="m", polarization="T", inner_radius="m")
def cylinder_field(
    observers: ArrayLike,
    *,
    radius: float,
    height: float,
    polarization: ArrayLike,
    inner_radius: float = 0.0,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of a cylinder or ring magnet about z, with |z| <= height / 2.

    Lengths are in [m]. The polarization J (3) [T] may have any direction. B = mu0 H + J inside the
    material, and B = mu0 H in the bore of a ring.
    """
    body = sources.cylinder(
        radius=radius, height=height, polarization=polarization, inner_radius=inner_radius
    )
    return field(body, observers, quantity=quantity, threads=threads)


@takes(observers="m", radius="m", height="m", polarization="T", inner_radius="m")
def cylinder_gradient(
    observers: ArrayLike,
    *,
    radius: float,
    height: float,
    polarization: ArrayLike,
    inner_radius: float = 0.0,
    threads: int = 0,
) -> Floats:
    """Gradient of the field of a cylinder or ring magnet; arguments as in `cylinder_field`."""
    body = sources.cylinder(
        radius=radius, height=height, polarization=polarization, inner_radius=inner_radius
    )
    return gradient(body, observers, threads=threads)


@takes(observers="m", radius="m", polarization="T")
def sphere_field(
    observers: ArrayLike,
    *,
    radius: float,
    polarization: ArrayLike,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of a spherical magnet: radius [m], polarization J (3) [T].

    Outside, the field is that of a dipole. Inside, B = 2/3 J and mu0 H = -J/3.
    """
    return field(
        sources.sphere(radius=radius, polarization=polarization),
        observers,
        quantity=quantity,
        threads=threads,
    )


@takes(observers="m", radius="m", polarization="T")
def sphere_gradient(
    observers: ArrayLike, *, radius: float, polarization: ArrayLike, threads: int = 0
) -> Floats:
    """Gradient of the field of a spherical magnet, 0 inside; arguments as in `sphere_field`."""
    return gradient(
        sources.sphere(radius=radius, polarization=polarization), observers, threads=threads
    )


@takes(observers="m", polarization="T")
def mesh_field(
    observers: ArrayLike,
    mesh: TriangleMesh,
    *,
    polarization: ArrayLike,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of a magnet bounded by a closed `TriangleMesh` [m] with uniform polarization J (3) [T].

    Inside, B = mu0 H + J.
    """
    return field(
        sources.mesh(mesh, polarization=polarization), observers, quantity=quantity, threads=threads
    )


@takes(observers="m", polarization="T")
def mesh_gradient(
    observers: ArrayLike, mesh: TriangleMesh, *, polarization: ArrayLike, threads: int = 0
) -> Floats:
    """Gradient of the field of a magnet bounded by a closed mesh; arguments as in `mesh_field`."""
    return gradient(sources.mesh(mesh, polarization=polarization), observers, threads=threads)


@takes(observers="m", radius="m", current="A")
def loop_field(
    observers: ArrayLike,
    *,
    radius: float,
    current: float,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of a circular loop in the plane z = 0: radius [m], current [A].

    The current flows counter-clockwise as seen from +z.
    """
    return field(
        sources.loop(radius=radius, current=current), observers, quantity=quantity, threads=threads
    )


@takes(observers="m", radius="m", current="A")
def loop_gradient(
    observers: ArrayLike, *, radius: float, current: float, threads: int = 0
) -> Floats:
    """Gradient of the field of a circular loop; arguments as in `loop_field`."""
    return gradient(sources.loop(radius=radius, current=current), observers, threads=threads)


@takes(observers="m", radius="m", length="m", turns="1", current="A")
def solenoid_field(
    observers: ArrayLike,
    *,
    radius: float,
    length: float,
    turns: float,
    current: float,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of an ideal solenoid about z, with |z| <= length / 2: lengths [m], number of turns [1],
    current of each turn [A].
    """
    body = sources.solenoid(radius=radius, length=length, turns=turns, current=current)
    return field(body, observers, quantity=quantity, threads=threads)


@takes(observers="m", radius="m", length="m", turns="1", current="A")
def solenoid_gradient(
    observers: ArrayLike,
    *,
    radius: float,
    length: float,
    turns: float,
    current: float,
    threads: int = 0,
) -> Floats:
    """Gradient of the field of an ideal solenoid; arguments as in `solenoid_field`."""
    body = sources.solenoid(radius=radius, length=length, turns=turns, current=current)
    return gradient(body, observers, threads=threads)


@takes(observers="m", vertices="m", current="A")
def polyline_field(
    observers: ArrayLike,
    vertices: ArrayLike,
    *,
    current: float,
    quantity: Quantity = "B",
    threads: int = 0,
) -> Floats:
    """Field of a current along the straight segments between successive vertices (k, 3) [m].

    It follows from the law of Biot and Savart. The current [A] flows from the first vertex to the
    last.
    """
    return field(
        sources.polyline(vertices, current=current), observers, quantity=quantity, threads=threads
    )


@takes(observers="m", vertices="m", current="A")
def polyline_gradient(
    observers: ArrayLike, vertices: ArrayLike, *, current: float, threads: int = 0
) -> Floats:
    """Gradient of the field of a closed polyline; arguments as in `polyline_field`.

    The last vertex must equal the first.
    """
    return gradient(sources.polyline(vertices, current=current), observers, threads=threads)
