"""Directories of pictures.

Such a directory contains the pictures of one run: frame-00000.png and so on, all drawn with the
options in its options.json.
"""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from .._core import CacheError, Camera, InvalidInput, RenderOptions

__all__ = [
    "claim",
    "drawn_with",
    "is_whole",
    "make_directory",
    "note_of",
    "options_from_dict",
    "picture",
    "pictures_in",
    "remove_pictures",
    "write_note",
]

# The last chunk of a PNG file: its length, its name and its checksum.
_END = b"\0\0\0\0IEND\xaeB`\x82"


def options_from_dict(values: dict[str, Any]) -> RenderOptions:
    """Restores RenderOptions from the values that to_dict() returned."""
    # In files of older versions, equal values at both ends of the colour map mean automatic ends.
    if values.get("color_low") is not None and values["color_low"] == values.get("color_high"):
        values = values | {"color_low": None, "color_high": None}
    if "camera" not in values:
        return RenderOptions(**values)
    given = {name: value for name, value in values["camera"].items() if value != []}
    return RenderOptions(**(values | {"camera": Camera(**given)}))


def picture(directory: Path, index: int) -> Path:
    """Returns the path of the picture of a frame."""
    return directory / f"frame-{index:05d}.png"


def note_of(directory: Path) -> dict[str, Any]:
    """Returns the content of options.json in a directory, or {} if it is missing or invalid."""
    try:
        found = json.loads((directory / "options.json").read_text())
        options_from_dict(found["options"])
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return {}  # missing, damaged or of another version
    return found if isinstance(found, dict) else {}


def write_note(directory: Path, note: dict[str, Any]) -> None:
    """Replaces the content of options.json in a directory."""
    unfinished = directory / "unfinished-options.json"
    unfinished.write_text(json.dumps(note))
    unfinished.replace(directory / "options.json")


def is_whole(path: Path) -> bool:
    """Returns whether a picture (PNG) exists and ends with the last chunk of a PNG file."""
    try:
        with path.open("rb") as file:
            file.seek(-len(_END), 2)
            return file.read() == _END
    except OSError:  # there is no such file, or it is shorter
        return False


def pictures_in(directory: Path) -> list[Path]:
    """Returns the paths of the pictures in a directory."""
    return list(directory.glob("frame-[0-9]*.png"))


def remove_pictures(directory: Path) -> None:
    """Removes the pictures in a directory and their options, and the directory if it is empty."""
    notes = [directory / "options.json", directory / "unfinished-options.json"]
    for path in (*pictures_in(directory), *directory.glob("unfinished-frame-[0-9]*.png"), *notes):
        if path.is_file():
            path.unlink()
    with suppress(OSError):  # other files are kept
        directory.rmdir()


def drawn_with(directory: Path) -> RenderOptions | None:
    """Returns the options of the pictures in a directory, or None without a valid options.json."""
    note = note_of(directory)
    return options_from_dict(note["options"]) if note else None


def claim(
    directory: Path, options: RenderOptions, metadata: str, *, again: bool = False, advice: str
) -> dict[str, Any]:
    """Reserves a directory for pictures of one run with these options.

    Returns the content of its options.json.

    metadata : text of the metadata that the run has stored
    again : whether existing pictures are deleted. Otherwise, InvalidInput is raised if options.json
        belongs to another run or has other options, or if there are pictures or a video, but no
        valid options.json.
    advice : end of the message of this InvalidInput
    """
    make_directory(directory)
    wanted = {
        "options": json.loads(json.dumps(options.to_dict())),
        "run": hashlib.sha256(metadata.encode()).hexdigest()[:16],
    }
    note, there = note_of(directory), pictures_in(directory)
    same = all(note.get(name) == value for name, value in wanted.items())
    if not again and not same and (note or there or (directory / "video.mp4").exists()):
        if not note:
            found = f"{'pictures' if there else 'video.mp4'} but no options.json"
        elif note.get("run") != wanted["run"]:
            found = "pictures of another run"
        else:
            differing = [k for k, v in wanted["options"].items() if note["options"].get(k, v) != v]
            found = "pictures drawn with other options" + "".join(
                f", {k} {note['options'].get(k)!r} instead of {wanted['options'][k]!r}"
                for k in differing[:1]
            )
        raise InvalidInput(f"{directory} holds {found}; {advice}")
    if again or not same:
        for path in there:
            path.unlink()
        note = wanted
        write_note(directory, note)
    return note


def make_directory(directory: Path) -> None:
    """Creates a directory; raises CacheError if that is not possible."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CacheError(
            f"{directory} must be a directory that can be written: {error.strerror}; give another"
        ) from error
