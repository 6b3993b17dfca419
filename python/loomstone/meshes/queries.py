"""Queries of meshes: nearest vertices and triangle quality."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._core import TriangleMesh
from ..base.arguments import takes

__all__ = ["nearest_vertices", "quality"]


@takes(points="m")
def nearest_vertices(mesh: TriangleMesh, points: ArrayLike) -> list[int]:
    """Returns the index of the vertex nearest to each of the points (k x 3) [m]."""
    from scipy.spatial import cKDTree  # a late import, so that the command line starts faster

    _, index = cKDTree(mesh.vertices).query(np.asarray(points, float).reshape(-1, 3))
    return [int(i) for i in index]


@takes()
def quality(mesh: TriangleMesh) -> dict[str, float]:
    """Returns the smallest angle of all triangles and the median of their smallest angles
    [degrees], and the ratio of the largest to the smallest area [1].
    """
    corners = mesh.vertices[mesh.triangles]
    sides = np.roll(corners, -1, 1) - corners
    length = np.linalg.norm(sides, axis=2)
    cosine = -np.einsum("tij,tij->ti", sides, np.roll(sides, 1, 1)) / (
        length * np.roll(length, 1, 1)
    )
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1))).min(1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    return {
        "min_angle_degrees": float(angles.min()),
        "median_angle_degrees": float(np.median(angles)),
        "area_ratio": float(area.max() / area.min()),
    }
