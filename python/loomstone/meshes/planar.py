"""Delaunay triangulations in the plane, and centroids for Lloyd's relaxation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["centres", "cross", "delaunay"]

Floats = NDArray[np.float64]


def cross(a: Floats, b: Floats) -> Floats:
    """Returns the z components (n) of the cross products of the rows of a and b (n x 2)."""
    product: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def delaunay(points: Floats, flat: float) -> NDArray[Any]:
    """Returns the counter-clockwise triangles (m x 3) of a Delaunay triangulation.

    Triangles whose doubled area is at most `flat` [m^2] are left out, because they only connect
    points of a straight outline.
    """
    from scipy.spatial import Delaunay  # a late import, so that the command line starts faster

    faces = Delaunay(points).simplices
    corners = points[faces]
    area = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.where(area[:, None] < 0, faces[:, ::-1], faces)[np.abs(area) > flat])


def centres(points: Floats, faces: NDArray[Any]) -> Floats:
    """Returns the area-weighted centroid of the triangles around each point (n x 2).

    A point without triangles keeps its position.
    """
    corners = points[faces]
    area = np.abs(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    weighted = area[:, None] * corners.mean(1)
    total, moment = np.zeros(len(points)), np.zeros((len(points), 2))
    for corner in range(3):
        np.add.at(total, faces[:, corner], area)
        np.add.at(moment, faces[:, corner], weighted)
    result = points.copy()
    some = total > 0
    result[some] = moment[some] / total[some, None]
    return result
