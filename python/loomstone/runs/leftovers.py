"""Files that a run leaves if it is killed while it writes its first file, run.vtkhdf.

run.vtkhdf and bodies.vtkhdf are created under the names in PARTS. They are renamed before the
process writes its first new frame. If a run is resumed, its stored frames are copied into the new
files before these are renamed.
"""

from __future__ import annotations

from pathlib import Path

__all__ = ["PARTS", "leftovers"]

PARTS = ("run.vtkhdf.part", "bodies.vtkhdf.part")
_OF_PICTURES = {"options.json", "unfinished-options.json"}


def leftovers(directory: Path) -> set[str]:
    """Returns the names of the entries of a directory that are left from a run that saved nothing.

    These are the files in PARTS. If run.vtkhdf.part exists, bodies.vtkhdf counts, too, and so does
    frames/ if it contains only the options of pictures. The result is empty if the directory has a
    run.vtkhdf.
    """
    if (directory / "run.vtkhdf").exists():
        return set()
    found = {name for name in PARTS if (directory / name).is_file()}
    if PARTS[0] in found and (directory / "bodies.vtkhdf").is_file():
        found.add("bodies.vtkhdf")
    frames = directory / "frames"
    if PARTS[0] in found and frames.is_dir() and not frames.is_symlink():
        names = {path.name for path in frames.iterdir()}
        if names and names <= _OF_PICTURES:
            found.add("frames")
    return found
