"""Reads a mesh of a USD stage over time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import InvalidInput
from .extras import imported
from .parts import Part
from .surfaces import Floats, Indices

__all__ = ["array_of", "mesh_part"]


def array_of(where: str, attribute: Any, code: float | None = None, kind: type = float) -> Any:
    """Returns the value of an attribute as an array, which has no entries if there is no value.

    code : time code; None: the default value
    kind : type of the entries

    Raises InvalidInput if the value cannot be converted to an array of this type.
    """
    value = None
    if attribute:
        value = attribute.Get() if code is None else attribute.Get(code)
    try:
        values: NDArray[Any] = np.array([] if value is None else value, kind)
    except (TypeError, ValueError):
        values = np.array(0)
    if values.ndim == 0:
        raise InvalidInput(
            f"{where}: {attribute.GetName()} cannot be read as an array of {np.dtype(kind)}; its"
            f" type is {attribute.GetTypeName()}"
        )
    return values


def mesh_part(
    path: Path, mesh: Any, place: Callable[[float], Floats], codes: Floats, *, with_uv: bool
) -> Part:
    """Returns the instances of a mesh at time codes as one part. With `with_uv`, the part has the
    texture coordinates of the mesh, if there are any.

    place : function from a time code to matrices (k x 4 x 4), one per instance, that map points (as
        rows) to metres with z up
    """
    geometry = imported("pxr.UsdGeom", "usd")
    where = f"{path}: {mesh.GetPath()}"
    indices, first = mesh.GetFaceVertexIndicesAttr(), float(codes[0])
    counts, corners = _faces(where, mesh, first)
    if indices.GetNumTimeSamples() > 1:
        for code in map(float, codes[1:]):
            if not all(map(np.array_equal, _faces(where, mesh, code), (counts, corners))):
                raise InvalidInput(
                    f"{where}: must keep its faces, but they change at time code {code:g}"
                )
    points = _points(where, mesh, first)
    frames = [_moved(points, place(first))]
    for code in map(float, codes[1:]):
        now = _points(where, mesh, code)
        if now.shape != points.shape:
            raise InvalidInput(
                f"{where}: must keep its {len(points)} points, got {len(now)} at time code {code:g}"
            )
        frames.append(_moved(now, place(code)))
    rows = _triangles(where, counts, corners, points)
    uv = np.full((len(corners), 2), np.nan)
    if with_uv:
        uv = _corner_uv(where, mesh, corners, len(points), first)
    left = mesh.GetOrientationAttr().Get() == geometry.Tokens.leftHanded
    turned = left != (np.linalg.det(place(first)[:, :3, :3]) < 0.0)
    each = [rows[:, ::-1] if reverse else rows for reverse in turned]
    triangles = [corners[mine] + k * len(points) for k, mine in enumerate(each)]
    prim = mesh.GetPrim()
    return Part(
        prim.GetName(),
        str(prim.GetPath()),
        np.concatenate(triangles),
        np.array(frames),
        np.concatenate([uv[mine] for mine in each]),
    )


def _faces(where: str, mesh: Any, code: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """Returns the number of corners of each face, and the points at the corners of all faces."""
    counts = array_of(where, mesh.GetFaceVertexCountsAttr(), code, int).ravel()
    return counts, array_of(where, mesh.GetFaceVertexIndicesAttr(), code, int).ravel()


def _points(where: str, mesh: Any, code: float) -> Floats:
    if not mesh.GetPointsAttr().HasValue():
        raise InvalidInput(f"{where}: must have points, but has none")
    return np.asarray(array_of(where, mesh.GetPointsAttr(), code).reshape(-1, 3))


def _moved(points: Floats, matrices: Floats) -> Floats:
    """Returns the points of all k instances, one instance after the other (k n x 3)."""
    return np.asarray((points @ matrices[:, :3, :3] + matrices[:, 3:, :3]).reshape(-1, 3))


def _corner_uv(where: str, mesh: Any, corners: Indices, points: int, code: float) -> Floats:
    """Returns the texture coordinates of the corners of faces (c x 2); NaN if there are none."""
    geometry = imported("pxr.UsdGeom", "usd")
    primvar = geometry.PrimvarsAPI(mesh).FindPrimvarWithInheritance("st")
    kinds = geometry.Tokens
    kind = primvar.GetInterpolation() if primvar and primvar.HasValue() else kinds.constant
    if kind in (kinds.constant, kinds.uniform):  # one value per mesh or face cannot map an image
        return np.full((len(corners), 2), np.nan)
    uv = np.array(primvar.ComputeFlattened(code), float)
    count = len(corners) if kind == kinds.faceVarying else points
    if uv.shape != (count, 2):
        raise InvalidInput(
            f"{where}: primvars:st must have {count} rows of 2 numbers for the interpolation"
            f" {kind!r}, got {' x '.join(map(str, uv.shape)) or 'none that are valid'}"
        )
    return uv if kind == kinds.faceVarying else uv[corners]


def _triangles(where: str, counts: NDArray[Any], corners: NDArray[Any], points: Floats) -> Indices:
    """Splits polygons into triangles (m x 3), whose entries are indices into `corners`.

    points : (n x 3) points in the first frame
    """
    if (
        np.any(counts < 0)
        or counts.sum() != len(corners)
        or np.any((corners < 0) | (corners >= len(points)))
    ):
        raise InvalidInput(
            f"{where}: the corner counts of its {len(counts)} faces must add up to {len(corners)},"
            f" and each corner must be one of its {len(points)} points"
        )
    start = np.append(0, np.cumsum(counts))
    try:
        return np.asarray(_core.split_polygons(points[corners], start), np.int64)
    except InvalidInput as error:
        raise InvalidInput(f"{where}: {error}") from None
