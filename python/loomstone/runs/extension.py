"""Options with which a run was continued, where they differ from those with which it began.

The metadata in run.vtkhdf are those of the beginning. The file extension.json replaces some of
their entries: a longer duration, and whether a control function was given.
"""

from __future__ import annotations

import json
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
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise CacheError(f"{file} cannot be read: {error}") from error
    if not isinstance(changed, dict):
        raise CacheError(f"{file} cannot be read: it must contain a JSON object")
    return changed


def extend(
    directory: Path, metadata: dict[str, Any], options: RunOptions, *, controlled: bool
) -> None:
    """Stores a longer duration, or that a control function is given, beside a continued run.

    metadata : those of the run, with earlier extensions
    """
    changed = extension(directory)
    if options.duration > metadata.get("duration", options.duration):
        changed["duration"] = options.duration
    if controlled and not metadata.get("control", False):
        changed["control"] = True
    if changed != extension(directory):
        with replacement(directory / EXTENSION) as unfinished:
            unfinished.write_text(json.dumps(changed) + "\n")
