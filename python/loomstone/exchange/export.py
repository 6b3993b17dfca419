"""Exports a run: checks the target, chooses the writer of the format, and calls it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Literal, get_args

from .._core import InvalidInput
from .clip import Clip, FramesOfRun, clip_of
from .extras import imported
from .file_sequences import write_meshes, write_point_caches
from .selection import selected
from .surfaces import surfaces_of
from .targets import check_free, has_content, remove_sequences, unfinished, unfinished_directory

__all__ = ["FORMATS", "Format", "export_run", "format_of"]

Format = Literal["usd", "gltf", "alembic", "pc2", "mdd", "obj", "ply"]
FORMATS: tuple[Format, ...] = get_args(Format)

# Suffixes of the formats that write one file (and PNG textures, for USD); the first is the default.
_FILES: dict[Format, tuple[str, ...]] = {
    "usd": (".usdc", ".usd", ".usda"),
    "gltf": (".glb", ".gltf"),
    "alembic": (".abc",),
}

_PACKAGES: dict[Format, str] = {
    "usd": "pxr.Usd",
    "gltf": "pygltflib",
    "alembic": "alembic3d.AbcGeom",
}


def export_run(
    run: FramesOfRun,
    out: str | os.PathLike[str] | None = None,
    *,
    to: Format | None = None,
    frames: range | None = None,
    every: int = 1,
    overwrite: bool = False,
    progress: Callable[[int], None] = lambda _: None,
) -> list[Path]:
    """Writes a run in a format of other programs, as loomstone.Run.export describes.

    progress : function called with the number of frames read since its last call; every selected
        frame is read twice
    """
    path, to = _target(run, out, to)
    selected(len(run), frames, every)
    if to in _PACKAGES:
        imported(_PACKAGES[to], path)
    check_free(path, overwrite=overwrite)
    if to == "usd" and not overwrite:
        from .usd_writer import images

        for image, content in images(path, surfaces_of(run.topology)):
            check_free(image, overwrite=has_content(image, content))
    clip = clip_of(run, frames, every, progress)
    if to in _FILES:
        return [_write_file(path, clip, to)]
    return _write_directory(path, clip, to)


def format_of(name: str | None) -> Format | None:
    """Returns `name` if it is one of FORMATS or None; raises InvalidInput otherwise."""
    found: Format | None = next((known for known in FORMATS if known == name), None)
    if found is None and name is not None:
        raise InvalidInput(f"to must be one of {', '.join(FORMATS)}, got {name!r}")
    return found


def _target(
    run: FramesOfRun, out: str | os.PathLike[str] | None, to: Format | None
) -> tuple[Path, Format]:
    """Returns the path and the format. If one of them is not given, the other determines it.

    Raises InvalidInput for an unknown format, if neither is given, if the path alone is given and
    does not determine the format, or if the path does not fit the format.
    """
    to = format_of(to)
    if out is None:
        if to is None:
            raise InvalidInput(f"a format must be given by --to (to=): {', '.join(FORMATS)}")
        return run.directory / (f"run{_FILES[to][0]}" if to in _FILES else to), to
    path = Path(out)
    suffix = path.suffix.lower()
    found: Format | None = next((name for name, known in _FILES.items() if suffix in known), None)
    to = to or found
    if to is None:
        raise InvalidInput(
            f"{path}: the format does not follow from this name; give it by --to (to=):"
            f" {', '.join(FORMATS)}"
        )
    if to in _FILES and suffix not in _FILES[to]:
        raise InvalidInput(f"{path}: a {to} file must end in {' or '.join(_FILES[to])}")
    if to not in _FILES and path.exists() and not path.is_dir():
        raise InvalidInput(f"{path}: must be a directory, because {to} writes several files")
    return path, to


def _write_file(path: Path, clip: Clip, to: Format) -> Path:
    if to == "usd":
        from .usd_writer import write_usd as write
    elif to == "gltf":
        from .gltf_writer import write_gltf as write
    else:
        from .alembic_writer import write_alembic as write
    text = path.suffix.lower() in (".usda", ".gltf")  # text files: up to about four times as long
    with unfinished(path, size=clip.largest_size * (4 if text else 1)) as partial:
        write(partial, clip)
    return path


def _write_directory(directory: Path, clip: Clip, to: Format) -> list[Path]:
    write = write_meshes if to in ("obj", "ply") else write_point_caches
    suffixes = {f".{to}"} if to == "ply" else {".obj", ".mtl", ".png", f".{to}"}
    with unfinished_directory(directory) as partial:
        written = write(partial, clip, f".{to}")
        remove_sequences(directory, [s.identifier for s in clip.surfaces], sorted(suffixes))
    return [directory / path.name for path in written]
