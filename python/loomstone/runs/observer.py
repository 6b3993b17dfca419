"""Interface for reporting the progress of a run."""

from __future__ import annotations

from typing import Protocol

from .._core import Frame, StepReport

__all__ = ["Observer", "Silence"]


class Observer(Protocol):
    """Receives the progress of a run."""

    def start(self, frames: int, done: int) -> None: ...
    def step(self, report: StepReport) -> None: ...
    def frame(self, index: int, frame: Frame) -> None: ...
    def end(self) -> None: ...


class Silence:
    """An observer that ignores all calls."""

    def start(self, frames: int, done: int) -> None: ...
    def step(self, report: StepReport) -> None: ...
    def frame(self, index: int, frame: Frame) -> None: ...
    def end(self) -> None: ...
