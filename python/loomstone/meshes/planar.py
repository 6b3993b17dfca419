"""Delaunay triangulations in the plane, and the centres that Lloyd's relaxation moves their points
to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["centres", "cross", "delaunay"]

Floats = NDArray[np.float64]


def cross(a: Floats, b: Floats) -> Floats:
    """z of the cross product of vectors (n x 2)."""
    product: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def delaunay(points: Floats, flat: float) -> NDArray[Any]:
    """Faces (m x 3), counter-clockwise, without those of at most `flat` twice their area [m^2]:
    they lie on straight outlines.
    """
    from scipy.spatial import Delaunay  # imported where needed: the command line starts faster

    faces = Delaunay(points).simplices
    corners = points[faces]
    area = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.where(area[:, None] < 0, faces[:, ::-1], faces)[np.abs(area) > flat])


def centres(points: Floats, faces: NDArray[Any]) -> Floats:
    """Centres of the triangles around each point, weighted by area (n x 2); the point itself where
    there are none.
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
