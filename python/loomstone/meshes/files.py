"""Reading and writing of mesh files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from .. import _core
from .._core import InvalidInput, TriangleMesh
from ..base.arguments import takes

__all__ = ["read", "write"]


@takes()
def read(path: str | os.PathLike[str], *, with_uv: bool = True) -> TriangleMesh:
    """Reads a TriangleMesh from an OBJ or PLY file. Other formats need the package meshio.

    with_uv : whether texture coordinates are read; obstacles and bodies do not need them
    """
    path = Path(path)
    if path.suffix.lower() in (".obj", ".ply"):
        return _core.read_mesh(str(path), with_uv=with_uv)
    try:
        import meshio
    except ImportError:
        raise _core.Unsupported(
            f"{path}: formats other than .obj and .ply are read by meshio, which is not installed;"
            " pip install meshio"
        ) from None
    try:
        content = meshio.read(path)
    except (meshio.ReadError, OSError, SystemExit) as error:
        raise _core.CacheError(f"{path}: cannot be read as a mesh: {error}") from error
    faces = content.get_cells_type("triangle")
    if len(faces) == 0:
        raise InvalidInput(
            f"{path}: must contain triangles, got cells of {[c.type for c in content.cells]}"
        )
    return TriangleMesh(np.c_[content.points, np.zeros((len(content.points), 3))][:, :3], faces)


@takes()
def write(path: str | os.PathLike[str], mesh: TriangleMesh) -> None:
    """Writes a file in the format of its suffix. Formats other than OBJ and PLY need meshio."""
    path = Path(path)
    if path.suffix.lower() in (".obj", ".ply"):
        _core.write_mesh(str(path), mesh)
        return
    try:
        import meshio
    except ImportError:
        raise _core.Unsupported(
            f"{path}: formats other than .obj and .ply are written by meshio, which is not"
            " installed; pip install meshio"
        ) from None
    try:
        meshio.write(path, meshio.Mesh(mesh.vertices, [("triangle", mesh.triangles)]))
    # meshio raises a ReadError for an unknown suffix.
    except (
        meshio.ReadError,
        meshio.WriteError,
        SystemExit,
    ) as error:
        raise InvalidInput(
            f"{path}: must end in .obj, .ply or a format of meshio, such as .stl, .off or .vtk:"
            f" {error}"
        ) from None
    except OSError as error:
        raise _core.CacheError(f"{path}: cannot be written: {error.strerror or error}") from error
