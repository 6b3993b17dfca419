"""A progress bar for a run on a terminal."""

from __future__ import annotations

import sys
import time

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)

from .._core import Frame, StepReport
from .progress_lines import Counts

__all__ = ["Bar"]


class Bar(Counts):
    """Shows a progress bar with the remaining time."""

    def __init__(self) -> None:
        super().__init__()
        self._progress = Progress(
            TextColumn("frame"),
            MofNCompleteColumn(),
            BarColumn(),
            TimeRemainingColumn(),
            TextColumn("{task.description}"),
            console=Console(file=sys.stdout),
        )
        self._task = TaskID(0)

    def start(self, frames: int, done: int) -> None:
        super().start(frames, done)
        self._progress.start()
        self._task = self._progress.add_task("", total=frames, completed=done)

    def step(self, report: StepReport) -> None:
        super().step(report)
        if time.perf_counter() - self._last > 0.1:
            self._last = time.perf_counter()
            self._progress.update(self._task, description=self.status(report.time))

    def say(self, line: str) -> None:
        self._progress.console.print(line, highlight=False)

    def frame(self, index: int, frame: Frame) -> None:
        self._progress.update(self._task, completed=index + 1, description=self.status(frame.time))

    def end(self) -> None:
        self._progress.stop()
