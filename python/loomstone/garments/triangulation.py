"""Quality unstructured triangulation of a flat outline, by scipy's Delaunay triangulation of relaxed points.

Points of the outline are fixed; the others start on a jittered hexagonal lattice and move to the centre of their
surroundings (Lloyd's iteration with areas of triangles), then away from the smallest angles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from ..planar import centres, cross, delaunay

__all__ = ["inside", "smallest_angles", "triangulated"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

CLEARANCE = 0.5  # of the spacing: start points keep so far from the outline
WANTED_DEGREES = 28.0  # angles below are improved
COMPASS = np.array([(np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4])


def triangulated(outline: Floats, interior: int, *, seed: int, where: str) -> tuple[Floats, Indices]:
    """Points (outline first, in order) and counter-clockwise triangles of exactly 2 interior + outline - 2.

    outline : (b x 2), counter-clockwise, no two points equal [m]; interior : number of points inside
    where : named in errors: InvalidInput where the outline is finer than its points resolve
    """
    points = np.concatenate([outline, _start(outline, interior, seed)])
    fixed = len(outline)
    for _ in range(25):
        faces = _faces(points, outline)
        moved = centres(points, faces)
        # Beside the outline surroundings need not be convex: a centre may lie outside.
        beside = np.unique(faces[(faces < fixed).any(1)])
        outside = beside[~inside(outline, moved[beside])]
        moved[outside] = points[outside]
        points[fixed:] = moved[fixed:]
    faces = _faces(points, outline)
    for _ in range(12):
        if not _improve(points, faces, fixed):
            break
        faces = _faces(points, outline)
    _check(points, faces, outline, interior, where)
    return points, faces


def smallest_angles(points: Floats, faces: Indices) -> Floats:
    """Smallest angle of every triangle [degrees]."""
    corners = points[faces]
    sides = np.roll(corners, -1, 1) - corners
    length = np.linalg.norm(sides, axis=2)
    cosine = -np.einsum("tij,tij->ti", sides, np.roll(sides, 1, 1)) / (length * np.roll(length, 1, 1))
    smallest: Floats = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).min(1)
    return smallest


def inside(outline: Floats, points: Floats) -> NDArray[np.bool_]:
    """Which points lie within the outline: odd crossings of a ray along x."""
    a, b = outline, np.roll(outline, -1, axis=0)
    result = np.zeros(len(points), bool)
    for first in range(0, len(points), 4096):
        x, y = points[first : first + 4096, :1], points[first : first + 4096, 1:]
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            meets = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
        result[first : first + 4096] = (spans & (x < meets)).sum(1) % 2 == 1
    return result


def _distance(outline: Floats, points: Floats) -> Floats:
    """To the nearest edge of the outline."""
    a, along = outline, np.roll(outline, -1, axis=0) - outline
    length2 = (along**2).sum(1)
    nearest = np.empty(len(points))
    for first in range(0, len(points), 4096):
        away = points[first : first + 4096, None] - a
        share = np.clip((away * along).sum(2) / length2, 0.0, 1.0)
        nearest[first : first + 4096] = np.linalg.norm(away - share[:, :, None] * along, axis=2).min(1)
    return nearest


def _beyond_corners(outline: Floats, points: Floats) -> NDArray[np.bool_]:
    """Which points leave a sharp corner to one triangle: two there would have half its angle."""
    before, after = np.roll(outline, 1, axis=0) - outline, np.roll(outline, -1, axis=0) - outline
    angle = np.arctan2(cross(after, before), (after * before).sum(1))
    sharp = (angle > 0) & (angle < np.radians(55.0))
    free = np.ones(len(points), bool)
    for corner, a, b in zip(outline[sharp], before[sharp], after[sharp], strict=True):
        free &= np.linalg.norm(points - corner, axis=1) > 1.2 * max(np.linalg.norm(a), np.linalg.norm(b))
    return free


def _start(outline: Floats, interior: int, seed: int) -> Floats:
    """`interior` points of a jittered hexagonal lattice, spread over the whole outline."""
    random = np.random.default_rng(seed)
    low, size = outline.min(0), np.ptp(outline, axis=0)
    x, y = outline.T
    area = abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2
    # A point of a hexagonal lattice owns 0.87 of the squared spacing; half a point of the outline counts.
    spacing = np.sqrt(area / max(1.0, interior + len(outline) / 2) / 0.866) * 1.1
    clearance = CLEARANCE
    found = np.empty((0, 2))
    for attempt in range(200):
        rows = np.arange(-0.5 * spacing, size[1] + spacing, spacing * np.sqrt(3) / 2)
        columns = np.arange(-0.5 * spacing, size[0] + spacing, spacing)
        lattice = np.array([(c + (r % 2) * spacing / 2, v) for r, v in enumerate(rows) for c in columns]) + low
        lattice += random.uniform(-0.1, 0.1, lattice.shape) * spacing
        lattice = lattice[inside(outline, lattice)]
        found = lattice[(_distance(outline, lattice) > clearance * spacing) & _beyond_corners(outline, lattice)]
        if len(found) >= interior:
            break
        spacing *= 0.99
        if attempt % 20 == 19:
            clearance *= 0.8  # narrow panels
    # What is too many leaves evenly: the rest closes up again when relaxed.
    surplus = len(found) - interior
    leaves = np.linspace(0, len(found), max(0, surplus), endpoint=False).astype(int)
    return np.delete(found, leaves, axis=0)


def _faces(points: Floats, outline: Floats) -> Indices:
    faces = delaunay(points, 1e-6 * np.ptp(outline, axis=0).prod() / len(points)).astype(np.int64)
    # Only triangles of points of the outline alone can lie outside.
    keep = (faces >= len(outline)).any(1)
    keep[~keep] = inside(outline, points[faces[~keep]].mean(1))
    return np.asarray(faces[keep], np.int64)


def _improve(points: Floats, faces: Indices, fixed: int) -> bool:
    """Moves free corners of poor triangles to where the smallest angle around them is largest, by a compass search."""
    poor = np.unique(faces[smallest_angles(points, faces) < WANTED_DEGREES])
    order = np.argsort(faces, axis=None, kind="stable")  # corners by their vertex
    first = np.searchsorted(faces.ravel()[order], np.arange(len(points) + 1))
    changed = False
    for vertex in poor[poor >= fixed]:
        around, corner = np.divmod(order[first[vertex] : first[vertex + 1]], 3)
        # Each triangle as (vertex, next corner, last corner).
        ring = points[np.stack([faces[around, (corner + 1) % 3], faces[around, (corner + 2) % 3]], axis=1)]
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
    """Minus the largest cosine of an angle around a vertex, for places of it (k x 2); -2 where one turns over."""
    first, last = ring[None, :, 0] - places[:, None], ring[None, :, 1] - places[:, None]
    across = (ring[:, 1] - ring[:, 0])[None]
    a, b, c = np.linalg.norm(first, axis=2), np.linalg.norm(last, axis=2), np.linalg.norm(across, axis=2)
    cosines = np.stack(
        [(first * last).sum(2) / (a * b), -(first * across).sum(2) / (a * c), (last * across).sum(2) / (b * c)]
    ).max((0, 2))
    over = ((first[..., 0] * last[..., 1] - first[..., 1] * last[..., 0]) <= 0).any(1)
    worst: Floats = np.where(over, -2.0, -cosines)
    return worst


def _check(points: Floats, faces: Indices, outline: Floats, interior: int, where: str) -> None:
    n = len(outline)
    present = {tuple(e) for e in np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).tolist()}
    for i in range(n):
        if (i, (i + 1) % n) not in present:
            raise InvalidInput(
                f"{where}: its outline is finer near ({outline[i, 0]:.4g}, {outline[i, 1]:.4g}) m than the triangles "
                "can follow; ask for more triangles, or leave out the detail"
            )
    if len(faces) != 2 * interior + n - 2:
        raise InvalidInput(
            f"{where}: cannot be triangulated with {interior} points inside and {n} around; ask for another number"
        )
