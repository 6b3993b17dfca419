"""Who is told how far a run is."""

from __future__ import annotations

from typing import Protocol

from .._core import Frame, StepReport

__all__ = ["Observer", "Silence"]


class Observer(Protocol):
    """Who is told how far a run is."""

    def start(self, frames: int, done: int) -> None: ...
    def step(self, report: StepReport) -> None: ...
    def frame(self, index: int, frame: Frame) -> None: ...
    def end(self) -> None: ...


class Silence:
    """An observer that says nothing."""

    def start(self, frames: int, done: int) -> None: ...
    def step(self, report: StepReport) -> None: ...
    def frame(self, index: int, frame: Frame) -> None: ...
    def end(self) -> None: ...
