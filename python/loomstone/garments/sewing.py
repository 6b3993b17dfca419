"""Sews panels into one mesh whose uv are the pattern."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core import Cloth, InvalidInput, Scene, TriangleMesh, intersecting_pairs
from ..base.arguments import takes, whole
from ..pictures.notebook import picture_of_scene
from .cutting import Cut, cut
from .panel import Panel
from .relaxation import relaxed, stretches
from .seams import Pattern, Seam, merged
from .triangulation import smallest_angles

__all__ = ["Garment", "garment"]

_MOST_TRIANGLES = 10_000_000  # largest number of triangles of a garment

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

EASE = 0.05  # default limit of the relative difference in length of sewn edges [1]


@dataclass(frozen=True, eq=False)
class Garment:
    """A sewn garment.

    mesh : TriangleMesh. Its uv are the flat panels, next to each other [m]; the two sides of a seam
        therefore have different uv.
    groups : vertex indices by name: "panel" and "panel.edge" (in order along the edge); sewn() in
        sewn_meshes.py describes the groups of a mesh that was already sewn
    panel_names : names of the panels
    panel_of_triangle : (m) index of the panel of each triangle
    seam_edges : (k x 2) edges of the mesh along the seams
    cut : the panels before sewing, or None for a mesh that was already sewn
    """

    mesh: TriangleMesh
    groups: Mapping[str, Indices]
    panel_names: tuple[str, ...]
    panel_of_triangle: Indices
    seam_edges: Indices
    cut: Cut | None = None

    def __repr__(self) -> str:
        triangles = len(self.panel_of_triangle)
        return f"Garment({', '.join(self.panel_names)}: {triangles} triangles)"

    def _repr_png_(self) -> bytes | None:
        return picture_of_scene(Scene(cloths=[Cloth(mesh=self.mesh)]))

    def group(self, *names: str) -> list[int]:
        """Returns the vertices of one or several groups, for pins and attachments.

        Raises InvalidInput for an unknown name.
        """
        for name in names:
            if name not in self.groups:
                raise InvalidInput(
                    f"the garment has no group {name!r}; it has {', '.join(self.groups)}"
                )
        return sorted({int(i) for name in names for i in self.groups[name]})

    def flat_corners(self) -> Floats:
        """Returns the corners of all triangles at rest, in the flat pattern (m x 3 x 2) [m]."""
        corners: Floats = np.asarray(self.mesh.uv)[np.asarray(self.mesh.uv_triangles)]
        return corners

    def stretches(self) -> Floats:
        """Returns the principal stretches of all triangles (m x 2) relative to the pattern [1].

        The larger stretch of a triangle comes first.
        """
        return stretches(
            np.asarray(self.mesh.vertices),
            np.asarray(self.mesh.triangles, np.int64),
            self.flat_corners(),
        )

    def min_angle_degrees(self) -> float:
        """Returns the smallest angle of the triangles of the pattern [degrees]."""
        count = self.mesh.n_triangles
        return float(
            smallest_angles(
                self.flat_corners().reshape(-1, 2), np.arange(3 * count).reshape(-1, 3)
            ).min()
        )

    def openings(self) -> list[list[int]]:
        """Returns the closed loops of boundary vertices, such as neck, armholes and hem."""
        return boundary_loops(np.asarray(self.mesh.triangles))

    def moved(self, translation: ArrayLike) -> Garment:
        """Returns the garment moved by a translation (3) [m]."""
        return self.at(np.asarray(self.mesh.vertices) + np.asarray(translation, float))

    def at(self, positions: ArrayLike) -> Garment:
        """Returns the garment with other vertex positions (n x 3) [m]."""
        mesh = TriangleMesh(
            positions, self.mesh.triangles, self.mesh.uv, uv_triangles=self.mesh.uv_triangles
        )
        return Garment(
            mesh, self.groups, self.panel_names, self.panel_of_triangle, self.seam_edges, self.cut
        )


@takes(edge="m", ease="1")
def garment(
    panels: Sequence[Panel] | Pattern,
    seams: Sequence[Seam | tuple[str, str]] = (),
    *,
    triangles: int | None = None,
    edge: float | None = None,
    ease: float = EASE,
    seed: int = 1,
    relax: int = 150,
    allow_intersections: bool = False,
) -> Garment:
    """Triangulates panels, joins them along seams, and reduces the strain due to their placement.

    panels, seams : panels with seams (Seam or pairs of "panel.edge"), or one Pattern
    triangles : total number of triangles; the result may differ from it slightly. Exactly one of
        `triangles` and `edge` must be given.
    edge : mean edge length of the mesh [m]. Angles of triangles usually exceed 25 degrees if no
        panel is narrower than this length and no corner of an outline is below 55 degrees. They are
        smaller where two sewn edges meet in a sharp corner, as at the tip of a cone.
    ease : largest difference in length of two sewn edges, relative to the longer one [1]
    seed : seed of the random start positions of interior points; equal input gives an equal garment
    relax : number of iterations that bring triangles closer to their rest shapes. With 0, joined
        vertices meet at their mean position, and no other vertex moves.
    allow_intersections : whether a garment that intersects itself is accepted

    Raises InvalidInput if the garment intersects itself, unless this is allowed, or if the panels
    cannot be sewn: for instance if an edge is unknown or sewn twice, the lengths of sewn edges
    differ by more than `ease`, or panels are not connected.

    >>> import loomstone as ls
    >>> names = ("hem", "right", "top", "left")
    >>> corners = [(-0.25, 0), (0.25, 0), (0.25, 0.4), (-0.25, 0.4)]
    >>> front = ls.garments.Panel.polygon("front", corners, names=names)
    >>> round_ = [ls.garments.Cylinder(radius=0.16, angle_degrees=a) for a in (-90, 90)]
    >>> places = zip(("front", "back"), round_)
    >>> panels = [ls.garments.replace(front, name=name, place=place) for name, place in places]
    >>> seams = [("front.right", "back.left"), ("back.right", "front.left")]
    >>> tube = ls.garment(panels, seams, triangles=600)
    >>> tube.mesh.n_triangles, len(tube.openings())
    (600, 2)
    """
    pattern = _pattern(panels, seams)
    pattern.check(ease)
    spacing, count = _spacing(pattern, triangles, edge)
    pieces = cut(pattern, spacing=spacing, triangles=count, seed=seed)
    sewn = joined(pieces, pieces.placed)
    if relax:
        positions = np.asarray(sewn.mesh.vertices)
        faces = np.asarray(sewn.mesh.triangles, np.int64)
        times = whole("relax", relax, 0, 100_000)
        sewn = sewn.at(relaxed(positions, faces, sewn.flat_corners(), iterations=times))
    if not allow_intersections:
        check_free(sewn)
    return sewn


def _pattern(panels: Sequence[Panel] | Pattern, seams: Sequence[Seam | tuple[str, str]]) -> Pattern:
    if not isinstance(panels, Pattern):
        return Pattern(panels, seams)  # type: ignore[arg-type]
    if seams:
        raise InvalidInput(
            "a Pattern has its own seams; give either a Pattern, or panels and seams"
        )
    return panels


def _spacing(
    pattern: Pattern, triangles: int | None, edge: float | None
) -> tuple[float, int | None]:
    """Returns the edge length [m] and the number of triangles (None if `edge` is given)."""
    if (triangles is None) == (edge is None):
        raise InvalidInput(f"give either triangles or edge, got triangles={triangles}, edge={edge}")
    area = sum(panel.area for panel in pattern.panels)
    if edge is not None:
        if not (np.isfinite(edge) and edge > 0):
            raise InvalidInput(f"edge must be > 0 [m], got {edge}")
        shortest = edge_for(area, _MOST_TRIANGLES)
        if edge < shortest:
            raise InvalidInput(
                f"edge must be at least {1.001 * shortest:.3g} m, to give at most {_MOST_TRIANGLES}"
                f" triangles, got {edge} [m]"
            )
        return float(edge), None
    count = whole("triangles", triangles, 2 * len(pattern.panels), _MOST_TRIANGLES)
    return edge_for(area, count), count


def edge_for(area: float, triangles: int) -> float:
    """Returns the edge length [m] of `triangles` equilateral triangles with a total area [m^2]."""
    return float(np.sqrt(area / triangles * 4 / np.sqrt(3)))


def joined(pieces: Cut, positions: Floats) -> Garment:
    """Welds the panels, whose vertices are at `positions` (n x 3) [m], along all seams.

    Joined vertices meet at their mean position.
    """
    index, mesh = welded(pieces, positions, pieces.pairs)
    groups = {name: index[members] for name, members in pieces.groups.items()}
    names = tuple(panel.name for panel in pieces.pattern.panels)
    return Garment(
        mesh, groups, names, pieces.panel_of_triangle, _seam_edges(pieces, index), pieces
    )


def welded(pieces: Cut, positions: Floats, pairs: Indices) -> tuple[Indices, TriangleMesh]:
    """Returns the index of each panel vertex in the welded mesh, and this mesh.

    pairs : (k x 2) pairs of vertices that are merged
    """
    index = merged(len(positions), [(int(a), int(b)) for a, b in pairs])
    weight = np.bincount(index)
    vertices = (
        np.stack([np.bincount(index, column) for column in positions.T], axis=1) / weight[:, None]
    )
    triangles = index[pieces.triangles]
    _check_weld(pieces, triangles)
    # If a panel is turned over, its triangles are reversed but its uv are not, so these triangles
    # are clockwise in uv.
    return index, TriangleMesh(vertices, triangles, pieces.flat, uv_triangles=pieces.triangles)


def boundary_loops(triangles: NDArray[np.integer]) -> list[list[int]]:
    """Returns the vertices of each boundary loop, in the direction of the boundary half-edges.

    Loops may touch at a vertex. The triangles there form several fans, in which neighbours share an
    edge. A loop enters and leaves the vertex along the same fan.
    """
    third = {}  # third vertex of the triangle of each half-edge (a, b)
    for a, b, c in triangles.tolist():
        third[a, b], third[b, c], third[c, a] = c, a, b
    unused = sorted(edge for edge in third if edge[::-1] not in third)
    left = set(unused)
    loops = []
    for start in unused:
        if start not in left:
            continue
        loop, edge = [], start
        while edge in left:
            left.remove(edge)
            loop.append(edge[0])
            corner, far = edge[1], third[edge]
            while (far, corner) in third:
                far = third[far, corner]
            edge = corner, far
        loops.append(loop)
    return loops


def _seam_edges(pieces: Cut, index: Indices) -> Indices:
    ends = index[pieces.pairs[:, 0]]
    same = pieces.seam_of_pair[1:] == pieces.seam_of_pair[:-1]
    return np.c_[ends[:-1], ends[1:]][same] if len(ends) else np.empty((0, 2), np.int64)


def _check_weld(pieces: Cut, triangles: Indices) -> None:
    names = [panel.name for panel in pieces.pattern.panels]
    flat = (triangles == np.roll(triangles, 1, axis=1)).any(1)
    if flat.any():
        panel = names[pieces.panel_of_triangle[np.argmax(flat)]]
        raise InvalidInput(
            f"panel {panel!r}: its seams join two corners of one triangle; ask for more triangles"
        )
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, first, uses = np.unique(half, axis=0, return_index=True, return_counts=True)
    if (uses > 1).any():
        panel = names[pieces.panel_of_triangle[first[np.argmax(uses > 1)] % len(triangles)]]
        raise InvalidInput(
            f"the seams fold panel {panel!r} onto another: more than two triangles would share an"
            " edge; check which edges are sewn, and ask for more triangles if panels are narrow"
        )


def check_free(sewn: Garment) -> None:
    pairs = intersecting_pairs(sewn.mesh.vertices, sewn.mesh.triangles)
    if pairs:
        a, b = (sewn.panel_names[sewn.panel_of_triangle[t]] for t in pairs[0])
        raise InvalidInput(
            f"the garment passes through itself in {len(pairs)} pairs of triangles, first of panels"
            f" {a!r} and {b!r}; place the panels farther apart, close the seams by simulation"
            " (close_seams), or set allow_intersections"
        )
