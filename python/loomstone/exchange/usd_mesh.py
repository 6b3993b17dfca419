"""Reads a mesh of a USD stage over time."""

from __future__ import annotations

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

    Raises InvalidInput if the value is no array of this type.
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
            f"{where}: {attribute.GetName()} must be an array of another type, got"
            f" {attribute.GetTypeName()}"
        )
    return values


def mesh_part(path: Path, mesh: Any, codes: Floats, to_metres: Floats) -> Part:
    geometry = imported("pxr.UsdGeom", "usd")
    where = f"{path}: {mesh.GetPath()}"
    indices = mesh.GetFaceVertexIndicesAttr()
    if indices.GetNumTimeSamples() > 1:
        raise InvalidInput(f"{where}: must keep its faces, but they change over time")
    if not mesh.GetPointsAttr().HasValue():
        raise InvalidInput(f"{where}: must have points, but has none")
    frames: list[Floats] = []
    for code in codes:
        points = array_of(where, mesh.GetPointsAttr(), float(code)).reshape(-1, 3)
        if frames and points.shape != frames[0].shape:
            raise InvalidInput(
                f"{where}: must keep its {len(frames[0])} points, got {len(points)} at time code"
                f" {code:g}"
            )
        world = np.array(
            geometry.XformCache(float(code)).GetLocalToWorldTransform(mesh.GetPrim()), float
        )
        frames.append((points @ world[:3, :3] + world[3, :3]) @ to_metres)
    counts = array_of(where, mesh.GetFaceVertexCountsAttr(), float(codes[0]), int).ravel()
    corners = array_of(where, indices, float(codes[0]), int).ravel()
    triangles = _triangles(where, counts, corners, frames[0])
    left = mesh.GetOrientationAttr().Get() == geometry.Tokens.leftHanded
    if left != (np.linalg.det(world[:3, :3]) < 0.0):
        triangles = triangles[:, ::-1]
    prim = mesh.GetPrim()
    return Part(prim.GetName(), str(prim.GetPath()), triangles, np.array(frames))


def _triangles(where: str, counts: NDArray[Any], corners: NDArray[Any], points: Floats) -> Indices:
    """Splits polygons into triangles; `points` (n x 3) are those of the first frame."""
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
        triangles: Indices = corners[_core.split_polygons(points[corners], start)]
    except InvalidInput as error:
        raise InvalidInput(f"{where}: {error}") from None
    return triangles
