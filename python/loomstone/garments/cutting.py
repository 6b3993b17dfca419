"""Triangulates panels for sewing, with equal numbers of points on the two edges of each seam."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .edges import Edge
from .joined_edges import without_joined_edges
from .panel import Panel
from .seams import Pattern, Seam, merged, turned_panels
from .triangulation import Boundary, triangulated

__all__ = ["Cut", "cut"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SHELF = 0.05  # distance between neighbouring panels in the uv layout [m]


@dataclass(frozen=True, eq=False)
class Cut:
    """The triangulated panels before sewing, concatenated.

    flat : (n x 2) the panels laid out side by side [m]; weft is the first axis, warp the second
    placed : (n x 3) initial positions given by the placements of the panels [m]
    triangles : (m x 3) vertex indices
    panel_of_triangle : (m) index of the panel of each triangle
    pairs : (k x 2) pairs of vertices to be joined
    seam_of_pair : (k) index of the seam of each pair in the pattern
    groups : vertex indices by name: "panel" and "panel.edge" (in order along the edge)
    """

    pattern: Pattern
    flat: Floats
    placed: Floats
    triangles: Indices
    panel_of_triangle: Indices
    pairs: Indices
    seam_of_pair: Indices
    groups: Mapping[str, Indices]

    def __repr__(self) -> str:
        return f"Cut({len(self.pattern.panels)} panels, {len(self.triangles)} triangles)"


def cut(pattern: Pattern, *, spacing: float, triangles: int | None, seed: int) -> Cut:
    """Triangulates every panel with mesh edges of about `spacing` [m].

    triangles : approximate total number of triangles, distributed over the panels by area; None:
        determined by `spacing`
    seed : seed of the interior points
    """
    drawn, faces, owner, groups = _triangulated_panels(pattern, spacing, triangles, seed)
    ends = np.cumsum([0, *map(len, drawn)])
    placed = [_place(panel, points) for panel, points in zip(pattern.panels, drawn, strict=True)]
    pairs, seam_of_pair, reverse = _pairs(pattern, groups, np.concatenate(placed))
    mesh = without_joined_edges(np.concatenate(drawn), faces, merged(int(ends[-1]), pairs.tolist()))
    owner, faces = owner[mesh.origin], mesh.triangles
    panel_of_point = np.repeat(np.arange(len(drawn)), np.diff(ends))
    panel_of_point = np.r_[panel_of_point, np.zeros(len(mesh.points) - ends[-1], np.int64)]
    panel_of_point[faces] = owner[:, None]
    flat, places = np.empty((len(mesh.points), 2)), np.empty((len(mesh.points), 3))
    turned, shelf = turned_panels(pattern, reverse), 0.0
    for index, panel in enumerate(pattern.panels):
        own = groups[panel.name] = np.flatnonzero(panel_of_point == index)
        laid = panel.pattern(mesh.points[own])
        flat[own] = laid - laid.min(0) + (shelf, 0.0)
        shelf += float(np.ptp(laid[:, 0])) + SHELF
        places[own] = _place(panel, mesh.points[own])
        if turned[panel.name]:
            faces[owner == index] = faces[owner == index][:, ::-1]
    return Cut(pattern, flat, places, faces, owner, pairs, seam_of_pair, groups)


def _triangulated_panels(
    pattern: Pattern, spacing: float, triangles: int | None, seed: int
) -> tuple[list[Floats], Indices, Indices, dict[str, Indices]]:
    """Returns the vertices of each panel in its plane [m], and the concatenated triangles.

    Also returns the index of the panel of each triangle, and the vertex indices of each edge by the
    name "panel.edge".
    """
    segments = _segments(pattern, spacing)
    drawn, faces, owner = [], [], []
    groups: dict[str, Indices] = {}
    total = sum(panel.area for panel in pattern.panels)
    first, due = 0, 0.0
    for index, panel in enumerate(pattern.panels):
        loops = [_loop(panel.name, loop, segments) for loop in panel.loops]
        boundary = Boundary(loops)
        wanted = panel.area * (triangles / total if triangles else 4.0 / np.sqrt(3.0) / spacing**2)
        due += wanted
        interior = max(0, round((due - boundary.triangles(0)) / 2))
        points, panel_faces = triangulated(
            boundary, interior, seed=seed + index, where=f"panel {panel.name!r}"
        )
        due -= len(panel_faces)  # carry the rounding error over to the next panel
        start = first
        for edges, loop in zip(panel.loops, loops, strict=True):
            at = 0
            for edge in edges:
                name = f"{panel.name}.{edge.name}"
                groups[name] = start + np.arange(at, at + segments[name] + 1) % len(loop)
                at += segments[name]
            start += len(loop)
        drawn.append(points)
        faces.append(panel_faces + first)
        owner.append(np.full(len(panel_faces), index))
        first += len(points)
    return drawn, np.concatenate(faces), np.concatenate(owner), groups


def _place(panel: Panel, points: Floats) -> Floats:
    places = np.asarray(panel.place(points), float)
    if places.shape != (len(points), 3) or not np.isfinite(places).all():
        raise InvalidInput(f"panel {panel.name!r}: its place must return finite points (n x 3) [m]")
    return places


def _loop(panel: str, edges: Sequence[Edge], segments: Mapping[str, int]) -> Floats:
    """Returns the points along a closed loop of edges, each point once."""
    points = np.concatenate([edge.sampled(segments[f"{panel}.{edge.name}"])[:-1] for edge in edges])
    if len(points) < 3:
        raise InvalidInput(f"panel {panel!r} has only {len(points)} points; ask for more triangles")
    return points


def _segments(pattern: Pattern, spacing: float) -> dict[str, int]:
    """Returns the number of mesh edges on each edge of a panel, by the name "panel.edge"."""

    def least(edge: Edge) -> int:
        if edge.start == edge.end:
            return 6 if edge.kind == "circle" else max(3, len(edge.points) - 1)
        return 1 if edge.kind == "polyline" and len(edge.points) == 2 else 2

    partner = {seam.first: seam.second for seam in pattern.seams}
    partner |= {seam.second: seam.first for seam in pattern.seams}
    result = {}
    for panel in pattern.panels:
        for loop in panel.loops:
            names = [f"{panel.name}.{edge.name}" for edge in loop]
            for i, (name, edge) in enumerate(zip(names, loop, strict=True)):
                # Sewing would close an opening between two unsewn edges with one mesh edge each.
                before, after = names[i - 1], names[(i + 1) % len(names)]
                between_seams = name not in partner and before in partner and after in partner
                opening = 2 if between_seams and partner[before] != after else 1
                result[name] = max(least(edge), opening, round(edge.length / spacing))
    for seam in pattern.seams:
        a, b = pattern.edge(seam.first), pattern.edge(seam.second)
        both = max(least(a), least(b), round((a.length + b.length) / 2 / spacing))
        result[seam.first] = result[seam.second] = both
    return result


def _pairs(
    pattern: Pattern, groups: Mapping[str, Indices], placed: Floats
) -> tuple[Indices, Indices, dict[Seam, bool]]:
    pairs, owner = [], []
    reverse: dict[Seam, bool] = {}
    for index, seam in enumerate(pattern.seams):
        a, b = groups[seam.first], groups[seam.second]
        along, against = (
            np.linalg.norm(placed[a] - placed[order], axis=1).sum() for order in (b, b[::-1])
        )
        reverse[seam] = (
            bool(against <= along * (1 + 1e-9)) if seam.reverse is None else seam.reverse
        )
        pairs.append(np.c_[a, b[::-1] if reverse[seam] else b])
        owner.append(np.full(len(a), index))
    if not pairs:
        return np.empty((0, 2), np.int64), np.empty(0, np.int64), reverse
    return np.concatenate(pairs), np.concatenate(owner), reverse
