"""Masses of the vertices of a cloth, computed independently of the package."""

import loomstone as ls
import numpy as np


def vertex_masses(mesh: ls.TriangleMesh, density: float) -> np.ndarray:
    """Returns a third of the mass of the triangles around each vertex [kg]."""
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    thirds = density * np.linalg.norm(normals, axis=1) / 6
    return np.bincount(mesh.triangles.ravel(), np.repeat(thirds, 3))
