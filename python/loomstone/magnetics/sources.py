"""Magnets and currents as objects with a pose.

`cuboid`, `loop` and so on return a `MagneticBody` at the origin, with axes along the world axes.
Meshes and polylines stay at the positions of their vertices. `body.moved(by)`, `body.rotated(by)`
and `body.at(position, orientation)` return copies.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import MagneticBody, SoftBody, TriangleMesh
from ..base.arguments import takes
from ..base.cautions import SceneWarning

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


# If a component of a polarization exceeds this magnitude [T], a warning is given. No material
# exceeds 2.5 T, and the margin allows for magnets that represent windings.
LARGEST_POLARIZATION = 5.0


def as_list(bodies: Bodies) -> list[MagneticBody]:
    """Returns one or several bodies as a list; raises TypeError unless each is a MagneticBody."""
    found = list(bodies) if isinstance(bodies, Iterable) else [bodies]
    for body in found:
        if isinstance(body, SoftBody):
            raise TypeError(
                f"magnets or currents are expected, got {body!r}, which has no field until induce()"
                " magnetises it"
            )
        if not isinstance(body, MagneticBody):
            raise TypeError(
                f"magnets or currents are expected, such as cuboid() or loop(), got {body!r}"
            )
    return found


def _check_polarization(polarization: ArrayLike) -> None:
    """Warns of a polarization that looks as if it were in mT or A/m."""
    value = float(np.max(np.abs(np.asarray(polarization, float)), initial=0.0))
    if value > LARGEST_POLARIZATION:
        warnings.warn(
            f"a polarization of {value:g} T is larger than that of any material (2.5 T); it is"
            " J = mu0 M in tesla, neither in mT nor the magnetization M in A/m",
            SceneWarning,
            stacklevel=4,  # the caller of the decorated function
        )


def box_of(bodies: list[MagneticBody]) -> tuple[Floats, Floats]:
    """Returns the lower and upper corners, each (3) [m], of the box around all bounding spheres."""
    places, radii = np.array([b.position for b in bodies]), np.array([b.radius for b in bodies])
    return (places - radii[:, None]).min(axis=0), (places + radii[:, None]).max(axis=0)


@takes(size="m", polarization="T")
def cuboid(*, size: ArrayLike, polarization: ArrayLike) -> MagneticBody:
    """Cuboid magnet: edges `size` (3) [m], polarization J = mu0 M (3) [T] in its own axes."""
    _check_polarization(polarization)
    return _core.magnetic_cuboid(size=size, polarization=polarization)


@takes(radius="m", height="m", polarization="T", inner_radius="m")
def cylinder(
    *, radius: float, height: float, polarization: ArrayLike, inner_radius: float = 0.0
) -> MagneticBody:
    """Cylinder magnet about its z axis, or a ring if inner_radius > 0.

    Lengths are in [m]. The polarization J (3) [T] may have any direction.
    """
    _check_polarization(polarization)
    return _core.magnetic_cylinder(
        radius=radius, height=height, polarization=polarization, inner_radius=inner_radius
    )


@takes(radius="m", polarization="T")
def sphere(*, radius: float, polarization: ArrayLike) -> MagneticBody:
    """Spherical magnet: radius [m], polarization J (3) [T]."""
    _check_polarization(polarization)
    return _core.magnetic_sphere(radius=radius, polarization=polarization)


@takes(polarization="T")
def mesh(mesh: TriangleMesh, *, polarization: ArrayLike) -> MagneticBody:
    """Magnet bounded by a closed `TriangleMesh` [m]: polarization J (3) [T].

    The centre of the body is the centroid of its volume.
    """
    _check_polarization(polarization)
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
    """Straight conductors between consecutive vertices (n, 3) [m], with a current [A].

    The current flows from the first vertex to the last. If these are equal, the polyline is closed.
    The centre of the body is the mean of the vertices.
    """
    return _core.magnetic_polyline(vertices, current=current)
