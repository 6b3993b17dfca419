"""Options with which a run was continued, where they differ from those with which it began.

The metadata in run.vtkhdf are those of the beginning. The file extension.json replaces some of
their entries: a longer duration, and whether a control function was given.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from .._core import CacheError
from ..base.replacement import replacement
from .options import RunOptions

__all__ = ["EXTENSION", "extend", "extension"]

EXTENSION = "extension.json"


def extension(directory: Path) -> dict[str, Any]:
    """Returns the metadata that continuing the run has changed; none if there is no file.

    Raises CacheError if the file cannot be read.
    """
    file = directory / EXTENSION
    try:
        changed = json.loads(file.read_text())
        told = _damage(changed)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        told = str(error)
    if told:
        raise CacheError(
            f"{file} cannot be read: {told}; remove it to keep the duration with which the run"
            " began"
        )
    return dict(changed)


def _damage(changed: Any) -> str:
    """Returns what is wrong with the content of the file, or an empty string."""
    if not isinstance(changed, dict) or not set(changed) <= {"duration", "control"}:
        return "it must be a JSON object with the entries duration and control"
    duration = changed.get("duration", 0.0)
    if isinstance(duration, bool) or not isinstance(duration, (int, float)):
        return f"duration must be a number, got {duration!r}"
    if not math.isfinite(duration) or not isinstance(changed.get("control", True), bool):
        return "duration must be finite, and control true or false"
    return ""


def extend(
    directory: Path, metadata: dict[str, Any], options: RunOptions, *, controlled: bool
) -> None:
    """Records a longer duration, and the first use of a control function, in extension.json.

    metadata : metadata of the run with earlier extensions; `options` are compared with them
    """
    new: dict[str, Any] = {}
    if options.duration > metadata.get("duration", options.duration):
        new["duration"] = options.duration
    if controlled and not metadata.get("control", False):
        new["control"] = True
    if new:
        text = json.dumps(extension(directory) | new)
        with replacement(directory / EXTENSION) as unfinished:
            unfinished.write_text(text + "\n")
