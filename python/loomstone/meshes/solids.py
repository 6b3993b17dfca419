"""Meshes of solids and of the square floor.

They are centred at the origin, except the funnel and the wave bar; see funnel() and wave_bar().
"""

from __future__ import annotations

from .. import _core
from .._core import TriangleMesh
from ..base.arguments import takes, vector

__all__ = ["box", "capsule", "cylinder", "floor", "funnel", "sphere", "wave_bar"]


@takes(radius="m")
def sphere(*, radius: float, subdivisions: int = 4) -> TriangleMesh:
    """Icosphere with 20 * 4**subdivisions triangles; radius [m]."""
    return _core.icosphere(radius, subdivisions=subdivisions)


@takes(size="m")
def box(*, size: tuple[float, float, float], cells_per_side: int = 1) -> TriangleMesh:
    """Box with edge lengths `size` [m]."""
    return _core.box(*vector("size", size, 3), cells_per_side=cells_per_side)


@takes(radius="m", length="m")
def capsule(*, radius: float, length: float, segments: int = 32) -> TriangleMesh:
    """Capsule along z; `length` is the distance between the centres of its caps [m]."""
    return _core.capsule(radius, length, segments=segments)


@takes(radius="m", length="m")
def cylinder(*, radius: float, length: float, segments: int = 32) -> TriangleMesh:
    """Cylinder along z: a prism with `segments` sides, whose vertices lie on the cylinder.

    Lengths are in [m]. A rigid body with this mesh collides with other bodies as an exact
    polyhedron if there are at most 16 sides, and with obstacles if there are at most 256.
    """
    return _core.cylinder(radius, length, segments=segments)


@takes(top_radius="m", bottom_radius="m", height="m", tube_length="m", wall="m")
def funnel(
    *,
    top_radius: float,
    bottom_radius: float,
    height: float,
    tube_length: float,
    wall: float,
    segments: int = 64,
) -> TriangleMesh:
    """Closed surface of a funnel whose walls have a thickness `wall`; lengths in [m].

    Its inner surface is a cone from top_radius at z = height to bottom_radius at z = 0, and below
    z = 0 a tube of length tube_length.
    """
    return _core.funnel(top_radius, bottom_radius, height, tube_length, wall, segments=segments)


@takes(length="m", radius="m", amplitude="m", wavelength="m")
def wave_bar(
    *, length: float, radius: float, amplitude: float, wavelength: float, segments: int = 24
) -> TriangleMesh:
    """Bar along y with hemispherical ends; lengths in [m].

    Its centre line is z = amplitude cos(2 pi y / wavelength) for |y| <= length / 2. `length` does
    not include the ends.
    """
    return _core.wave_bar(length, radius, amplitude, wavelength, segments=segments)


@takes(size="m")
def floor(*, size: float = 4.0, cells: int = 8) -> TriangleMesh:
    """Square in the plane z = 0 with normal +z and edges `size` [m]; not a closed surface.

    Its texture coordinates (uv) are x and y [m].
    """
    return _core.floor_square(size, cells=cells)
