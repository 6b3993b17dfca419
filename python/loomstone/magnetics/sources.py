"""Magnets and currents as objects with a pose.

Every function returns a `MagneticBody` centred at the origin, with its axes along the world axes.
Meshes and polylines stay at the positions of their vertices. `body.moved(by)`, `body.rotated(by)`
and `body.at(position, orientation)` return copies.
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
    """Returns one or several bodies as a list."""
    return [bodies] if isinstance(bodies, MagneticBody) else list(bodies)


def box_of(bodies: list[MagneticBody]) -> tuple[Floats, Floats]:
    """Returns the lower and upper corners (3), (3) [m] of the box around all bounding spheres."""
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
    """Cylinder magnet about its z axis, or a ring if inner_radius > 0.

    Lengths are in [m]. The polarization J (3) [T] may have any direction.
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
    """Magnet bounded by a closed `TriangleMesh` [m]: polarization J (3) [T].

    The centre of the body is the centroid of its volume.
    """
    return _core.magnetic_mesh(mesh, polarization=polarization)


@takes(points="m", moments="A m^2")
def dipoles(points: ArrayLike, moments: ArrayLike) -> MagneticBody:
    """Point dipoles with moments (n, 3) [A m^2] at points (n, 3) [m] in the body's axes."""
    return _core.magnetic_dipoles(points, moments)


@takes(radius="m", turns="1", current="A")
def loop(*, radius: float, turns: float = 1.0, current: float = 1.0) -> MagneticBody:
    """Circular loop in the plane z = 0: radius [m], number of turns [1], current of each turn [A].

    The current flows counter-clockwise as seen from +z.
    """
    return _core.magnetic_loop(radius=radius, turns=turns, current=current)


@takes(radius="m", length="m", turns="1", current="A")
def solenoid(*, radius: float, length: float, turns: float, current: float = 1.0) -> MagneticBody:
    """Ideal solenoid (current sheet) about z: radius and length [m], number of turns [1], current
    of each turn [A].
    """
    return _core.magnetic_solenoid(radius=radius, length=length, turns=turns, current=current)


@takes(vertices="m", current="A")
def polyline(vertices: ArrayLike, *, current: float) -> MagneticBody:
    """Straight conductors between vertices (n, 3) [m] that carry a current [A].

    The current flows from the first vertex to the last. The polyline is closed if these are equal.
    The centre of the body is the mean of the vertices.
    """
    return _core.magnetic_polyline(vertices, current=current)
