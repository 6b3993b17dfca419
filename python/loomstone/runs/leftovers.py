"""Files that a run leaves if it is killed while it writes its first file, run.vtkhdf.

Frames are written under the names of PARTS, which are then changed to those of the finished files.
"""

from __future__ import annotations

from pathlib import Path

__all__ = ["PARTS", "leftovers"]

PARTS = ("run.vtkhdf.part", "bodies.vtkhdf.part")
_OF_PICTURES = {"options.json", "unfinished-options.json"}


def leftovers(directory: Path) -> set[str]:
    """Returns the names of the entries of a directory that are left from a run that saved nothing.

    These are PARTS and, if run.vtkhdf.part is among them, bodies.vtkhdf, and frames/ if it contains
    the options of pictures but no pictures. There are none if the directory has a run.vtkhdf.
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
