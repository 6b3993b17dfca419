"""Triangulation of a flat piece with holes, by scipy's Delaunay triangulation.

Points of the outline and of the holes are fixed. Interior points start on a jittered hexagonal
lattice. They first move to the centroids of their neighbouring triangles (Lloyd's iteration
[Lloyd1982]). Interior points of triangles with small angles then move to where these angles are
larger.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from ..meshes.planar import centres, cross, delaunay

__all__ = ["Boundary", "improve", "smallest_angles", "triangulated"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Smallest initial distance of interior points from the boundary, as a fraction of the lattice's
# spacing. It is reduced if a narrow panel lacks room.
CLEARANCE = 0.5
WANTED_DEGREES = 28.0  # triangles with a smaller angle are improved
COMPASS = np.array([(np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4])


class Boundary:
    """The boundary of a piece: closed loops of points (b x 2) [m] without duplicates.

    The outline comes first, counter-clockwise, followed by the holes, clockwise.
    """

    def __init__(self, loops: Sequence[Floats]) -> None:
        self.points = np.concatenate(loops)
        self.following = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
        self.preceding = np.concatenate([np.roll(loop, 1, axis=0) for loop in loops])
        index = np.split(np.arange(len(self.points)), np.cumsum([len(loop) for loop in loops])[:-1])
        self.next = np.concatenate([np.roll(i, -1) for i in index])
        self.holes = len(loops) - 1

    def __len__(self) -> int:
        return len(self.points)

    @property
    def area(self) -> float:
        """Area within the outline without the holes [m^2]."""
        return float(cross(self.points, self.following).sum()) / 2

    def triangles(self, interior: int) -> int:
        """Returns the number of triangles with `interior` additional points, by Euler's formula."""
        return 2 * interior + len(self) - 2 + 2 * self.holes

    def contains(self, points: Floats) -> NDArray[np.bool_]:
        """Returns, for each point (n x 2), whether it lies within the outline and in no hole.

        Counts the crossings of the boundary with a ray from the point along +x.
        """
        a, b = self.points, self.following
        result = np.zeros(len(points), bool)
        for first in range(0, len(points), 4096):
            x, y = points[first : first + 4096, :1], points[first : first + 4096, 1:]
            spans = (a[:, 1] > y) != (b[:, 1] > y)
            with np.errstate(divide="ignore", invalid="ignore"):
                meets = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
            result[first : first + 4096] = (spans & (x < meets)).sum(1) % 2 == 1
        return result


def triangulated(
    boundary: Boundary, interior: int, *, seed: int, where: str
) -> tuple[Floats, Indices]:
    """Returns the points (n x 2) [m] and the triangles (m x 3) of a mesh of the piece.

    The points of the boundary come first, in the order of boundary.points. The triangles are
    counter-clockwise, and their number is boundary.triangles(interior).

    interior : number of interior points
    seed : seed of the initial points
    where : name of the piece in errors

    Raises InvalidInput if the boundary is too fine for the spacing of the points, or if no
    triangulation with this number of interior points is found.
    """
    points = np.concatenate([boundary.points, _start(boundary, interior, seed)])
    fixed = len(boundary)
    for _ in range(25):
        faces = _faces(points, boundary)
        moved = centres(points, faces)
        # Next to the boundary, the triangles around a point need not form a convex region, and
        # their centroid may lie outside the piece. The point then does not move.
        beside = np.unique(faces[(faces < fixed).any(1)])
        outside = beside[~boundary.contains(moved[beside])]
        moved[outside] = points[outside]
        points[fixed:] = moved[fixed:]
    faces = _faces(points, boundary)
    for _ in range(12):
        if not improve(points, faces, fixed):
            break
        faces = _faces(points, boundary)
    _check(points, faces, boundary, interior, where)
    return points, faces


def smallest_angles(points: Floats, faces: Indices) -> Floats:
    """Returns the smallest angle of every triangle [degrees]."""
    corners = points[faces]
    sides = np.roll(corners, -1, 1) - corners
    length = np.linalg.norm(sides, axis=2)
    cosine = -np.einsum("tij,tij->ti", sides, np.roll(sides, 1, 1)) / (
        length * np.roll(length, 1, 1)
    )
    smallest: Floats = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).min(1)
    return smallest


def _distance(boundary: Boundary, points: Floats) -> Floats:
    """Returns the distances (n) of points from the boundary [m]."""
    a, along = boundary.points, boundary.following - boundary.points
    length2 = (along**2).sum(1)
    nearest = np.empty(len(points))
    for first in range(0, len(points), 4096):
        away = points[first : first + 4096, None] - a
        share = np.clip((away * along).sum(2) / length2, 0.0, 1.0)
        nearest[first : first + 4096] = np.linalg.norm(
            away - share[:, :, None] * along, axis=2
        ).min(1)
    return nearest


def _beyond_corners(boundary: Boundary, points: Floats) -> NDArray[np.bool_]:
    """Returns, for each point, whether it is far enough from all sharp corners of the boundary.

    Corners below 55 degrees are sharp. The smallest distance from a corner is 1.2 times the longer
    of its two boundary segments. If interior points keep this distance, each sharp corner has one
    triangle. Two triangles would each have only about half of its angle.
    """
    before, after = boundary.preceding - boundary.points, boundary.following - boundary.points
    angle = np.arctan2(cross(after, before), (after * before).sum(1))
    sharp = (angle > 0) & (angle < np.radians(55.0))
    free = np.ones(len(points), bool)
    for corner, a, b in zip(boundary.points[sharp], before[sharp], after[sharp], strict=True):
        free &= np.linalg.norm(points - corner, axis=1) > 1.2 * max(
            np.linalg.norm(a), np.linalg.norm(b)
        )
    return free


