"""Writes the surfaces of a run as sequences of mesh files, or as mesh files with point caches."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from .. import _core
from .._core import InvalidInput, TriangleMesh
from .clip import Clip
from .materials import library_name, material_ranges, write_materials
from .point_caches import mdd_header, pc2_header, write_positions
from .surfaces import Floats, Surface, vertex_colors

__all__ = ["write_meshes", "write_point_caches"]


def write_point_caches(directory: Path, clip: Clip, suffix: str) -> list[Path]:
    """Writes each surface to NAME.obj, and the motion of moving ones to NAME.pc2 or NAME.mdd.

    NAME is the identifier of the surface. NAME.obj shows the first frame, and comes with files of
    its materials. The vertices of both files have the order of the run. Returns the paths of all
    files.
    """
    written = []
    with ExitStack() as open_files:
        caches = []
        for surface, motion in zip(clip.surfaces, clip.motions, strict=True):
            path = directory / f"{surface.identifier}.obj"
            _write_mesh(path, surface, motion.first)
            written += [path, *write_materials(directory, surface)]
            if motion.still:
                continue
            path = directory / f"{surface.identifier}{suffix}"
            written.append(path)
            file = open_files.enter_context(path.open("wb"))
            file.write(_header(clip, suffix, len(motion.first)))
            caches.append((surface, file))
        for frame in clip:
            for surface, file in caches:
                write_positions(file, suffix, surface.positions(frame))
    return written


def write_meshes(directory: Path, clip: Clip, suffix: str) -> list[Path]:
    """Writes each moving surface to NAME-00000.obj or NAME-00000.ply and so on, numbered like
    the frames of the run. Writes each other surface to one file, NAME.obj or NAME.ply. NAME is the
    identifier of the surface. All OBJ files of a surface share its materials. Returns the paths of
    all files.
    """
    written = []
    if suffix == ".obj":
        for surface in clip.surfaces:
            written += write_materials(directory, surface)
    for index, frame in zip(clip.frames, clip, strict=True):
        for surface, motion in zip(clip.surfaces, clip.motions, strict=True):
            if motion.still and index != clip.frames[0]:
                continue
            number = "" if motion.still else f"-{index:05d}"
            path = directory / f"{surface.identifier}{number}{suffix}"
            _write_mesh(path, surface, surface.positions(frame))
            written.append(path)
    return written


def _header(clip: Clip, suffix: str, points: int) -> bytes:
    if suffix == ".mdd":
        return mdd_header(points, clip.times)
    return pc2_header(points, clip.frames.start, clip.frames.step, len(clip))


def _write_mesh(path: Path, surface: Surface, positions: Floats) -> None:
    uv = surface.uv if len(surface.uv) else None
    if surface.texture is not None and path.suffix == ".obj":
        uv = surface.texture_uv  # for the image that the materials name
    uv_triangles = surface.uv_triangles if len(surface.uv) else None
    try:
        mesh = TriangleMesh(positions, surface.triangles, uv, uv_triangles=uv_triangles)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}; point caches and usd can hold this frame") from None
    if path.suffix == ".ply":
        _core.write_mesh(str(path), mesh, colors=vertex_colors(surface))
        return
    library, ranges = library_name(surface), material_ranges(surface)
    _core.write_mesh(str(path), mesh, library=library, materials=ranges)
