"""Points that follow a deforming mesh: they move and turn with the surface next to them.

A displacement and a rotation are fitted to the motion of a patch of triangles around each point
(the orthogonal Procrustes problem), and the point moves by them. The weights of the triangles
change continuously with the point, so neighbouring points move and turn almost equally, even where
different triangles are the closest to them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core import InvalidInput, TriangleMesh
from ..base.arguments import takes

__all__ = ["follow"]

Floats = NDArray[np.float64]
_PATCH = 32  # number of triangles of a patch
# Smallest value of the factor in a triangle's weight that decreases with the distance from the
# point. It keeps the sum of weights positive where all triangles of a patch are equally far away,
# as in the fan at a pole of a sphere.
_FLOOR = 1e-6


@takes(frames="m", points="m")
def follow(mesh: TriangleMesh, frames: ArrayLike, points: ArrayLike) -> Floats:
    """Returns positions (frames x points x 3) [m] of points that follow a deforming mesh.

    mesh : mesh in the pose in which the points are given
    frames : (frames x n x 3) positions of the n vertices of the mesh [m], or the same rows as
        (frames * n x 3), such as `vertex_positions` of an obstacle
    points : (points x 3) positions of the points next to `mesh` [m]

    Each point moves rigidly with the 32 triangles (or all, if there are fewer) whose centres are
    nearest to it: by the displacement and rotation that fit their motion best. The weight of a
    triangle is its area times a factor that decreases with its distance, almost to 0. If the mesh
    moves rigidly, distances between points are kept. If it deforms, the distance of a point from
    the surface changes by hardly more than vertices of these triangles move relative to each other.

    Raises InvalidInput if an array has another shape or contains values that are not finite.

    >>> import loomstone as ls
    >>> ball = ls.meshes.sphere(radius=0.1, subdivisions=2)
    >>> quarter = ball.vertices[:, [1, 0, 2]] * (-1, 1, 1)  # a quarter turn about z
    >>> moved = follow(ball, [ball.vertices, quarter], [(0.12, 0.0, 0.0)])
    >>> bool(np.allclose(moved, [[(0.12, 0.0, 0.0)], [(0.0, 0.12, 0.0)]]))
    True
    """
    start = _rows(points)
    motion = _frames(mesh, frames)
    if len(start) == 0:
        return np.empty((len(motion), 0, 3))
    patch = _Patch.around(mesh, start)
    centre, rest = patch.samples(mesh.vertices)
    moved = np.empty((len(motion), *start.shape))
    for vertices, out in zip(motion, moved, strict=True):
        now, samples = patch.samples(vertices)
        turn = _rotations(rest, samples, patch.weights)
        out[:] = now + np.einsum("pij,pj->pi", turn, start - centre)
    return moved


def _rows(points: ArrayLike) -> Floats:
    array = np.asarray(points, float)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(
            f"follow: points must have the shape (points x 3) [m], got {array.shape}"
        )
    if not np.isfinite(array).all():
        raise InvalidInput("follow: points must be finite numbers [m], got values that are not")
    return array


def _frames(mesh: TriangleMesh, frames: ArrayLike) -> Floats:
    """Returns the frames as an array (frames x n x 3) [m]."""
    array, n = np.asarray(frames, float), mesh.n_vertices
    if array.ndim == 2 and array.shape[1] == 3 and len(array) % n == 0:
        array = array.reshape(-1, n, 3)
    if array.ndim != 3 or array.shape[1:] != (n, 3):
        raise InvalidInput(
            f"follow: frames must have one row per vertex of the mesh (frames x {n} x 3) [m], got"
            f" {array.shape}"
        )
    if not np.isfinite(array).all():
        raise InvalidInput("follow: frames must be finite numbers [m], got values that are not")
    return array


@dataclass(frozen=True)
class _Patch:
    """The triangles around each point, as samples at the midpoints of their edges. Integrals of
    quadratic functions over a triangle are exact with these three samples.
    """

    corners: NDArray[np.int32]  # (points x triangles x 3) vertex indices
    weights: Floats  # (points x samples), with a sum of 1 for each point

    @staticmethod
    def around(mesh: TriangleMesh, points: Floats) -> _Patch:
        from scipy.spatial import cKDTree  # a late import, so that the command line starts faster

        corners = mesh.vertices[mesh.triangles]
        sides = corners[:, 1:] - corners[:, :1]
        area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        count = min(_PATCH, mesh.n_triangles)
        distance, near = cKDTree(corners.mean(1)).query(points, k=range(1, count + 1))
        # The farthest triangle has almost no weight, so another one can replace it smoothly.
        share = 1.0 - (distance / distance[:, -1:].clip(np.finfo(float).tiny)) ** 2
        weights = area[near] * np.maximum(share**2, _FLOOR)
        weights = np.repeat(weights / (3.0 * weights.sum(1, keepdims=True)), 3, axis=1)
        return _Patch(mesh.triangles[near], weights)

    def samples(self, vertices: Floats) -> tuple[Floats, Floats]:
        """Returns, for a mesh with these vertices, the weighted mean of each patch's samples
        (points x 3) [m], and the samples relative to this mean (points x samples x 3) [m].
        """
        corners = vertices[self.corners]
        middles = (0.5 * (corners + np.roll(corners, 1, axis=2))).reshape(len(corners), -1, 3)
        mean: Floats = np.einsum("ps,psi->pi", self.weights, middles)
        return mean, middles - mean[:, None]


def _rotations(before: Floats, after: Floats, weights: Floats) -> Floats:
    """Returns the rotations (points x 3 x 3) that map `before` to `after` with the least weighted
    sum of squared distances.
    """
    covariance = np.einsum("ps,psi,psj->pij", weights, after, before, optimize=True)
    left, _, right = np.linalg.svd(covariance)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    rotations: Floats = left @ right
    return rotations
