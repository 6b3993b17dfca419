"""Writes Alembic: deforming surfaces as samples of points, rigid ones as samples of transforms.

Alembic has y up and clockwise faces, so points are rotated and faces are reversed. The files
contain no materials. Colours are stored as a parameter of the vertices: Cd, in linear RGB.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import __version__
from .clip import Clip
from .corner_normals import corner_normals
from .extras import imported
from .motions import Motion
from .surfaces import Floats, Surface, linear_rgb, vertex_colors, vertex_normals

__all__ = ["write_alembic"]

_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # rotates from z up to y up


def write_alembic(path: Path, clip: Clip) -> None:
    """Writes a clip to an .abc file.

    Raises OSError if the file cannot be written, and Unsupported without the package alembic3d.
    """
    abc, abstract = imported("alembic3d.Abc", path), imported("alembic3d.AbcCoreAbstract", path)
    try:
        archive = abc.CreateArchiveWithInfo(str(path), f"loomstone {__version__}", "")
    except RuntimeError as error:
        raise OSError(0, _reason(error)) from None
    times = clip.times
    step = float(times[1] - times[0]) if len(times) > 1 else 1.0 / clip.run.rate
    sampling = archive.addTimeSampling(abstract.TimeSampling(step, float(times[0])))
    written = [
        _Mesh(archive.getTop(), surface, motion, sampling)
        for surface, motion in zip(clip.surfaces, clip.motions, strict=True)
    ]
    try:
        for index, frame in enumerate(clip):
            for mesh in written:
                mesh.add(index, mesh.surface.positions(frame))
    except RuntimeError as error:
        raise OSError(0, _reason(error)) from None


class _Mesh:
    """The mesh of a surface, and the transform node above it."""

    def __init__(self, parent: Any, surface: Surface, motion: Motion, sampling: int) -> None:
        geometry = imported("alembic3d.AbcGeom", "abc")
        self.surface, self._motion, self._geometry = surface, motion, geometry
        moving = motion.rigid and not motion.still
        self._pose = geometry.OXform(parent, surface.identifier, sampling if moving else 0)
        name = f"{surface.identifier}_surface"
        shape = 0 if motion.rigid else sampling
        self._mesh = geometry.OPolyMesh(self._pose, name, shape)
        self._faces = _integers(surface.triangles[:, ::-1])
        self._counts = _integers(np.full(len(surface.triangles), 3))
        self._uv = geometry.OV2fGeomParamSample()
        if len(surface.uv):
            corners = _unsigned(surface.uv_triangles[:, ::-1])
            scope = geometry.GeometryScope.kFacevaryingScope
            self._uv = geometry.OV2fGeomParamSample(_vectors(surface.uv), corners, scope)
        self._add_colors()
        if not moving:
            self._pose.getSchema().set(geometry.XformSample())

    def _add_colors(self) -> None:
        geometry = self._geometry
        linear = linear_rgb(vertex_colors(self.surface)).astype(np.float32)
        imath = imported("imath", "abc")
        colors = imath.C3fArray(len(linear))
        for channel, values in zip("rgb", np.ascontiguousarray(linear.T), strict=True):
            getattr(colors, channel)[:] = imath.FloatArrayFromBuffer(values)
        vertex = geometry.GeometryScope.kVertexScope
        parameters = self._mesh.getSchema().getArbGeomParams()
        stored = geometry.OC3fGeomParam(parameters, "Cd", False, vertex, 1)
        stored.set(geometry.OC3fGeomParamSample(colors, vertex))

    def add(self, index: int, positions: Floats) -> None:
        """Adds a frame: the points of a deforming surface, or the pose of a moving rigid one.

        The first frame of a rigid surface also adds its points.
        """
        motion = self._motion
        if not motion.rigid:
            normals = vertex_normals(positions, self.surface.triangles)
            self._add_points(positions, normals, per_corner=False)
            return
        if index == 0:
            points = motion.first if motion.still else motion.local
            normals = corner_normals(points, self.surface.triangles)
            self._add_points(points, normals, per_corner=True)
        if not motion.still:
            sample = self._geometry.XformSample()
            turn = _UP @ motion.rotations[index] @ _UP.T
            pose = np.eye(4)  # for row vectors: point @ pose
            pose[:3, :3], pose[3, :3] = turn.T, _UP @ motion.centres[index]
            sample.setMatrix(imported("imath", "abc").M44d(*pose.reshape(-1).tolist()))
            self._pose.getSchema().set(sample)

    def _add_points(self, points: Floats, normals: Floats, *, per_corner: bool) -> None:
        """Adds points, with one normal per vertex or one normal per corner of the triangles."""
        scope = self._geometry.GeometryScope
        if per_corner:
            normals = normals.reshape(-1, 3, 3)[:, ::-1].reshape(-1, 3)
        normal = self._geometry.ON3fGeomParamSample(
            _vectors(normals @ _UP.T),
            scope.kFacevaryingScope if per_corner else scope.kVertexScope,
        )
        sample = self._geometry.OPolyMeshSchemaSample(
            _vectors(points @ _UP.T), self._faces, self._counts, self._uv, normal
        )
        self._mesh.getSchema().set(sample)


def _vectors(values: Floats) -> Any:
    make = getattr(imported("imath", "abc"), f"V{values.shape[1]}fArrayFromBuffer")
    return make(np.ascontiguousarray(values, np.float32))


def _integers(values: NDArray[Any]) -> Any:
    flat = np.ascontiguousarray(values.reshape(-1), np.int32)
    return imported("imath", "abc").IntArrayFromBuffer(flat)


def _unsigned(values: NDArray[Any]) -> Any:
    made = imported("imath", "abc").UnsignedIntArray(values.size)
    for index, value in enumerate(values.reshape(-1).tolist()):
        made[index] = value
    return made


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[-200:]
