"""Reads the meshes of a USD file over time; skins and blend shapes are baked by UsdSkel."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from .._core import CacheError, Error, InvalidInput
from ..base.cautions import SceneWarning
from .extras import imported
from .parts import MALFORMED, Part, sample_times
from .surfaces import Floats
from .usd_mesh import array_of, mesh_part
from .usd_places import placed_meshes

__all__ = ["read_usd"]


def read_usd(
    path: Path, rate: float | None, *, moving: bool, with_uv: bool = False
) -> tuple[list[Part], Floats]:
    """Returns all visible meshes of a file over time, and the times [s], which begin at 0.

    Lengths are converted to metres and the up axis to z. Polygons are split into triangles.
    A subdivision surface is read as its control mesh.

    rate : samples per second [1/s]; None: one per time code
    moving : whether the motion is read; False: only the first frame is read
    with_uv : whether the texture coordinates `primvars:st` are read

    Issues a SceneWarning if the file has visible shapes that are not meshes.
    """
    usd, tf = imported("pxr.Usd", path), imported("pxr.Tf", path)
    try:
        stage = usd.Stage.Open(str(path))
        per_second = float(stage.GetTimeCodesPerSecond())
        if not 0 < per_second < math.inf:
            raise CacheError(f"{path}: timeCodesPerSecond must be above 0, got {per_second:g}")
        times = _times(path, stage, rate or per_second) if moving else np.zeros(1)
        codes = _first_code(stage) + per_second * times
        _bake_skins(path, stage, codes)
        meshes, left_out = placed_meshes(path, stage, _to_metres(stage), codes)
        parts = [mesh_part(path, mesh, place, codes, with_uv=with_uv) for mesh, place in meshes]
    except tf.ErrorException as error:
        raise CacheError(f"{path}: cannot be read as USD: {_reason(error)}") from None
    except MALFORMED as error:
        if isinstance(error, Error):
            raise
        raise CacheError(f"{path}: is malformed, and cannot be read as USD: {error!r}") from None
    if left_out:
        warnings.warn(
            f"{path}: only meshes are read, so {len(left_out)} other visible shapes are left out:"
            f" {', '.join(left_out[:3])}{', ...' if len(left_out) > 3 else ''}; convert them to"
            " meshes in the program that wrote the file",
            SceneWarning,
            stacklevel=2,
        )
    return parts, times


def _reason(error: Exception) -> str:
    """Returns the last message in an error of usd-core.

    If no message is found, returns the last 200 characters of the error's text.
    """
    text = " ".join(str(error).split())
    messages = re.findall(r"at line \d+ in file \S+ : '(.*?)'(?= Error in |$)", text)
    return messages[-1] if messages else text[-200:]


def _first_code(stage: Any) -> float:
    return float(stage.GetStartTimeCode()) if stage.HasAuthoredTimeCodeRange() else 0.0


def _times(path: Path, stage: Any, rate: float) -> Floats:
    first, last = _first_code(stage), float(stage.GetEndTimeCode())
    if not stage.HasAuthoredTimeCodeRange() or last <= first:
        raise InvalidInput(
            f"{path}: has no animation (no range of time codes); use"
            " loomstone.obstacles.mesh(loomstone.meshes.read(path))"
        )
    return sample_times(path, (last - first) / stage.GetTimeCodesPerSecond(), rate)


def _bake_skins(path: Path, stage: Any, codes: Floats) -> None:
    """Checks skins, and lets UsdSkel bake them: it stores the motion of skinned meshes as points.

    The points are written to the session layer, which is not saved.

    codes : ascending time codes; the points are animated from the first to the last of them
    """
    skel, gf = imported("pxr.UsdSkel", path), imported("pxr.Gf", path)
    skinned = False
    for prim in stage.Traverse():
        binding = skel.BindingAPI(prim)
        targets = binding.GetSkeletonRel().GetTargets() if prim.HasAPI(skel.BindingAPI) else []
        for target in targets:
            _check_skin(f"{path}: {prim.GetPath()}", binding, stage.GetPrimAtPath(target), target)
        skinned = skinned or bool(targets)
    if skinned:
        # BakeSkinning does not convert times between layers, so the session layer must have the
        # rate of the stage.
        layer = stage.GetSessionLayer()
        layer.timeCodesPerSecond = stage.GetTimeCodesPerSecond()
        layer.framesPerSecond = stage.GetTimeCodesPerSecond()
        stage.SetEditTarget(layer)
        skel.BakeSkinning(stage.Traverse(), gf.Interval(float(codes[0]), float(codes[-1])))


def _check_skin(where: str, binding: Any, prim: Any, target: Any) -> None:
    """Raises InvalidInput unless a skin is bound to a skeleton and has valid joint indices.

    If the skeleton has bind poses or rest poses, there must be one per joint.

    UsdSkel reads joints and poses without these checks.
    """
    skeleton = imported("pxr.UsdSkel", "usd").Skeleton(prim)
    if not skeleton:
        raise InvalidInput(f"{where} is bound to {target}, which is not a skeleton")
    joints = len(array_of(where, skeleton.GetJointsAttr(), kind=str))
    for attribute in (skeleton.GetBindTransformsAttr(), skeleton.GetRestTransformsAttr()):
        poses = array_of(where, attribute)
        if attribute.HasValue() and len(poses) != joints:
            raise InvalidInput(
                f"{where}: its skeleton must have {joints} poses, one per joint, got {len(poses)}"
            )
    own = binding.GetJointsAttr()
    count = len(array_of(where, own, kind=str)) if own.HasValue() else joints
    used = array_of(where, binding.GetJointIndicesPrimvar().GetAttr(), kind=int)
    if used.min(initial=0) < 0 or used.max(initial=0) >= count:
        wrong = used.min() if used.min() < 0 else used.max()
        raise InvalidInput(f"{where} uses joint {wrong}, but its skeleton has {count} joints")


def _to_metres(stage: Any) -> Floats:
    """Returns the matrix (4 x 4) that maps points (as rows) of the stage to metres with z up."""
    geometry = imported("pxr.UsdGeom", "usd")
    scale = float(geometry.GetStageMetersPerUnit(stage))
    found = np.eye(4)
    found[:3, :3] *= scale
    if geometry.GetStageUpAxis(stage) != geometry.Tokens.z:
        found[1:3, 1:3] = [[0.0, scale], [-scale, 0.0]]
    return found
