"""Reduces the strain of a sewn surface before its simulation, by as-rigid-as-possible deformation.

Implements [Sorkine2007] with triangles in place of vertex cells: the rotations of all triangles and
the positions of all vertices are solved for alternately. The method ignores contact, so callers
must check the result for intersections.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["gradients", "relaxed", "stretches"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def gradients(flat: Floats) -> tuple[Floats, Floats]:
    """Returns gradients of the shape functions (m x 3 x 2) [1/m] and areas (m) [m^2] of triangles.

    flat : rest corners (m x 3 x 2) [m]
    """
    # The columns of each matrix are two edge vectors of a triangle.
    edges = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=2)
    inverse = np.linalg.inv(edges)
    area: Floats = np.abs(np.linalg.det(edges)) / 2
    slope = np.stack([-inverse.sum(1), inverse[:, 0], inverse[:, 1]], axis=1)
    return slope, area


def stretches(positions: Floats, triangles: Indices, flat: Floats) -> Floats:
    """Returns the principal stretches (m x 2) [1] of triangles, the larger one first.

    flat : rest corners (m x 3 x 2) [m]
    """
    slope, _ = gradients(flat)
    deformation = np.einsum("tik,tij->tkj", positions[triangles], slope)
    values: Floats = np.linalg.svd(deformation, compute_uv=False)
    return values


def relaxed(
    positions: Floats, triangles: Indices, flat: Floats, *, iterations: int = 150
) -> Floats:
    """Returns positions (n x 3) [m] whose triangles are closer to their rest shapes.

    The centroid of the vertices is kept.

    flat : rest corners (m x 3 x 2) [m]
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    slope, area = gradients(flat)
    n = len(positions)
    entries = np.einsum("t,tia,tja->tij", area, slope, slope)
    rows, columns = np.repeat(triangles, 3, axis=1).ravel(), np.tile(triangles, (1, 3)).ravel()
    matrix = coo_matrix((entries.ravel(), (rows, columns)), shape=(n, n)).tocsc()
    # A weak pull towards the current positions makes the matrix definite.
    pull = 1e-6 * float(matrix.diagonal().mean())
    factor = splu((matrix + pull * _identity(n)).tocsc())
    result = positions.copy()
    for _ in range(iterations):
        deformation = np.einsum("tik,tij->tkj", result[triangles], slope)
        u, _, vt = np.linalg.svd(deformation, full_matrices=False)
        force = np.einsum("t,tka,tia->tik", area, u @ vt, slope)
        right = pull * result
        np.add.at(right, triangles.ravel(), force.reshape(-1, 3))
        result = factor.solve(right)
    shift: Floats = result + (positions.mean(0) - result.mean(0))
    return shift


def _identity(n: int):  # type: ignore[no-untyped-def]
    from scipy.sparse import identity

    return identity(n, format="csc")
