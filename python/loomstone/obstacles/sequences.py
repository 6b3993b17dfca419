"""Deforming obstacles from files: one mesh file per frame, or one file of vertex positions."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import meshes
from .._core import CacheError, InvalidInput, Look, Obstacle, TriangleMesh
from ..base.arguments import takes
from ..exchange.point_caches import read_mdd, read_pc2

__all__ = ["sequence"]

Floats = NDArray[np.float64]
StrPath = str | os.PathLike[str]
_DEFAULT = Obstacle()
_CACHES = (".npy", ".npz", ".pc2", ".mdd")


@takes(rate="1/s", start="s", friction="1", thickness="m")
def sequence(
    source: StrPath | Sequence[StrPath],
    *,
    mesh: TriangleMesh | None = None,
    rate: float | None = None,
    start: float | None = None,
    name: str = "",
    friction: float = _DEFAULT.friction,
    thickness: float = _DEFAULT.thickness,
    look: Look | None = None,
) -> Obstacle:
    """Obstacle whose vertices move as files prescribe, linearly between their frames.

    source : a pattern of mesh files ("body-*.obj", ordered by the numbers in their names), a list
        of mesh files, or one file of vertex positions [m]: .npy (frames x n x 3), .npz (`positions`
        and optionally `times` [s]), .pc2 or .mdd
    mesh : mesh with the triangles and uv, required if `source` contains positions only; default:
        that of the first file, with uv if `look` has a texture
    rate : frames per second [1/s]; default: the times in the file (.npz with times, or .mdd)
    start : time of the first frame [s]; default: that of the file, or 0 if `rate` is given
    name : name in reports and files
    friction : friction coefficient [1]
    thickness : contact distance [m]; 0: the largest thickness of a cloth, or 1 mm without cloth
    look : Look, the colour and texture of the obstacle in pictures

    All frames are kept in memory (24 bytes per vertex and frame). Raises CacheError if a file
    cannot be read or none matches the pattern, and InvalidInput for fewer than two frames, frames
    that do not fit one mesh, positions without `mesh`, an invalid `rate`, or no times and no rate.

    >>> waving = sequence("out/body-*.obj", rate=25)           # doctest: +SKIP
    >>> body = ls.meshes.read("body.obj")                      # doctest: +SKIP
    >>> waving = sequence("body.pc2", mesh=body, rate=25)      # doctest: +SKIP
    """
    one = Path(source) if isinstance(source, (str, os.PathLike)) else None
    if one is not None and one.suffix.lower() in _CACHES:
        if mesh is None:
            raise InvalidInput(
                f"{one}: holds positions only; give the mesh whose vertices move, as"
                " mesh=ls.meshes.read(...)"
            )
        frames, times, step = _read_cache(one)
    else:
        mesh, frames = _read_meshes(_in_order(source), mesh, look)
        times, step = None, 1.0
    if frames.ndim != 3 or frames.shape[1:] != (mesh.n_vertices, 3) or len(frames) < 2:
        raise InvalidInput(
            f"{source}: must hold 2 frames or more of {mesh.n_vertices} vertices (frames x"
            f" {mesh.n_vertices} x 3), got {frames.shape}"
        )
    when = _moments(source, times, len(frames), rate, step, start)
    positions = np.ascontiguousarray(frames, float).reshape(-1, 3)
    return Obstacle(
        mesh=_with_vertices(mesh, positions[: mesh.n_vertices]),
        times=when,
        vertex_positions=positions,
        name=name,
        friction=friction,
        thickness=thickness,
        look=look,
    )


def _with_vertices(mesh: TriangleMesh, vertices: Floats) -> TriangleMesh:
    return TriangleMesh(vertices, mesh.triangles, mesh.uv, uv_triangles=mesh.uv_triangles)


def _moments(
    source: StrPath | Sequence[StrPath],
    times: Floats | None,
    count: int,
    rate: float | None,
    step: float,
    start: float | None,
) -> Floats:
    """Returns the times of the samples [s], shifted so that they begin at `start` if it is given.

    With `rate`, successive samples are `step` frames apart. Without `rate`, the result follows from
    `times`, those of the file (None: the file has none). Raises InvalidInput if `rate` is invalid,
    or if it is None and there is not one time per sample.
    """
    if rate is not None:
        if not (np.isfinite(rate) and rate > 0):
            raise InvalidInput(f"rate must be > 0 [1/s], got {rate}; correct this value")
        times = np.asarray(np.arange(count) * (step / rate), float)
    elif times is None:
        raise InvalidInput(
            f"{source}: has no times; give rate, the number of frames per second [1/s]"
        )
    elif times.shape != (count,):
        raise InvalidInput(f"{source}: must have one time per frame ({count}), got {times.size}")
    return times if start is None else times - times[0] + start


def _in_order(source: StrPath | Sequence[StrPath]) -> list[Path]:
    """Returns the files of a list in its order, or the files that match a pattern, ordered by the
    numbers in their names.
    """
    if not isinstance(source, (str, os.PathLike)):
        return [Path(path) for path in source]
    found = glob.glob(os.fspath(source))
    if not found:
        raise CacheError(
            f"{source}: no file matches; give a pattern such as 'body-*.obj', or a file that"
            f" ends in {', '.join(_CACHES)}"
        )
    return [
        Path(p)
        for p in sorted(
            found,
            key=lambda p: [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", p)],
        )
    ]


def _read_meshes(
    paths: list[Path], mesh: TriangleMesh | None, look: Look | None
) -> tuple[TriangleMesh, Floats]:
    """Returns the mesh, and the vertices of each file (frames x n x 3) [m].

    mesh : mesh whose triangles all files must have; None: that of the first file, with its uv if
        `look` has a texture
    """
    with_uv = look is not None and look.texture is not None
    frames = []
    for path in paths:
        read = meshes.read(path, with_uv=with_uv and mesh is None)
        mesh = read if mesh is None else mesh
        if not np.array_equal(read.triangles, mesh.triangles):
            raise InvalidInput(
                f"{path}: must have the same {mesh.n_triangles} triangles as the frames before it,"
                f" got {read.n_triangles} triangles or different ones"
            )
        frames.append(read.vertices)
    if mesh is None:
        raise InvalidInput("source must name mesh files, got an empty list")
    return mesh, np.array(frames)


def _read_cache(path: Path) -> tuple[NDArray[Any], Floats | None, float]:
    """Returns the positions (memory-mapped if possible), the times (None if the file has none)
    and the number of frames per sample.
    """
    suffix = path.suffix.lower()
    try:
        if suffix == ".pc2":
            positions, step = read_pc2(path)
            return positions, None, step
        return *(read_mdd(path) if suffix == ".mdd" else _read_numpy(path)), 1.0
    except (ValueError, EOFError) as error:
        if isinstance(error, InvalidInput):
            raise
        raise CacheError(f"{path}: cannot be read as vertex positions: {error}") from error
    except OSError as error:
        if isinstance(error, CacheError):
            raise
        raise CacheError(f"{path}: cannot be read: {error.strerror or error}") from error


def _read_numpy(path: Path) -> tuple[NDArray[Any], Floats | None]:
    if path.suffix.lower() == ".npy":
        content, times = np.load(path, mmap_mode="r"), None
    else:
        with np.load(path) as arrays:
            if "positions" not in arrays:
                raise InvalidInput(
                    f"{path}: must hold an array `positions` (frames x n x 3), got"
                    f" {', '.join(arrays) or 'none'}"
                )
            content = arrays["positions"]
            times = np.asarray(arrays["times"], float).ravel() if "times" in arrays else None
    if content.dtype.kind not in "fiu":
        raise InvalidInput(f"{path}: must hold numbers, got {content.dtype}")
    return content, times
