"""Normals of the corners of triangles, smooth except across sharp edges."""

from __future__ import annotations

import numpy as np

from .surfaces import Floats, Indices

__all__ = ["corner_normals"]


def corner_normals(points: Floats, triangles: Indices, crease: float = 40.0) -> Floats:
    """Returns the unit normals (3 m x 3) at the corners of m triangles.

    Each has the direction of the area-weighted mean of the normals of the triangles around the
    corner's vertex, or (0, 0, 1) if this mean vanishes. Triangles whose normals deviate by `crease`
    [degrees] or more from that of the corner's own triangle do not count.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    length = np.linalg.norm(area, axis=1, keepdims=True)
    unit = area / np.where(length > 0.0, length, 1.0)
    corners, others = _pairs_around_vertices(triangles)
    face, other = corners // 3, others // 3
    near = np.einsum("ij,ij->i", unit[face], unit[other]) > np.cos(np.radians(crease))
    normals = np.zeros((3 * len(triangles), 3))
    for axis in range(3):
        weights = area[other[near], axis]
        normals[:, axis] = np.bincount(corners[near], weights, len(normals))
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(size > 0.0, normals / np.where(size > 0.0, size, 1.0), (0.0, 0.0, 1.0))


def _pairs_around_vertices(triangles: Indices) -> tuple[Indices, Indices]:
    """Returns all ordered pairs of corners with the same vertex, as two arrays.

    They include the pair of each corner with itself.
    """
    vertex = triangles.reshape(-1)
    order = np.argsort(vertex, kind="stable")
    _, first, count = np.unique(vertex[order], return_index=True, return_counts=True)
    own = np.repeat(count, count)  # for each corner in `order`, the number of corners of its vertex
    start = np.repeat(first, count)
    corners = np.repeat(order, own)
    within = np.arange(len(corners)) - np.repeat(np.cumsum(own) - own, own)
    return corners, order[np.repeat(start, own) + within]
