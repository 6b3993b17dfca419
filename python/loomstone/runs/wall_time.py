"""Wall time of a run, kept in a small file beside the checkpoints.

If a run is resumed, the times of the processes that have advanced it are added. The time of a
process that was killed counts up to its last checkpoint.
"""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

from ..base.replacement import replacement

__all__ = ["WALL_TIME", "WallTime"]

WALL_TIME = "wall_time.json"


class WallTime:
    """The wall time of a run. In a resumed run, the time of earlier processes counts, too.

    before : wall time of the earlier processes [s]; 0 for a new run
    """

    def __init__(self, directory: Path, *, resumed: bool) -> None:
        self._file = directory / WALL_TIME
        self._began = time.perf_counter()
        self.before = 0.0
        if resumed:
            self.before = max(_seconds(path) for path in (self._file, directory / "report.json"))

    def keep(self) -> None:
        """Writes the wall time up to now."""
        seconds = self.before + time.perf_counter() - self._began
        with replacement(self._file) as unfinished:
            unfinished.write_text(json.dumps({"wall_seconds": seconds}) + "\n")


def _seconds(path: Path) -> float:
    """Returns the entry wall_seconds of a file [s]; 0 if the file is absent or damaged."""
    try:
        seconds = float(json.loads(path.read_text())["wall_seconds"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0.0
    return seconds if math.isfinite(seconds) else 0.0
