"""Triangulates panels for sewing, with equal numbers of points on the two edges of each seam."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .edges import Edge
from .seams import Pattern, Seam, turned_panels
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

    triangles : total number, distributed over the panels by area; None: determined by `spacing`
    """
    segments = _segments(pattern, spacing)
    flat, placed, faces, owner = [], [], [], []
    groups: dict[str, Indices] = {}
    total = sum(panel.area for panel in pattern.panels)
    first, shelf, due = 0, 0.0, 0.0
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
        groups[panel.name] = np.arange(first, first + len(points))
        laid = panel.pattern(points)
        low = laid.min(0)
        flat.append(laid - low + (shelf, 0.0))
        shelf += float(np.ptp(laid[:, 0])) + SHELF
        where = np.asarray(panel.place(points), float)
        if where.shape != (len(points), 3) or not np.isfinite(where).all():
            raise InvalidInput(
                f"panel {panel.name!r}: its place must return finite points (n x 3) [m]"
            )
        placed.append(where)
        faces.append(panel_faces + first)
        owner.append(np.full(len(panel_faces), index))
        first += len(points)
    places = np.concatenate(placed)
    pairs, seam_of_pair, reverse = _pairs(pattern, groups, places)
    joined, owners = np.concatenate(faces), np.concatenate(owner)
    for index, panel in enumerate(pattern.panels):
        if turned_panels(pattern, reverse)[panel.name]:
            joined[owners == index] = joined[owners == index][:, ::-1]
    return Cut(pattern, np.concatenate(flat), places, joined, owners, pairs, seam_of_pair, groups)


def _loop(panel: str, edges: Sequence[Edge], segments: Mapping[str, int]) -> Floats:
    """Returns the points along a closed loop of edges, each point once."""
    points = np.concatenate([edge.sampled(segments[f"{panel}.{edge.name}"])[:-1] for edge in edges])
    if len(points) < 3:
        raise InvalidInput(f"panel {panel!r} has only {len(points)} points; ask for more triangles")
    return points


def _segments(pattern: Pattern, spacing: float) -> dict[str, int]:
    def least(edge: Edge) -> int:
        if edge.start == edge.end:
            return 6 if edge.kind == "circle" else max(3, len(edge.points) - 1)
        return 1 if edge.kind == "polyline" and len(edge.points) == 2 else 2

    result = {
        f"{panel.name}.{edge.name}": max(least(edge), round(edge.length / spacing))
        for panel in pattern.panels
        for loop in panel.loops
        for edge in loop
    }
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
