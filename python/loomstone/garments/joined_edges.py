"""Corrects the meshes of panels where triangles would coincide after sewing, as at bag corners.

Where two sewn edges of a panel meet, a triangle may have a side on each of them. Both ends of its
third side then lie on seams. If both edges are sewn to the same other panel, and that panel has
such a triangle too, sewing makes one edge of the two third sides, and the triangles lie on each
other. At the tip of a cone, the ends of the third side become one vertex. An edge flip, which
replaces the common side of two triangles by the other diagonal of their quadrilateral, usually
helps. Where it does not, a new vertex splits the edge.

Edges inside two panels may also cross, if the seams join both ends of one to the boundary of the
other's panel. A new vertex then splits the longer of the two.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .triangulation import improve, smallest_angles

__all__ = ["Separated", "without_joined_edges"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Edge = tuple[int, int]
Sides = dict[Edge, tuple[int, int]]  # half-edge: its triangle and the opposite vertex

ROUNDS = 100  # largest number of rounds; each flips or splits at most one edge per triangle
LEAST_DEGREES = 10.0  # an edge is split rather than flipped if the flip makes smaller angles


@dataclass(frozen=True, eq=False)
class Separated:
    """Triangles of all panels, after without_joined_edges() has flipped or split edges.

    points : (n x 2) the given vertices, then new ones [m]
    triangles : (m x 3) counter-clockwise
    origin : (m) for each triangle, the index of a given triangle of the same panel
    """

    points: Floats
    triangles: Indices
    origin: Indices


def without_joined_edges(points: Floats, triangles: Indices, welded: Indices) -> Separated:
    """Flips or splits edges inside panels that would coincide with or cross others after sewing.

    Edges coincide if the seams join their ends. An edge inside a panel is also flipped or split if
    the seams join its own two ends. Does nothing if the seams join the two ends of a boundary edge,
    because welding the panels then fails in any case.

    points : (n x 2) vertices of all panels, each in its plane [m]
    triangles : (m x 3) counter-clockwise
    welded : (n) index of each vertex after sewing
    """
    given = len(points)
    triangles, origin = triangles.copy(), np.arange(len(triangles))
    sides = _sides(triangles)
    if any(welded[a] == welded[b] for a, b in sides if (b, a) not in sides):
        return Separated(points, triangles, origin)
    for _ in range(ROUNDS):
        groups = _groups(sides, welded)
        joined = _joined_edges(sides, groups)
        crossing = [] if joined else _crossing_edges(sides, welded)
        if not (joined or crossing):
            break
        useful = partial(_is_new, groups=groups, welded=welded)
        flips = _flips(points, sides, joined, useful)
        for one, two, new in flips:
            triangles[one], triangles[two] = new
        if not flips:
            edges = [max(edges, key=lambda e: _length(points, e)) for edges in joined + crossing]
            points, triangles, origin = _split(points, triangles, origin, sides, edges)
            welded = np.r_[welded, welded.max() + 1 + np.arange(len(points) - len(welded))]
            improve(points, triangles, given)
        sides = _sides(triangles)
    return Separated(points, triangles, origin)


def _sides(triangles: Indices) -> Sides:
    return {
        (a, b): (row, c)
        for row, (i, j, k) in enumerate(triangles.tolist())
        for a, b, c in ((i, j, k), (j, k, i), (k, i, j))
    }


def _length(points: Floats, edge: Edge) -> float:
    return float(np.linalg.norm(points[edge[1]] - points[edge[0]]))


def _ends(edge: Edge, welded: Indices) -> Edge:
    """Returns the ends of an edge after sewing, in ascending order."""
    a, b = sorted((int(welded[edge[0]]), int(welded[edge[1]])))
    return a, b


def _groups(sides: Sides, welded: Indices) -> dict[Edge, list[Edge]]:
    """Returns, for each edge after sewing, the edges that become it."""
    groups = defaultdict(list)
    for a, b in sides:
        if a < b or (b, a) not in sides:
            groups[_ends((a, b), welded)].append((a, b))
    return groups


def _joined_edges(sides: Sides, groups: dict[Edge, list[Edge]]) -> list[list[Edge]]:
    """Returns groups of edges inside panels that would coincide with each other or a boundary edge.

    An edge whose own two ends are joined is returned even if it coincides with no other edge.
    """
    result = []
    for ends, edges in groups.items():
        inside = [(a, b) for a, b in edges if (b, a) in sides]
        if inside and (len(edges) > 1 or ends[0] == ends[1]):
            result.append(inside)
    return result


def _boundary_places(sides: Sides) -> dict[int, tuple[int, int]]:
    """Returns, for each boundary vertex, a number of its loop and a position along this loop.

    Positions increase along a loop, but need not begin at 0.
    """
    following = {a: b for a, b in sides if (b, a) not in sides}
    places: dict[int, tuple[int, int]] = {}
    for loop, start in enumerate(following):
        vertex = start
        while vertex not in places:
            places[vertex] = (loop, len(places))
            vertex = following[vertex]
    return places


def _crossing_edges(sides: Sides, welded: Indices) -> list[list[Edge]]:
    """Returns pairs of edges inside panels that would cross after sewing.

    The ends of the first edge lie on one boundary loop. The ends of the second lie on another loop,
    and the seams join them to vertices of the first loop. Along the first loop, these vertices
    alternate with the ends of the first edge.
    """
    places = _boundary_places(sides)
    along = {(loop, int(welded[v])): place for v, (loop, place) in places.items()}
    chords = defaultdict(list)
    for a, b in sides:
        loops = {places[v][0] if v in places else -1 for v in (a, b)}
        if a < b and (b, a) in sides and len(loops) == 1 and -1 not in loops:
            chords[loops.pop()].append((a, b))
    result = []
    for loop, other in combinations(chords, 2):
        there = [
            (along.get((loop, int(welded[c])), -1), along.get((loop, int(welded[d])), -1), (c, d))
            for c, d in chords[other]
        ]
        for a, b in chords[loop]:
            low, high = sorted((places[a][1], places[b][1]))
            result += [
                [(a, b), edge]
                for p, q, edge in there
                if min(p, q) >= 0
                and not {p, q} & {low, high}
                and (low < p < high) != (low < q < high)
            ]
    return result


def _is_new(edge: Edge, groups: dict[Edge, list[Edge]], welded: Indices) -> bool:
    """Returns whether an edge would have two different ends and coincide with no other edge."""
    ends = _ends(edge, welded)
    return ends[0] != ends[1] and ends not in groups


def _flips(
    points: Floats, sides: Sides, joined: list[list[Edge]], useful: Callable[[Edge], bool]
) -> list[tuple[int, int, tuple[list[int], list[int]]]]:
    """Returns flips of joined edges, at most one for each group of edges and for each triangle.

    Of several possible flips, the one is chosen after which the smallest angle is largest. A flip
    consists of the indices of two triangles and of the two triangles that replace them.

    joined : the groups of edges that _joined_edges() returns
    useful : returns whether an edge is a useful replacement
    """
    chosen = []
    for edges in joined:
        flips = [_flip(points, sides, edge) for edge in edges if useful(_diagonal(sides, edge))]
        flips = [flip for flip in flips if flip[0] > LEAST_DEGREES]
        if flips:
            chosen.append(max(flips, key=lambda flip: flip[0]))
    result, taken = [], set[int]()
    for _, one, two, new in sorted(chosen, key=lambda flip: (-flip[0], flip[1])):
        if not taken & {one, two}:
            taken |= {one, two}
            result.append((one, two, new))
    return result


def _diagonal(sides: Sides, edge: Edge) -> Edge:
    """Returns the edge that replaces an edge in a flip."""
    a, b = edge
    return sides[a, b][1], sides[b, a][1]


def _flip(
    points: Floats, sides: Sides, edge: Edge
) -> tuple[float, int, int, tuple[list[int], list[int]]]:
    """Returns the smallest angle after the flip of an edge [degrees], and the flip.

    The angle is 0 if a triangle would be turned over.
    """
    a, b = edge
    (one, c), (two, d) = sides[a, b], sides[b, a]
    new = ([c, a, d], [d, b, c])
    corners = points[np.array(new)]
    first, last = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0]
    angle = float(smallest_angles(points, np.array(new)).min()) if (areas > 0).all() else 0.0
    return angle, one, two, new


def _split(
    points: Floats, triangles: Indices, origin: Indices, sides: Sides, edges: list[Edge]
) -> tuple[Floats, Indices, Indices]:
    """Splits edges at their centres, at most one edge per triangle."""
    taken = set[int]()
    middles: list[Floats] = []
    rows, added = triangles.tolist(), []
    for a, b in edges:
        (one, c), (two, d) = sides[a, b], sides[b, a]
        if taken & {one, two}:
            continue
        taken |= {one, two}
        m = len(points) + len(middles)
        middles.append((points[a] + points[b]) / 2)
        rows[one], rows[two] = [a, m, c], [b, m, d]
        rows += [[m, b, c], [m, a, d]]
        added += [origin[one], origin[two]]
    return np.r_[points, middles], np.array(rows, np.int64), np.r_[origin, added]
