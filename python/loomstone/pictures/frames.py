"""The interface of a run for the code that draws pictures, and a check of its frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Protocol

from .._core import CacheError, Frame, FrameTopology, InvalidInput, Scene

__all__ = ["FramesOfRun", "check_frames"]


class FramesOfRun(Protocol):
    """Interface of a run for the code that draws pictures. loomstone.Run implements it."""

    @property
    def directory(self) -> Path: ...

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Frame: ...
    def __iter__(self) -> Iterator[Frame]: ...
    @property
    def topology(self) -> FrameTopology: ...
    @property
    def metadata_text(self) -> str: ...
    def magnetic_scene(self) -> Scene | None: ...


def check_frames(run: FramesOfRun, frames: Sequence[int] | None) -> None:
    """Raises CacheError if a run has no frames, and InvalidInput if it lacks one of `frames`."""
    if not len(run):
        raise CacheError(f"{run.directory} must have frames, but has none yet; render it later")
    if any(not 0 <= i < len(run) for i in frames or ()):
        raise InvalidInput(
            f"frames must be in [0, {len(run) - 1}], got {list(frames or ())}; the run has"
            f" {len(run)} frames"
        )
