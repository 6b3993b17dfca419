"""Surfaces of rigid bodies and obstacles at the start of a scene, and the pairs that overlap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Scene, TriangleMesh

__all__ = ["Surface", "item", "overlapping_pairs", "start_surfaces"]

Floats = NDArray[np.float64]

# Surfaces that intersect count as overlapping if they still intersect after each has shrunk by this
# fraction of its size, about the centre of its bounding box. The value is our choice. It excludes
# surfaces that touch, and round surfaces that intersect only because their meshes have flat facets.
SHRINKAGE = 0.02
# Largest number of surfaces that are tested for intersections, to bound the time of the test.
MOST_TESTED = 1000


@dataclass(frozen=True)
class Surface:
    """A surface and the positions of its vertices at the start of a scene.

    name : name in messages
    mesh : mesh with vertices in the surface's own frame
    points : (n x 3) positions of the vertices at the start [m]
    free : True for a rigid body, False for an obstacle
    """

    name: str
    mesh: TriangleMesh
    points: Floats
    free: bool

    def placed(self, local: Floats) -> Floats:
        """Returns the world positions at the start (k x 3) of points in the mesh's frame [m].

        The rotation is the best fit (Kabsch), which is exact for a surface that does not deform.
        """
        vertices = np.asarray(self.mesh.vertices)
        middle, centre = vertices.mean(axis=0), self.points.mean(axis=0)
        left, _, right = np.linalg.svd((vertices - middle).T @ (self.points - centre))
        handed = np.diag((1.0, 1.0, np.sign(np.linalg.det(left @ right))))
        return np.asarray((local - middle) @ (left @ handed @ right) + centre)


def item(kind: str, index: int, name: str) -> str:
    """Returns the name in messages of an entry of a list of the scene, such as cloths[0] ("a")."""
    return f'{kind}[{index}] ("{name}")' if name else f"{kind}[{index}]"


def start_surfaces(scene: Scene, simulation: Any) -> list[Surface]:
    """Returns the surfaces at the start: those of all bodies, then those of all obstacles."""
    points = simulation.frame().body_vertices
    named = [(item("bodies", i, b.name), b.mesh, True) for i, b in enumerate(scene.bodies)]
    named += [(item("obstacles", i, o.name), o.mesh, False) for i, o in enumerate(scene.obstacles)]
    surfaces, first = [], 0
    for name, mesh, free in named:
        surfaces.append(Surface(name, mesh, points[first : first + mesh.n_vertices], free))
        first += mesh.n_vertices
    return surfaces


def overlapping_pairs(surfaces: list[Surface]) -> list[tuple[int, int]]:
    """Returns the pairs of overlapping surfaces of which at least one is `free`, as indices.

    Two surfaces overlap if they intersect both at full size and after shrinking by SHRINKAGE, or if
    one contains the other. A closed surface contains another if its bounding box contains that of
    the other, and the first vertex of the other lies inside. Only the first MOST_TESTED surfaces
    whose bounding box overlaps that of another, at least one of the two being `free`, are tested
    for intersections.
    """
    if not any(surface.free for surface in surfaces):
        return []
    low, high = (
        np.array([extreme(surface.points, axis=0) for surface in surfaces])
        for extreme in (np.min, np.max)
    )
    free = np.array([surface.free for surface in surfaces])
    near = np.zeros(len(surfaces), bool)  # box overlaps that of another; one or both are free
    pairs = set()
    for a, surface in enumerate(surfaces):
        boxes = np.all((low <= high[a]) & (high >= low[a]), axis=1) & (free | surface.free)
        boxes[a] = False
        near |= boxes
        within = boxes & np.all((low >= low[a]) & (high <= high[a]), axis=1)
        for b in np.flatnonzero(within) if surface.mesh.closed else ():
            if _inside(surface, surfaces[b]):
                pairs.add((min(a, int(b)), max(a, int(b))))
    close = [int(i) for i in np.flatnonzero(near)[:MOST_TESTED]]
    if close:
        chosen = [surfaces[i] for i in close]
        crossing = _intersecting(chosen) & _intersecting([_shrunk(each) for each in chosen])
        pairs |= {(close[a], close[b]) for a, b in crossing}
    return sorted(pairs)


def _shrunk(surface: Surface) -> Surface:
    centre = 0.5 * (surface.points.min(axis=0) + surface.points.max(axis=0))
    points = centre + (1.0 - SHRINKAGE) * (surface.points - centre)
    return Surface(surface.name, surface.mesh, points, surface.free)


def _intersecting(surfaces: list[Surface]) -> set[tuple[int, int]]:
    """Returns the pairs of intersecting surfaces of which at least one is `free`, as indices."""
    first = np.cumsum([0, *(len(surface.points) for surface in surfaces)])
    faces = [s.mesh.triangles + start for s, start in zip(surfaces, first, strict=False)]
    owner = np.repeat(np.arange(len(surfaces)), [len(each) for each in faces])
    free = np.array([surface.free for surface in surfaces])
    points = np.concatenate([surface.points for surface in surfaces])
    found = np.array(_core.intersecting_pairs(points, np.concatenate(faces)), int).reshape(-1, 2)
    owners = owner[found]
    apart = (owners[:, 0] != owners[:, 1]) & free[owners].any(axis=1)
    return {(int(a), int(b)) for a, b in np.unique(np.sort(owners[apart], axis=1), axis=0)}


def _inside(outer: Surface, inner: Surface) -> bool:
    """Returns whether the first vertex of `inner` lies inside the closed surface `outer`."""
    query = _core.SpatialQuery(TriangleMesh(outer.points, outer.mesh.triangles))
    return query.inside(inner.points[0])
