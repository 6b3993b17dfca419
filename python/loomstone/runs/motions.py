"""Recorded motions of surfaces in a run.

From them, `loomstone replay` predicts the time of collision searches on many ranks.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .._core import CacheError, CollisionRecord

__all__ = ["motion_files", "read_motion", "write_motion"]

_ARRAYS = ("surfaces", "thickness", "triangles", "gap_floor", "x0", "x1")


def motion_files(directory: Path) -> list[Path]:
    """Returns the paths of the recorded motions of a run, in the order of the steps."""
    return sorted((directory / "tasks").glob("step-*.npz"))


def write_motion(directory: Path, step: int, motion: CollisionRecord) -> None:
    """Writes the recorded motion of a step, unless the record has no vertices."""
    if not len(motion.x0):
        return
    folder = directory / "tasks"
    folder.mkdir(exist_ok=True)
    path = folder / f"step-{step:010d}.npz"
    arrays: dict[str, Any] = {name: np.asarray(getattr(motion, name)) for name in _ARRAYS}
    arrays["earlier"] = np.asarray(motion.earlier)
    unfinished = path.with_suffix(".unfinished")
    with unfinished.open("wb") as file:
        np.savez(file, **arrays)
    unfinished.replace(path)


def read_motion(path: Path) -> CollisionRecord:
    """Returns the motion in a file. Its list `earlier` is empty if the file has no such array.

    Raises OSError if the file cannot be read, and CacheError if it is not a recorded motion.
    """
    try:
        with np.load(path) as arrays:
            values: dict[str, Any] = {name: arrays[name] for name in _ARRAYS}
            earlier = list(arrays["earlier"]) if "earlier" in arrays else []
        values["gap_floor"] = float(values["gap_floor"])
        return CollisionRecord(**values, earlier=earlier)
    except OSError:
        raise
    except Exception as error:  # damaged files make numpy and zipfile raise errors of many types
        raise CacheError(f"{path}: is not a recorded motion ({error})") from error
