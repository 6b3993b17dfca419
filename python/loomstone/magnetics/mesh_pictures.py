"""Pictures of magnets given as meshes, for `loomstone field` and `loomstone plot`.

The pictures show the field lines of one magnet, or plot the force or torque between two.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import (
    Camera,
    InvalidInput,
    Magnet,
    MagneticBody,
    RenderOptions,
    RigidBody,
    Scene,
    TriangleMesh,
)
from ..meshes import read
from . import figures, lines, sources

__all__ = ["curve_of_meshes", "draw_field"]


def numbers(text: str, name: str) -> tuple[float, float, float]:
    """Parses three numbers separated by commas, such as `0,0,1`."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput(f"{name} must be three numbers like 0,0,1, got {text!r}") from None
    return x, y, z


def draw_field(
    mesh: TriangleMesh,
    polarization: tuple[float, float, float],
    path: Path,
    *,
    n_lines: int = 150,
    eye: tuple[float, float, float] = (0.6, -1.0, 0.35),
    width: int = 1280,
    height: int = 960,
) -> tuple[Path, lines.FieldLines]:
    """Draws a closed mesh [m] with uniform polarization J = mu0 M [T], and its field lines.

    Returns the path of the picture (PNG) and the lines.
    """
    magnet = Magnet(body="magnet", source=sources.mesh(mesh, polarization=polarization))
    simulation = _core.Simulation(
        Scene(bodies=[RigidBody(name="magnet", mesh=mesh)], magnets=[magnet])
    )
    frame = simulation.frame()
    body = simulation.magnets(frame)[0]
    found = lines.field_lines(
        body, n_lines, tolerance=1e-4, extent=2.6 * body.radius, centre=body.position
    )
    direction = np.asarray(eye) / np.linalg.norm(eye)
    camera = Camera(
        fit=False,
        eye=body.position + 5.6 * body.radius * direction,
        target=body.position,
        field_of_view_degrees=40.0,
    )
    options = RenderOptions(width=width, height=height, camera=camera)
    picture = _core.Renderer(simulation.topology, options).render(
        frame, lines.curves_of(found, 0.009 * body.radius)
    )
    _core.write_png(str(path), picture)
    return path, found


def magnet_of(path: Path, polarization: tuple[float, float, float]) -> MagneticBody:
    """Returns a magnet with the shape of the closed mesh in a file."""
    return sources.mesh(read(path, with_uv=False), polarization=polarization)


def curve_of_meshes(
    kind: str,
    meshes: list[Path],
    polarization: tuple[float, float, float],
    axis: tuple[float, float, float],
    reach: float,
    path: Path,
) -> Path:
    """Plots force against distance, or torque against angle, of two magnets given by their meshes.

    If only one mesh is given, both magnets have its shape. Both have the same polarization [T]. For
    forces, the first magnet starts next to the second one along `axis`, at a gap of 1e-6 of its own
    bounding radius, and moves away by up to `reach` [m] (0: the bounding radius of the second). For
    torques, the first magnet is placed far enough away to turn freely, and turns once about an axis
    perpendicular to `axis`.
    """
    if not 1 <= len(meshes) <= 2:
        raise InvalidInput(
            f"curves of {kind} need one or two meshes, got {len(meshes)}; give --mesh FILE"
        )
    if not 0 <= reach < np.inf:
        raise InvalidInput(f"--reach must be at least 0 m and finite, got {reach:g}")
    on, by = magnet_of(meshes[0], polarization), magnet_of(meshes[-1], polarization)
    along = figures.unit(axis)
    apart = _reach(read(meshes[-1], with_uv=False), by, along) + _reach(
        read(meshes[0], with_uv=False), on, -along
    )
    place = by.position + (apart + 1e-6 * on.radius) * along
    on = on.at(place, on.orientation)
    if kind == "force":
        distances = np.linspace(0.0, 1.0, 41) ** 2 * (reach or by.radius)
        return figures.plot_curve(
            figures.force_over_distance(on, by, distances, axis=along, tolerance=1e-3), path
        )
    across = np.cross(along, (0.0, 0.0, 1.0) if abs(along[2]) < 0.9 else (1.0, 0.0, 0.0))
    on = on.moved((on.radius + by.radius - apart) * along)  # far enough away to turn freely
    return figures.plot_curve(
        figures.torque_over_angle(
            on, by, np.linspace(0.0, 2.0 * np.pi, 49), axis=across, tolerance=1e-3
        ),
        path,
        kind="torque",
    )


def _reach(mesh: TriangleMesh, body: MagneticBody, along: NDArray[np.float64]) -> float:
    """Returns the extent of a mesh from the centre of its body along a direction [m]."""
    return float(((mesh.vertices - body.position) @ along).max())
