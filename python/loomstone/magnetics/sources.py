"""Magnets and currents as objects at poses.

Every function returns a `MagneticBody` whose centre lies at the origin and whose axes are those of
the world (meshes and polylines: where their vertices are); `body.moved(by)`, `body.rotated(by)` and
`body.at(position, orientation)` give copies.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import MagneticBody, TriangleMesh
from ..base.arguments import takes

__all__ = [
    "Bodies",
    "as_list",
    "box_of",
    "cuboid",
    "cylinder",
    "dipoles",
    "loop",
    "mesh",
    "polyline",
    "solenoid",
    "sphere",
]

Floats = NDArray[np.float64]
Bodies = MagneticBody | Sequence[MagneticBody]


def as_list(bodies: Bodies) -> list[MagneticBody]:
    """One body or several as a list."""
    return [bodies] if isinstance(bodies, MagneticBody) else list(bodies)


def box_of(bodies: list[MagneticBody]) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates (3), (3) [m] of the balls about bodies."""
    places, radii = np.array([b.position for b in bodies]), np.array([b.radius for b in bodies])
    return (places - radii[:, None]).min(axis=0), (places + radii[:, None]).max(axis=0)


@takes(size="m", polarization="T")
def cuboid(*, size: ArrayLike, polarization: ArrayLike) -> MagneticBody:
    """Cuboid magnet: edges `size` (3) [m], polarization J = mu0 M (3) [T] in its own axes."""
    return _core.magnetic_cuboid(size=size, polarization=polarization)


@takes(radius="m", height="m", polarization="T", inner_radius="m")
def cylinder(
    *, radius: float, height: float, polarization: ArrayLike, inner_radius: float = 0.0
) -> MagneticBody:
    """Cylinder magnet about its z axis, a ring where inner_radius > 0: lengths [m], polarization J
    (3) [T], any direction.
    """
    return _core.magnetic_cylinder(
        radius=radius, height=height, polarization=polarization, inner_radius=inner_radius
    )


@takes(radius="m", polarization="T")
def sphere(*, radius: float, polarization: ArrayLike) -> MagneticBody:
    """Spherical magnet: radius [m], polarization J (3) [T]."""
    return _core.magnetic_sphere(radius=radius, polarization=polarization)


@takes(polarization="T")
def mesh(mesh: TriangleMesh, *, polarization: ArrayLike) -> MagneticBody:
    """Magnet of any shape inside a closed `TriangleMesh` [m]; its centre is that of the volume.

    Polarization J (3) [T].
    """
    return _core.magnetic_mesh(mesh, polarization=polarization)


@takes(points="m", moments="A m^2")
def dipoles(points: ArrayLike, moments: ArrayLike) -> MagneticBody:
    """Point dipoles moments (n, 3) [A m^2] at points (n, 3) [m] in the body's axes."""
    return _core.magnetic_dipoles(points, moments)


@takes(radius="m", turns="1", current="A")
def loop(*, radius: float, turns: float = 1.0, current: float = 1.0) -> MagneticBody:
    """Circular loop in z = 0: radius [m], number of turns [1], current of each [A]
    counter-clockwise seen from +z.
    """
    return _core.magnetic_loop(radius=radius, turns=turns, current=current)


@takes(radius="m", length="m", turns="1", current="A")
def solenoid(*, radius: float, length: float, turns: float, current: float = 1.0) -> MagneticBody:
    """Ideal solenoid about z, a sheet of current: radius, length [m], number of turns [1], current
    of each [A].
    """
    return _core.magnetic_solenoid(radius=radius, length=length, turns=turns, current=current)


@takes(vertices="m", current="A")
def polyline(vertices: ArrayLike, *, current: float) -> MagneticBody:
    """Straight conductors between vertices (n, 3) [m], current [A] from the first to the last;
    closed where these are equal.

    The body's centre is the mean of the vertices.
    """
    return _core.magnetic_polyline(vertices, current=current)
