"""Bodies and obstacles that look like a mistake: overlaps, reversed surfaces, wrong units."""

from __future__ import annotations

import numpy as np

from .. import _core
from .._core import Scene, TriangleMesh
from .surfaces import Surface, item

__all__ = ["of_overlaps", "of_reversed", "of_sizes", "reversed_obstacles"]

# Largest plausible extent of a closed surface [m]. The value is our choice.
LARGEST = 50.0
# Largest number of overlaps that are listed.
MOST_LISTED = 3
# Largest number of vertices of a cloth that are tested against a reversed surface.
MOST_TESTED = 200


def of_sizes(scene: Scene) -> list[str]:
    """Returns one sentence for each closed body or obstacle whose mesh is larger than LARGEST."""
    found = []
    named = [(item("bodies", i, b.name), b.mesh) for i, b in enumerate(scene.bodies)]
    named += [(item("obstacles", i, o.name), o.mesh) for i, o in enumerate(scene.obstacles)]
    for name, mesh in named:
        size = float(np.ptp(np.asarray(mesh.vertices), axis=0).max())
        if mesh.closed and size > LARGEST:
            found.append(
                f"{name}: its mesh is {size:.4g} m long; if its file is in millimetres, scale it by"
                " 0.001"
            )
    return found


def of_overlaps(surfaces: list[Surface], pairs: list[tuple[int, int]]) -> list[str]:
    """Returns a sentence for each of the first MOST_LISTED overlaps, and one for all others.

    pairs : pairs of overlapping surfaces, as indices into `surfaces`
    """
    found = [
        f"{surfaces[a].name} and {surfaces[b].name} overlap at the start, so contacts drive them"
        " apart suddenly; move one of them"
        for a, b in pairs[:MOST_LISTED]
    ]
    if more := len(pairs) - len(found):
        found.append(f"{more} more pairs of bodies and obstacles overlap at the start")
    return found


def reversed_obstacles(scene: Scene) -> list[int]:
    """Returns the indices of the closed obstacles whose triangles face inwards."""
    return [
        i
        for i, obstacle in enumerate(scene.obstacles)
        if obstacle.mesh.closed and _volume(obstacle.mesh) < 0.0
    ]


def of_reversed(scene: Scene, surfaces: list[Surface], obstacles: list[int]) -> list[str]:
    """Returns one sentence for each reversed obstacle inside which a vertex of cloth starts.

    Tests at most MOST_TESTED of the vertices of each cloth that lie in the obstacle's bounding box.

    surfaces : those of all bodies, followed by those of all obstacles
    obstacles : indices of the reversed obstacles
    """
    found = []
    for index in obstacles:
        surface = surfaces[len(scene.bodies) + index]
        low, high = surface.points.min(axis=0), surface.points.max(axis=0)
        query = _core.SpatialQuery(TriangleMesh(surface.points, surface.mesh.triangles[:, ::-1]))
        for i, cloth in enumerate(scene.cloths):
            x = np.asarray(cloth.mesh.vertices)
            near = x[np.all((x > low) & (x < high), axis=1)]
            if any(query.inside(p) for p in near[:: 1 + len(near) // MOST_TESTED]):
                found.append(
                    f"{surface.name} is closed but faces inwards (its volume is negative), and"
                    f" {item('cloths', i, cloth.name)} starts inside; reverse the order of the"
                    " vertices in its triangles, and move the cloth out"
                )
                break
    return found


def _volume(mesh: TriangleMesh) -> float:
    """Returns the signed volume of a closed surface [m^3], positive if its triangles face out."""
    points = np.asarray(mesh.vertices) - np.asarray(mesh.vertices).mean(axis=0)
    a, b, c = (points[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
