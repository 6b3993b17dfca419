"""Deforming obstacles from animated characters and objects in USD and glTF files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .._core import InvalidInput, Look, Obstacle, TriangleMesh
from ..base.arguments import takes
from ..exchange.baked import SUFFIXES, joined, read_parts
from ..exchange.parts import Part

__all__ = ["baked"]

_DEFAULT = Obstacle()


@takes(rate="1/s", start="s", friction="1", thickness="m")
def baked(
    path: str | os.PathLike[str],
    *,
    parts: Sequence[str] | None = None,
    animation: str | Sequence[str] = (),
    rate: float | None = None,
    start: float = 0.0,
    name: str = "",
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Obstacle that moves like the meshes of a USD or glTF file.

    Skins, blend shapes and moving nodes are baked to vertices that move linearly between samples.

    path : .usd, .usda, .usdc, .usdz, .gltf or .glb file. Its lengths are converted to metres, and
        its up axis becomes z.
    parts : names, or paths such as "/body/arm", of the meshes that are used; default: all visible
    animation : name of an animation of a glTF file, or names of several that run at the same time;
        needed if the file has more than one
    rate : samples per second [1/s]; default: one sample per time code for USD, 60 per second for
        glTF
    start : time of the first sample [s]
    name : name in reports and files; default: the name of the file without its suffix
    friction : friction coefficient [1]
    thickness : contact distance [m]; 0: the largest thickness of a cloth, or 1 mm without cloth
    look : Look, the colour and texture of the obstacle in pictures; with a texture, the texture
        coordinates of the file are read

    Each sample takes 24 bytes per vertex in memory. Vertices that coincide in all samples are
    joined; if this gives no valid mesh, only vertices of the same mesh are joined. USD needs the
    extra `usd`, glTF the extra `gltf`.

    Raises CacheError if the file cannot be read, Unsupported if the extra is not installed, and
    InvalidInput if the file has no valid visible mesh, if none of the meshes used moves, or if an
    argument is invalid.

    >>> walker = baked("walker.glb", parts=["Body"], animation="Walk")   # doctest: +SKIP
    """
    path = Path(path)
    _check(path, parts, rate)
    names = [animation] if isinstance(animation, str) else list(animation)
    textured = look is not None and look.texture is not None
    found, times = read_parts(path, rate=rate, animation=names, with_uv=textured)
    whole = joined(path, found, None if parts is None else list(parts))
    if (whole.frames == whole.frames[:1]).all():
        raise InvalidInput(
            f"{path}: must move, but is at rest in all {len(times)} samples; use"
            " loomstone.obstacles.mesh(loomstone.meshes.read(path))"
        )
    return Obstacle(
        mesh=_mesh_at_start(path, whole),
        times=times + start,
        vertex_positions=np.ascontiguousarray(whole.frames).reshape(-1, 3),
        name=name or path.stem,
        friction=friction,
        thickness=thickness,
        look=look,
    )


def _check(path: Path, parts: Sequence[str] | None, rate: float | None) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidInput(f"{path}: must end in {', '.join(SUFFIXES)}")
    if isinstance(parts, str):
        raise InvalidInput(f"parts must be a list of names, got {parts!r}")
    if rate is not None and not (np.isfinite(rate) and rate > 0):
        raise InvalidInput(f"rate must be > 0 [1/s], got {rate}; correct this value")


def _mesh_at_start(path: Path, part: Part) -> TriangleMesh:
    try:
        return part.first_mesh()
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}; name the meshes to use by parts") from None
