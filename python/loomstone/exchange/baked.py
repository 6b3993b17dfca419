"""Surfaces over time, read from files of animated characters and objects."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .._core import CacheError, InvalidInput, TriangleMesh
from .parts import NO_UV, Part
from .surfaces import Floats

__all__ = ["SUFFIXES", "joined", "mesh_at_rest", "read_parts"]

USD = (".usd", ".usda", ".usdc", ".usdz")
GLTF = (".gltf", ".glb")
SUFFIXES = USD + GLTF


def read_parts(
    path: Path, *, rate: float | None, animation: list[str] | None, with_uv: bool
) -> tuple[list[Part], Floats]:
    """Reads the meshes of a USD or glTF file, and the times [s] at which their motion is sampled.

    rate : samples per second [1/s]; None: that of the file, or 60 for glTF
    animation : names of animations (glTF only); an empty list: the only animation, or the motion of
        a USD file; None: only the rest pose (glTF) or the first frame (USD)
    with_uv : whether texture coordinates are read

    Raises CacheError if the file cannot be read, and Unsupported if the package for its format is
    missing or the file requires an unknown glTF extension. Raises InvalidInput if the file has no
    visible mesh, if animations of a USD file are named, if the animation is missing or ambiguous or
    has too many samples, or if the data of a mesh are invalid.
    """
    if not path.is_file():
        raise CacheError(f"{path}: cannot be read: there is no such file")
    if path.suffix.lower() in USD:
        from .usd_process import read_usd_apart

        if animation:
            raise InvalidInput(f"{path}: USD has no named animations; leave out animation")
        parts, times = read_usd_apart(path, rate, moving=animation is not None, with_uv=with_uv)
    else:
        from .gltf_reader import read_gltf

        parts, times = read_gltf(path, rate, animation, with_uv=with_uv)
    if not parts:
        raise InvalidInput(f"{path}: must hold a mesh, but holds none that is visible")
    return parts, times


def joined(path: Path, parts: list[Part], names: list[str] | None) -> Part:
    """Joins parts into one part; vertices that always coincide become one vertex.

    If the result is not a valid mesh, for example because boxes touch along an edge, only vertices
    of the same part are joined.

    names : names or paths of the parts that are used; None: all

    Raises InvalidInput if `names` is empty or contains an unknown or ambiguous name, or if some
    parts have texture coordinates and others do not.
    """
    chosen = parts
    if names is not None:
        paths = {_path_named(path, parts, name) for name in names}
        chosen = [part for part in parts if part.path in paths]
    if not chosen:
        raise InvalidInput(f"{path}: parts must name a mesh, one of {_listed(parts)}")
    _check_uv(path, chosen)
    whole = _welded(_together(path.stem, chosen))
    try:
        TriangleMesh(whole.frames[0], whole.triangles)
    except InvalidInput:
        return _together(path.stem, [_welded(part) for part in chosen])
    return whole


def _path_named(path: Path, parts: list[Part], name: str) -> str:
    """Returns the path of the part with the name `name`, or else of the part with the path `name`.

    The first slash of the path may be left out. Several parts of a glTF file may have this path.
    Raises InvalidInput if no part has this name or path, or if parts of this name differ in path.
    """
    found = list(dict.fromkeys(part.path for part in parts if part.name == name))
    if len(found) > 1:
        raise InvalidInput(
            f"{path}: parts must tell its meshes apart, but {len(found)} have the name {name!r};"
            f" name them by their paths, {', '.join(map(repr, found))}"
        )
    found = found or [part.path for part in parts if part.path in (name, f"/{name}")]
    if not found:
        raise InvalidInput(
            f"{path}: parts must be names of its meshes, {_listed(parts)}, got {name!r}"
        )
    return found[0]


def _listed(parts: list[Part]) -> str:
    """Returns the names of parts for a message. Parts with equal names are listed by path."""
    names = [part.name for part in parts]
    shown = [part.name if names.count(part.name) == 1 else part.path for part in parts]
    return ", ".join(map(repr, dict.fromkeys(shown)))


def _check_uv(path: Path, parts: list[Part]) -> None:
    """Raises InvalidInput if some triangles have texture coordinates and others do not."""
    without = [part for part in parts if np.isnan(part.corner_uv).any()]
    if without and any(np.isfinite(part.corner_uv).any() for part in parts):
        raise InvalidInput(
            f"{path}: either all meshes must have texture coordinates or none, but"
            f" {without[0].path!r} has none ({NO_UV})"
        )


def _together(name: str, parts: list[Part]) -> Part:
    """Returns the parts as one part, without joining vertices."""
    starts = np.cumsum([0, *(part.frames.shape[1] for part in parts)])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    frames = np.concatenate([part.frames for part in parts], 1)
    uv = np.concatenate([part.corner_uv for part in parts])
    return Part(name, f"/{name}", np.concatenate(triangles), frames, uv)


def mesh_at_rest(path: Path, *, with_uv: bool) -> TriangleMesh:
    """Reads the meshes of a file as one mesh, in the first frame (USD) or the rest pose (glTF)."""
    parts, _ = read_parts(path, rate=None, animation=None, with_uv=with_uv)
    whole = joined(path, parts, None)
    try:
        return whole.first_mesh()
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def _welded(part: Part) -> Part:
    """Joins vertices that coincide in all frames, to single precision.

    Triangles with two equal corners are left out, and so are vertices without triangles.

    Files repeat vertices where uv or normals differ, but adjacent triangles must share vertices.
    """
    count = part.frames.shape[1]
    paths = np.ascontiguousarray(part.frames.transpose(1, 0, 2).astype(np.float32)).reshape(
        count, -1
    )
    paths += 0.0  # turns -0 into 0, because rows are compared bitwise
    keys = paths.view(np.dtype((np.void, paths.itemsize * paths.shape[1]))).ravel()
    _, first, index = np.unique(keys, return_index=True, return_inverse=True)
    triangles = first[index.reshape(-1)][part.triangles]
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    used, triangles = np.unique(triangles[whole], return_inverse=True)
    frames, uv = part.frames[:, used], part.corner_uv[whole]
    return Part(part.name, part.path, triangles.reshape(-1, 3), frames, uv)
