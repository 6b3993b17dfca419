"""Obstacles of common shapes or from meshes, static or moved by keyframes.

The default names are sphere, box, capsule, funnel, bar and floor. If several surfaces of a scene
have such a name, the scene appends numbers in the order of its obstacles: sphere, sphere_2,
sphere_3. Names that the user gives are not changed, and must differ.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import meshes
from .._core import InvalidInput, Look, Obstacle, TriangleMesh
from ..base.arguments import takes, vector

__all__ = ["box", "capsule", "floor", "funnel", "mesh", "sphere", "wave_bar"]

_DEFAULT = Obstacle()


@takes(centre="m", times="s", positions="m", axis_angles="rad", friction="1", thickness="m")
def mesh(
    mesh: TriangleMesh,
    *,
    name: str = "",
    centre: ArrayLike = (0.0, 0.0, 0.0),
    times: ArrayLike = (),
    positions: ArrayLike | None = None,
    axis_angles: ArrayLike | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Obstacle from any mesh.

    mesh : surface in its own frame. Without keyframes, its origin is placed at `centre` [m].
    times : (k) times of keyframes [s], ascending
    positions : (k x 3) positions of the mesh's origin [m]; default: `centre` at all times
    axis_angles : (k x 3) rotation vectors at the times of the keyframes [rad]
    friction : friction coefficient [1]
    thickness : contact distance [m]; 0: the largest thickness of a cloth, or 1 mm without cloth
    look : Look, the colour and texture of the obstacle in pictures

    Without `times`, the vertices themselves are moved by `centre`, and the frame of the obstacle is
    the world frame, so magnets on it are placed relative to the world's origin. With keyframes,
    even with a single one, the frame of the obstacle follows them, and magnets on it are placed
    relative to this frame.

    Raises InvalidInput if positions or axis_angles are given without times.
    """
    times = np.asarray(times, float).ravel()
    settings: dict[str, Any] = {
        "name": name,
        "friction": friction,
        "thickness": thickness,
        "look": look,
    }
    if len(times) == 0:
        if positions is not None or axis_angles is not None:
            raise InvalidInput(
                f"obstacle {name!r}: positions and axis_angles require times [s], got none; give"
                " one time per row"
            )
        return Obstacle(mesh=mesh.moved(vector("centre", centre, 3)), **settings)
    if positions is None:
        positions = np.broadcast_to(vector("centre", centre, 3), (len(times), 3))
    settings["positions"] = np.asarray(positions, float)
    if axis_angles is not None:
        settings["axis_angles"] = np.asarray(axis_angles, float)
    return Obstacle(mesh=mesh, times=times, **settings)


def _named(surface: TriangleMesh, name: str | None, default: str, **settings: Any) -> Obstacle:
    """Returns an obstacle called `name` or, if that is None, `default`.

    Scenes append a number to the default name if another surface has it.
    """
    obstacle = mesh(surface, name=default if name is None else name, **settings)
    return obstacle.replace(numbered=name is None)


