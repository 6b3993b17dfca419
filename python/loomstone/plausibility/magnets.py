"""Magnets that look like a mistake: magnets that protrude from their bodies, or overlap."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core, meshes
from .._core import Scene, TriangleMesh
from .surfaces import Surface, overlapping_pairs

__all__ = ["of_magnets"]

# A magnet may protrude from the mesh of its body by this fraction of its own size without a
# warning, because a round magnet with the radius of its body protrudes slightly from a mesh with
# few facets. The value is our choice.
REACH = 0.1
# Largest number of points of a magnet that are compared with the mesh of its body.
MOST_TESTED = 200
# Number of sides of the prism that approximates a hollow cylinder.
SIDES = 32


def of_magnets(scene: Scene, surfaces: list[Surface], pairs: list[tuple[int, int]]) -> list[str]:
    """Returns one sentence for each magnet that protrudes from its body or obstacle by more than
    REACH allows, and one for each pair of overlapping magnets if at least one is on a rigid body.

    surfaces : those of all bodies, followed by those of all obstacles
    pairs : pairs of overlapping surfaces; overlaps of a magnet on one with a magnet on the other
        are not reported
    """
    names = [*(body.name for body in scene.bodies), *(each.name for each in scene.obstacles)]
    carriers = {name: index for index, name in enumerate(names)}
    found, placed, owners = [], [], []
    # For equal magnets on carriers (bodies or obstacles) that share a mesh, the magnet's mesh and
    # its protrusion are computed only once. The keys contain addresses of meshes. These addresses
    # stay unique, because the stored states and `surfaces` keep the meshes alive.
    known: dict[Any, tuple[TriangleMesh | None, float, Any]] = {}
    for i, magnet in enumerate(scene.magnets):
        owner = carriers[magnet.body]
        carrier = surfaces[owner]
        source: Any = magnet.source
        state = source.__getstate__()
        key = (id(carrier.mesh), id(state[0][2]), repr(state))
        if key not in known:
            shape = _mesh_of(state)
            known[key] = shape, 0.0 if shape is None else _reach(shape, carrier.mesh), state
        mesh, reach, _ = known[key]
        if mesh is None:
            continue
        name = f"magnets[{i}]"
        if reach > 0.0:
            found.append(
                f"{name} reaches {1e3 * reach:.3g} mm out of its body, {carrier.name}; sizes and"
                " position of a magnet are in metres, in the frame of the body's mesh"
            )
        points = carrier.placed(np.asarray(mesh.vertices))
        placed.append(Surface(name, mesh, points, carrier.free))
        owners.append(owner)
    for a, b in overlapping_pairs(placed):
        one, other = sorted((owners[a], owners[b]))
        if one == other:
            found.append(
                f"{placed[a].name} and {placed[b].name} on {surfaces[one].name} overlap, so their"
                " polarizations add up there; move or shorten one of them"
            )
        if one == other or (one, other) in pairs:
            continue
        found.append(
            f"{placed[a].name} on {surfaces[owners[a]].name} and {placed[b].name} on"
            f" {surfaces[owners[b]].name} overlap at the start; move one of them"
        )
    return found


def _reach(magnet: TriangleMesh, body: TriangleMesh) -> float:
    """Returns how far a magnet protrudes from its body [m]; 0 if REACH allows it.

    Bodies whose mesh is not closed are not tested, and give 0.
    """
    if not body.closed:
        return 0.0
    points = np.asarray(magnet.vertices)
    query = _core.SpatialQuery(body)
    reach = max(
        0.0 if query.inside(point) else float(query.closest(point, 1e9).distance)
        for point in points[:: 1 + len(points) // MOST_TESTED]
    )
    return reach if reach > REACH * float(np.ptp(points, axis=0).max()) else 0.0


def _mesh_of(state: tuple[Any, ...]) -> TriangleMesh | None:
    """Returns a magnet's surface in the frame of its body or obstacle; None for dipoles and cells.

    state : the recipe of the magnet and its pose, as pickle stores them
    """
    mesh: TriangleMesh
    (kind, values, mesh, _), position, orientation, *_ = state
    known = dict(values)
    shape = kind.removeprefix("soft_")
    if shape == "cuboid":
        mesh = meshes.box(size=tuple(known["size"]))
    elif shape == "cylinder":
        mesh = _ring(known["radius"], known.get("inner_radius", 0.0), known["height"])
    elif shape == "sphere":
        mesh = meshes.sphere(radius=known["radius"], subdivisions=2)
    elif shape != "mesh":
        return None
    return mesh.moved(position, rotation=_rotation(orientation))


def _ring(radius: float, inner_radius: float, height: float) -> TriangleMesh:
    """Returns the surface of a cylinder along z with a hole of `inner_radius`, which may be 0."""
    if inner_radius <= 0.0:
        return meshes.cylinder(radius=radius, length=height)
    angles, half = 2.0 * np.pi * np.arange(SIDES) / SIDES, 0.5 * height
    profile = [(inner_radius, -half), (radius, -half), (radius, half), (inner_radius, half)]
    vertices = [(r * np.cos(a), r * np.sin(a), z) for r, z in profile for a in angles]
    triangles = []
    for k in range(4):
        for i in range(SIDES):
            near, far = k * SIDES, (k + 1) % 4 * SIDES
            a, b, c, d = near + i, near + (i + 1) % SIDES, far + i, far + (i + 1) % SIDES
            triangles += [(a, b, d), (a, d, c)]
    return TriangleMesh(np.array(vertices), np.array(triangles))


def _rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the rotation (3 x 3) of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
    )
