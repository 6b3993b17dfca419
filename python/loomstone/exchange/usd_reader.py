"""Reads the meshes of a USD file over time; skins and blend shapes are baked by UsdSkel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError, InvalidInput
from .extras import imported
from .parts import Part
from .surfaces import Floats, Indices

__all__ = ["read_usd"]


def read_usd(path: Path, rate: float | None, *, moving: bool) -> tuple[list[Part], Floats]:
    """Reads all visible meshes of a file at its time codes; the times [s] begin at 0.

    Lengths are converted to metres and the up axis to z. Polygons are split into fans; the control
    mesh of a subdivision surface is taken as it is.

    rate : samples per second [1/s]; None: one per time code
    moving : whether the motion is read, or only the first frame
    """
    usd, geometry = imported("pxr.Usd", path), imported("pxr.UsdGeom", path)
    tf = imported("pxr.Tf", path)
    try:
        stage = usd.Stage.Open(str(path))
        codes = _codes(path, stage, rate) if moving else np.array([_first_code(stage)])
        _bake_skins(path, stage, codes)
        prims = [prim for prim in _visible(stage) if prim.IsA(geometry.Mesh)]
        parts = [_part(path, geometry.Mesh(prim), codes, _to_metres(stage)) for prim in prims]
    except tf.ErrorException as error:
        reason = " ".join(str(error).split())[-200:]
        raise CacheError(f"{path}: cannot be read as USD: {reason}") from None
    return parts, (codes - codes[0]) / stage.GetTimeCodesPerSecond()


def _first_code(stage: Any) -> float:
    return float(stage.GetStartTimeCode()) if stage.HasAuthoredTimeCodeRange() else 0.0


def _codes(path: Path, stage: Any, rate: float | None) -> Floats:
    first, last = _first_code(stage), float(stage.GetEndTimeCode())
    if not stage.HasAuthoredTimeCodeRange() or last <= first:
        raise InvalidInput(
            f"{path}: has no animation (no range of time codes); use"
            " loomstone.obstacles.mesh(loomstone.meshes.read(path))"
        )
    step = 1.0 if rate is None else stage.GetTimeCodesPerSecond() / rate
    codes = np.arange(first, last + 1e-6 * step, step)
    return codes if len(codes) > 1 else np.array([first, last])


def _visible(stage: Any) -> Any:
    """Yields the prims that a picture shows, also those inside instances."""
    usd, geometry = imported("pxr.Usd", "usd"), imported("pxr.UsdGeom", "usd")
    hidden = (geometry.Tokens.guide, geometry.Tokens.proxy)
    for prim in usd.PrimRange(stage.GetPseudoRoot(), usd.TraverseInstanceProxies()):
        image = geometry.Imageable(prim)
        if image and (
            image.ComputeVisibility() == geometry.Tokens.invisible
            or image.ComputePurpose() in hidden
        ):
            continue
        yield prim


def _bake_skins(path: Path, stage: Any, codes: Floats) -> None:
    """Replaces skins by points at every time code, in a layer that is not saved."""
    skel, gf = imported("pxr.UsdSkel", path), imported("pxr.Gf", path)
    skinned = False
    for prim in stage.Traverse():
        binding = skel.BindingAPI(prim)
        targets = binding.GetSkeletonRel().GetTargets() if prim.HasAPI(skel.BindingAPI) else []
        for target in targets:
            if not skel.Skeleton(stage.GetPrimAtPath(target)):
                raise InvalidInput(f"{path}: {prim.GetPath()} is bound to {target}, no skeleton")
        skinned = skinned or bool(targets)
    if skinned:
        # BakeSkinning does not convert times between layers, so both need the same rate.
        layer = stage.GetSessionLayer()
        layer.timeCodesPerSecond = stage.GetTimeCodesPerSecond()
        layer.framesPerSecond = stage.GetTimeCodesPerSecond()
        stage.SetEditTarget(layer)
        skel.BakeSkinning(stage.Traverse(), gf.Interval(float(codes[0]), float(codes[-1])))


def _to_metres(stage: Any) -> Floats:
    """Returns the matrix (3 x 3) that maps points (as rows) of the stage to metres with z up."""
    geometry = imported("pxr.UsdGeom", "usd")
    scale = float(geometry.GetStageMetersPerUnit(stage))
    if geometry.GetStageUpAxis(stage) == geometry.Tokens.z:
        return np.eye(3) * scale
    return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]) * scale


def _part(path: Path, mesh: Any, codes: Floats, to_metres: Floats) -> Part:
    geometry = imported("pxr.UsdGeom", "usd")
    where = f"{path}: {mesh.GetPath()}"
    indices = mesh.GetFaceVertexIndicesAttr()
    if indices.GetNumTimeSamples() > 1:
        raise InvalidInput(f"{where}: must keep its faces, but they change over time")
    frames: list[Floats] = []
    for code in codes:
        found = mesh.GetPointsAttr().Get(float(code))
        if found is None:
            raise InvalidInput(f"{where}: must have points, but has none at time code {code:g}")
        points = np.array(found, float).reshape(-1, 3)
        if frames and points.shape != frames[0].shape:
            raise InvalidInput(
                f"{where}: must keep its {len(frames[0])} points, got {len(points)} at time code"
                f" {code:g}"
            )
        world = np.array(
            geometry.XformCache(float(code)).GetLocalToWorldTransform(mesh.GetPrim()), float
        )
        frames.append((points @ world[:3, :3] + world[3, :3]) @ to_metres)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(float(codes[0])) or [], int)
    corners = np.array(indices.Get(float(codes[0])) or [], int)
    triangles = _triangles(where, counts, corners, len(frames[0]))
    left = mesh.GetOrientationAttr().Get() == geometry.Tokens.leftHanded
    if left != (np.linalg.det(world[:3, :3]) < 0.0):
        triangles = triangles[:, ::-1]
    return Part(mesh.GetPrim().GetName(), triangles, np.array(frames))


def _triangles(where: str, counts: NDArray[Any], corners: NDArray[Any], points: int) -> Indices:
    """Splits polygons into fans from their first corner."""
    if counts.sum() != len(corners) or np.any((corners < 0) | (corners >= points)):
        raise InvalidInput(
            f"{where}: must have faces of its {points} points, got {len(corners)} corners for"
            f" {len(counts)} faces, or a corner beyond the points"
        )
    starts = np.cumsum(counts) - counts
    fans = [
        [corners[start], corners[start + k - 1], corners[start + k]]
        for start, count in zip(starts, counts, strict=True)
        for k in range(2, count)
    ]
    return np.array(fans, np.int64).reshape(-1, 3)