def _start(boundary: Boundary, interior: int, seed: int) -> Floats:
    """Returns `interior` points of a jittered hexagonal lattice, or fewer if there is no room."""
    random = np.random.default_rng(seed)
    low, size = boundary.points.min(0), np.ptp(boundary.points, axis=0)
    # The area per point of a hexagonal lattice is 0.866 of the squared spacing. A boundary point
    # counts as half a point. The factor 1.1 makes the first lattice too coarse, and the loop
    # refines it until there are enough points.
    spacing = np.sqrt(boundary.area / max(1.0, interior + len(boundary) / 2) / 0.866) * 1.1
    clearance = CLEARANCE
    found = np.empty((0, 2))
    for attempt in range(200):
        rows = np.arange(-0.5 * spacing, size[1] + spacing, spacing * np.sqrt(3) / 2)
        columns = np.arange(-0.5 * spacing, size[0] + spacing, spacing)
        lattice = (
            np.array([(c + (r % 2) * spacing / 2, v) for r, v in enumerate(rows) for c in columns])
            + low
        )
        lattice += random.uniform(-0.1, 0.1, lattice.shape) * spacing
        lattice = lattice[boundary.contains(lattice)]
        found = lattice[
            (_distance(boundary, lattice) > clearance * spacing)
            & _beyond_corners(boundary, lattice)
        ]
        if len(found) >= interior:
            break
        spacing *= 0.99
        if attempt % 20 == 19:
            clearance *= 0.8  # otherwise, narrow panels may have no room for points
    # Surplus points are removed evenly over the piece. Lloyd's iteration in triangulated() closes
    # the gaps.
    surplus = len(found) - interior
    leaves = np.linspace(0, len(found), max(0, surplus), endpoint=False).astype(int)
    return np.delete(found, leaves, axis=0)


def _faces(points: Floats, boundary: Boundary) -> Indices:
    faces = delaunay(points, 1e-6 * np.ptp(boundary.points, axis=0).prod() / len(points)).astype(
        np.int64
    )
    # Only triangles whose points all lie on the boundary can lie outside.
    keep: NDArray[np.bool_] = np.asarray((faces >= len(boundary)).any(1))
    keep[~keep] = boundary.contains(points[faces[~keep]].mean(1))
    return np.asarray(faces[keep], np.int64)


def improve(points: Floats, faces: Indices, fixed: int) -> bool:
    """Moves interior vertices, so that the smallest angle of the triangles around them increases.

    Vertices of triangles with an angle below WANTED_DEGREES are moved, each by a compass search.
    Returns whether any vertex moved.

    fixed : number of vertices that do not move; they come first in `points`
    """
    poor = np.unique(faces[smallest_angles(points, faces) < WANTED_DEGREES])
    order = np.argsort(faces, axis=None, kind="stable")  # corners sorted by vertex
    first = np.searchsorted(faces.ravel()[order], np.arange(len(points) + 1))
    changed = False
    for vertex in poor[poor >= fixed]:
        around, corner = np.divmod(order[first[vertex] : first[vertex + 1]], 3)
        # The two other corners of each triangle around the vertex.
        ring = points[
            np.stack([faces[around, (corner + 1) % 3], faces[around, (corner + 2) % 3]], axis=1)
        ]
        here = points[vertex]
        reach = float(np.linalg.norm(ring[:, 0] - here, axis=1).max())
        step, best = 0.2 * reach, _worst(here[None], ring)[0]
        while step > 2e-3 * reach:
            tried = here + step * COMPASS
            values = _worst(tried, ring)
            if values.max() > best + 1e-9:
                here, best, changed = tried[values.argmax()], values.max(), True
            else:
                step *= 0.5
        points[vertex] = here
    return changed


def _worst(places: Floats, ring: Floats) -> Floats:
    """Rates trial positions (k x 2) of a vertex by the triangles around it.

    Returns, for each position, minus the largest cosine of an angle of these triangles, or -2 if a
    triangle would be inverted or flat.
    """
    first, last = ring[None, :, 0] - places[:, None], ring[None, :, 1] - places[:, None]
    across = (ring[:, 1] - ring[:, 0])[None]
    a, b, c = (
        np.linalg.norm(first, axis=2),
        np.linalg.norm(last, axis=2),
        np.linalg.norm(across, axis=2),
    )
    cosines = np.stack(
        [
            (first * last).sum(2) / (a * b),
            -(first * across).sum(2) / (a * c),
            (last * across).sum(2) / (b * c),
        ]
    ).max((0, 2))
    over = ((first[..., 0] * last[..., 1] - first[..., 1] * last[..., 0]) <= 0).any(1)
    worst: Floats = np.where(over, -2.0, -cosines)
    return worst


def _check(points: Floats, faces: Indices, boundary: Boundary, interior: int, where: str) -> None:
    present = {
        tuple(e)
        for e in np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).tolist()
    }
    for i, j in enumerate(boundary.next.tolist()):
        if (i, j) not in present:
            x, y = boundary.points[i]
            raise InvalidInput(
                f"{where}: its outline is finer near ({x:.4g}, {y:.4g}) m than the triangles "
                "can follow; ask for more triangles, or leave out the detail"
            )
    if len(faces) != boundary.triangles(interior):
        raise InvalidInput(
            f"{where}: cannot be triangulated with {interior} points inside and {len(boundary)}"
            " around; ask for another number"
        )
