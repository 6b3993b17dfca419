"""Unstructured meshes within a convex outline, by Lloyd's relaxation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .._core import TriangleMesh
from . import planar

__all__ = ["relaxed"]

Floats = NDArray[np.float64]


def relaxed(
    outline: Floats,
    depth: Callable[[Floats], Floats],
    box: tuple[float, float],
    edge: float,
    triangles: int,
    seed: int,
) -> TriangleMesh:
    """Returns an unstructured mesh within a convex outline.

    outline : (b x 2) points that stay fixed: those of the outline, and possibly others inside [m]
    depth : function that returns lower bounds on the distances of points (n x 2) from the boundary
        of the region in which interior points start [m]; negative outside this region
    box : width and height of a box about the origin that contains the outline [m]
    edge : target edge length [m]
    triangles : intended number of triangles. The number of interior points follows from Euler's
        formula, triangles = 2 (interior points) + (points of `outline`) - 2, rounded down and at
        least 0. Each point of `outline` that lies inside the outline adds one more triangle.
    seed : seed of the random start positions of interior points
    """
    random = np.random.default_rng(seed)
    n_interior = max(0, (triangles + 2 - len(outline)) // 2)
    interior = np.empty((0, 2))
    spacing = edge
    while len(interior) < n_interior:  # until the jittered hexagonal lattice is dense enough
        rows = np.arange(-box[1] / 2, box[1] / 2 + spacing, spacing * np.sqrt(3) / 2)
        columns = np.arange(-box[0] / 2, box[0] / 2 + spacing, spacing)
        lattice = np.array(
            [(c + (r % 2) * spacing / 2, y) for r, y in enumerate(rows) for c in columns]
        )
        lattice += random.uniform(-0.35, 0.35, lattice.shape) * spacing
        interior = lattice[depth(lattice) > 0.45 * spacing]
        spacing *= 0.98
    interior = interior[np.sort(random.permutation(len(interior))[:n_interior])]
    for _ in range(30):
        points = np.concatenate([outline, interior])
        interior = planar.centres(points, _faces(points, edge))[len(outline) :]
    points = np.concatenate([outline, interior])
    return TriangleMesh(np.c_[points, np.zeros(len(points))], _faces(points, edge), points)


def _faces(points: Floats, edge: float) -> NDArray[np.int32]:
    return np.ascontiguousarray(planar.delaunay(points, 1e-6 * edge**2), np.int32)
