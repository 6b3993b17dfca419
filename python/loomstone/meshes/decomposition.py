"""Convex parts of a solid, for rigid bodies that are not convex."""

from __future__ import annotations

import numpy as np

from .._core import InvalidInput, TriangleMesh, Unsupported
from ..base.arguments import takes

__all__ = ["convex_parts"]


@takes(threshold="1")
def convex_parts(
    mesh: TriangleMesh, *, threshold: float = 0.05, seed: int = 1
) -> list[TriangleMesh]:
    """Decomposes a closed mesh into convex parts, for RigidBody(shape="parts", parts=...).

    The decomposition is that of CoACD (Wei and others, 2022).

    threshold : largest concavity of a part relative to the size of `mesh` [1], 0.01 to 1
    seed : seed of the tree search

    The result depends on the version of coacd. To repeat a run on another machine, save the parts
    in a file.

    Raises InvalidInput if the mesh is not closed, and Unsupported without the package coacd.
    """
    if not mesh.closed:
        raise InvalidInput(
            "convex_parts: mesh must be closed, got one with open edges; close its holes"
        )
    try:
        import coacd
    except ImportError:
        raise Unsupported(
            "convex_parts needs the package coacd, which is not installed; pip install coacd"
        ) from None
    coacd.set_log_level("error")
    shape = coacd.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles))
    parts = coacd.run_coacd(shape, threshold=threshold, seed=seed)
    return [
        TriangleMesh(np.asarray(vertices, float), np.asarray(triangles, np.int32))
        for vertices, triangles in parts
    ]
