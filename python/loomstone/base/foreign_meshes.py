"""Conversion of meshes of trimesh and meshio to TriangleMesh.

If a parameter accepts a TriangleMesh and its argument has another type, the bindings and
`base.arguments.takes` call `converted`. Neither trimesh nor meshio is imported.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import InvalidInput, TriangleMesh

__all__ = ["converted", "triangles_of_cells"]

_FACES = ("triangle", "quad", "polygon")
# Cells without area, such as those that Gmsh writes in addition to triangles. The error message of
# triangles_of_cells() does not name them.
_IGNORED = ("vertex", "line", "line3")


def converted(value: Any) -> TriangleMesh | None:
    """Returns a trimesh.Trimesh or meshio.Mesh as a TriangleMesh, or None for any other object.

    Vertices [m] keep their order. Polygons are split into triangles. Texture coordinates are left
    out, because the uv of a TriangleMesh are lengths [m].

    Raises InvalidInput for a trimesh.Scene, and for meshes without triangles or polygons, with
    curved faces (such as triangle6 or quad8), with an index out of range, with a polygon whose
    outline crosses itself, or with vertices or triangles that TriangleMesh rejects.
    """
    classes = {(base.__module__.split(".")[0], base.__name__) for base in type(value).__mro__}
    if ("trimesh", "Trimesh") in classes:
        return TriangleMesh(np.array(value.vertices, float), np.array(value.faces))
    if ("trimesh", "Scene") in classes:
        names = ", ".join(map(repr, list(value.geometry)[:8]))
        raise InvalidInput(
            f"a mesh must be one surface, got a trimesh.Scene of {names or 'nothing'}; give one of"
            " its meshes, scene.geometry[NAME], or all of them joined, scene.to_mesh()"
        )
    if ("meshio", "Mesh") in classes:
        points = np.asarray(value.points, float)
        points = np.c_[points, np.zeros((len(points), 3))][:, :3]
        return TriangleMesh(points, triangles_of_cells(value.cells, points))
    return None


def triangles_of_cells(cells: Any, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Returns the triangles (m x 3) of meshio's cell blocks, with polygons split into triangles.

    points : (n x 3) positions of the vertices

    Other cells, such as points, lines and tetrahedra, are ignored. Raises InvalidInput if there are
    no flat triangles or polygons, if there are curved ones, such as triangle6 and quad8, if a cell
    has an index outside `points`, or if the outline of a polygon crosses itself.
    """
    kinds = sorted({block.type for block in cells} - set(_IGNORED))
    faces = [np.asarray(block.data, int) for block in cells if block.type in _FACES]
    curved = [k for k in kinds if k.startswith(("triangle", "quad")) and k not in _FACES]
    if curved or not sum(map(len, faces)):
        raise InvalidInput(
            "a mesh must consist of flat triangles or polygons, got cells of"
            f" {', '.join(kinds) or 'no kind'}; extract the surface first"
        )
    for corners in faces:
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            raise InvalidInput(
                f"a cell must use the {len(points)} points of the mesh, got an index of"
                f" {corners.min() if corners.min() < 0 else corners.max()}"
            )
    return np.concatenate([_split(corners, points) for corners in faces])


def _split(corners: NDArray[np.int64], points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Splits polygons (m x k) with equal numbers of corners into triangles ((k - 2) m x 3)."""
    if corners.shape[1] == 3:
        return corners
    start = corners.shape[1] * np.arange(len(corners) + 1)
    all_corners = corners.ravel()
    return all_corners[_core.split_polygons(points[all_corners], start)]
