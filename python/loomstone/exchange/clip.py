"""The part of a run that is exported: some of its frames, with all surfaces and their motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from .._core import Frame, FrameTopology
from .motions import Motion, motions_of
from .selection import selected
from .surfaces import Floats, Surface, surfaces_of

__all__ = ["Clip", "FramesOfRun", "clip_of"]


class FramesOfRun(Protocol):
    """The interface through which exports read a run; loomstone.Run implements it."""

    @property
    def directory(self) -> Path: ...

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Frame: ...
    @property
    def times(self) -> Floats: ...
    @property
    def rate(self) -> float: ...
    @property
    def topology(self) -> FrameTopology: ...


@dataclass(frozen=True)
class Clip:
    """Selected frames of a run, with its surfaces and their motions.

    progress : function that is called with 1 after each frame
    """

    run: FramesOfRun
    frames: range
    surfaces: list[Surface]
    motions: list[Motion]
    progress: Callable[[int], None]

    @property
    def times(self) -> Floats:
        """(f) times of the frames [s]."""
        return np.asarray(self.run.times, float)[list(self.frames)]

    @property
    def largest_size(self) -> int:
        """Estimated upper bound on the size [bytes] of a binary USD or Alembic file.

        A glTF file can be larger: each deforming surface adds about frames^2 weights of 4 bytes.

        The libraries for USD and Alembic do not report a full disk reliably, and alembic3d even
        ends the process, so the free space is checked before they write.
        """
        size = 2**20
        for surface, motion in zip(self.surfaces, self.motions, strict=True):
            frames = 1 if motion.rigid else len(self)
            size += (24 * frames + 12) * len(motion.first) + 2**10 * frames
            size += 60 * len(surface.triangles)
            size += 8 * len(surface.uv) + 2**8 * len(self)
            size += 2**12 + surface.texture.nbytes if surface.texture is not None else 0
        return size

    def __len__(self) -> int:
        return len(self.frames)

    def __iter__(self) -> Iterator[Frame]:
        for index in self.frames:
            yield self.run[index]
            self.progress(1)


def clip_of(
    run: FramesOfRun, frames: range | None, every: int, progress: Callable[[int], None]
) -> Clip:
    """Returns a clip of the selected frames of a run.

    Reads these frames once to find the motions, and calls `progress` with 1 after each.
    """
    chosen = selected(len(run), frames, every)
    surfaces = surfaces_of(run.topology)
    motions = motions_of(surfaces, lambda: (run[i] for i in chosen), len(chosen), progress)
    return Clip(run, chosen, surfaces, motions, progress)
