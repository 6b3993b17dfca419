"""Reading and writing of mesh files."""

from __future__ import annotations

import os
from pathlib import Path

from .. import _core
from .._core import InvalidInput, TriangleMesh
from ..base.arguments import takes
from ..base.foreign_meshes import converted
from ..exchange.baked import SUFFIXES, mesh_at_rest

__all__ = ["read", "write"]


@takes()
def read(path: str | os.PathLike[str], *, with_uv: bool = True) -> TriangleMesh:
    """Reads a TriangleMesh from a file; polygons are split into triangles.

    OBJ and PLY need no other package. From USD (extra `usd`) and glTF (extra `gltf`), all visible
    meshes are read as one, in the first frame (USD) or at rest (glTF), in metres and with z up.
    Other formats need the package meshio.

    with_uv : whether texture coordinates of OBJ, PLY, USD (primvars:st) and glTF (TEXCOORD_0) are
        read, without scaling; obstacles and bodies need them only for a texture

    Raises CacheError if the file cannot be read or is malformed, InvalidInput if it holds no valid
    mesh, and Unsupported if a package is missing.
    """
    path = Path(path)
    if path.suffix.lower() in (".obj", ".ply"):
        return _core.read_mesh(str(path), with_uv=with_uv)
    if path.suffix.lower() in SUFFIXES:
        return mesh_at_rest(path, with_uv=with_uv)
    try:
        import meshio
    except ImportError:
        raise _core.Unsupported(
            f"{path}: formats other than OBJ, PLY, USD and glTF are read by meshio, which is not"
            " installed; pip install meshio"
        ) from None
    try:
        content = meshio.read(path)
    except (Exception, SystemExit) as error:  # readers of meshio raise errors of all kinds
        raise _core.CacheError(f"{path}: cannot be read as a mesh: {error}") from error
    try:
        mesh = converted(content)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None
    assert mesh is not None  # converted() returns None only for objects that are not meshes
    return mesh


@takes()
def write(path: str | os.PathLike[str], mesh: TriangleMesh) -> None:
    """Writes a mesh in the format of the file's suffix. Formats other than OBJ and PLY need meshio.

    Texture coordinates are written to OBJ and PLY only.

    Raises InvalidInput for an unknown suffix, Unsupported if meshio is missing, and CacheError if
    the file cannot be written.
    """
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
    # meshio raises a ReadError for an unknown suffix even when it writes.
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