@takes(
    radius="m",
    centre="m",
    times="s",
    positions="m",
    axis_angles="rad",
    friction="1",
    thickness="m",
)
def sphere(
    *,
    radius: float,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    subdivisions: int = 4,
    name: str | None = None,
    times: ArrayLike = (),
    positions: ArrayLike | None = None,
    axis_angles: ArrayLike | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Sphere; lengths in [m], keyframes as in `mesh`.

    name : default: "sphere"; if it is taken, scenes append a number: "sphere_2"

    >>> sphere(radius=0.15).mesh.closed
    True
    """
    surface = meshes.sphere(radius=radius, subdivisions=subdivisions)
    return _named(
        surface,
        name,
        "sphere",
        centre=centre,
        times=times,
        positions=positions,
        axis_angles=axis_angles,
        friction=friction,
        thickness=thickness,
        look=look,
    )


@takes(
    size="m", centre="m", times="s", positions="m", axis_angles="rad", friction="1", thickness="m"
)
def box(
    *,
    size: tuple[float, float, float],
    centre: ArrayLike = (0.0, 0.0, 0.0),
    name: str | None = None,
    times: ArrayLike = (),
    positions: ArrayLike | None = None,
    axis_angles: ArrayLike | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Box with edge lengths `size` [m]; keyframes as in `mesh`."""
    return _named(
        meshes.box(size=size),
        name,
        "box",
        centre=centre,
        times=times,
        positions=positions,
        axis_angles=axis_angles,
        friction=friction,
        thickness=thickness,
        look=look,
    )


@takes(
    radius="m",
    length="m",
    centre="m",
    axis="1",
    times="s",
    positions="m",
    axis_angles="rad",
    friction="1",
    thickness="m",
)
def capsule(
    *,
    radius: float,
    length: float,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    axis: ArrayLike = (0.0, 0.0, 1.0),
    segments: int = 32,
    name: str | None = None,
    times: ArrayLike = (),
    positions: ArrayLike | None = None,
    axis_angles: ArrayLike | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Capsule along `axis`; lengths in [m], keyframes as in `mesh`.

    length : distance between the centres of its caps [m]
    """
    surface = meshes.capsule(radius=radius, length=length, segments=segments)
    surface = surface.moved((0, 0, 0), rotation=_rotation_to(vector("axis", axis, 3)))
    return _named(
        surface,
        name,
        "capsule",
        centre=centre,
        times=times,
        positions=positions,
        axis_angles=axis_angles,
        friction=friction,
        thickness=thickness,
        look=look,
    )


@takes(
    top_radius="m",
    bottom_radius="m",
    height="m",
    tube_length="m",
    wall="m",
    centre="m",
    friction="1",
    thickness="m",
)
def funnel(
    *,
    top_radius: float,
    bottom_radius: float,
    height: float,
    tube_length: float,
    wall: float,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    segments: int = 64,
    name: str | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Funnel: a truncated cone of height `height` on a tube of length `tube_length`.

    `wall` is the thickness of the walls. The radii are those of the inner surface. Lengths are in
    [m].

    centre : position of the centre of the circle in which cone and tube meet [m]
    """
    surface = meshes.funnel(
        top_radius=top_radius,
        bottom_radius=bottom_radius,
        height=height,
        tube_length=tube_length,
        wall=wall,
        segments=segments,
    )
    return _named(
        surface, name, "funnel", centre=centre, friction=friction, thickness=thickness, look=look
    )


@takes(
    length="m", radius="m", amplitude="m", wavelength="m", centre="m", friction="1", thickness="m"
)
def wave_bar(
    *,
    length: float,
    radius: float,
    amplitude: float,
    wavelength: float,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    segments: int = 24,
    name: str | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Bar along y with hemispherical ends; lengths in [m].

    Its centre line is z = amplitude cos(2 pi y / wavelength) for |y| <= length / 2, relative to
    `centre`. `length` does not include the ends.
    """
    surface = meshes.wave_bar(
        length=length, radius=radius, amplitude=amplitude, wavelength=wavelength, segments=segments
    )
    return _named(
        surface, name, "bar", centre=centre, friction=friction, thickness=thickness, look=look
    )


@takes(height="m", size="m", friction="1", thickness="m")
def floor(
    *,
    height: float = 0.0,
    size: float = 4.0,
    cells: int = 8,
    name: str | None = None,
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Square with edges `size` [m] in the plane z = `height` [m], drawn as ground.

    look : Look. A texture is mapped by x and y [m]: `texture_width` is the width of a tile
        [m], and (0, 0) is a corner of a tile. With `texture_width=0`, the image covers the square
        once. Pictures show the plane beyond the square too, where the image repeats.
    """
    return _named(
        meshes.floor(size=size, cells=cells),
        name,
        "floor",
        centre=(0.0, 0.0, height),
        friction=friction,
        thickness=thickness,
        look=look,
    ).replace(floor=True)


def _rotation_to(
    axis: np.ndarray[Any, np.dtype[np.float64]],
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Returns a rotation matrix that maps the z axis to the direction of `axis`."""
    from scipy.spatial.transform import Rotation

    if not axis.any():
        raise InvalidInput("axis must have a direction, got (0, 0, 0)")
    rotation, _ = Rotation.align_vectors([axis / np.linalg.norm(axis)], [[0.0, 0.0, 1.0]])
    matrix: np.ndarray[Any, np.dtype[np.float64]] = rotation.as_matrix()
    return matrix
