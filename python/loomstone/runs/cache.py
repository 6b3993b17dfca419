"""Frames and checkpoints of a run as files in its directory."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import CacheError, Checkpoint, Frame, FrameReader, FrameTopology

__all__ = ["Run", "checkpoint_files", "latest_checkpoint", "write_checkpoint"]


class Run:
    """Frames of a finished, killed or still running simulation; a sequence of Frame.

    path : directory of the run, or its run.vtkhdf

    >>> run = Run("out/drape")      # doctest: +SKIP
    >>> run[-1].positions.shape     # doctest: +SKIP
    (7396, 3)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        if Path(path).is_dir() and not (Path(path) / "run.vtkhdf").exists():
            raise CacheError(
                f"{path}: holds no run (there is no run.vtkhdf in it); give the directory of a run"
            )
        self._reader = FrameReader(str(path))
        self.directory = Path(path) if Path(path).is_dir() else Path(path).parent

    def __len__(self) -> int:
        return self._reader.n_frames

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        n = len(self)
        if isinstance(index, slice):
            return [self._reader.frame(i) for i in range(n)[index]]
        if not -n <= (index := operator.index(index)) < n:
            raise IndexError(f"frame {index} of {n}")
        return self._reader.frame(index % n)

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(len(self)))

    @property
    def times(self) -> NDArray[np.float64]:
        """(frames) [s]"""
        return self._reader.times

    @property
    def topology(self) -> FrameTopology:
        """What stays the same over the run."""
        return self._reader.topology

    @property
    def metadata(self) -> dict[str, Any]:
        """What the run was made from: scene file, parameters, options. Empty for foreign files."""
        try:
            content = json.loads(self._reader.metadata or "{}")
        except json.JSONDecodeError:
            return {}
        return content if isinstance(content, dict) else {}

    @property
    def metadata_text(self) -> str:
        """The metadata as they are stored."""
        return self._reader.metadata or ""

    @property
    def rate(self) -> float:
        """Frames a second of simulated time [1/s]; 25 where a single frame does not tell."""
        if isinstance(rate := self.metadata.get("rate"), (int, float)):
            return float(rate)
        length = self.times[-1] - self.times[0] if len(self) > 1 else 0.0
        return float(f"{(len(self) - 1) / length:.6g}") if length > 0.0 else 25.0

    def intersecting_pairs(self, index: int = -1) -> list[tuple[int, int]]:
        """Pairs of triangles of a frame that intersect: cloth triangles first, then bodies and
        obstacles.
        """
        points, triangles = self.surface(index)
        return [(int(a), int(b)) for a, b in _core.intersecting_pairs(points, triangles)]

    def surface(self, index: int = -1) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Points (n x 3) [m] and triangles (m x 3) of a frame: cloth, then bodies and obstacles."""
        frame = self[index]
        triangles = np.concatenate(
            [self.topology.triangles, self.topology.body_triangles + len(frame.positions)]
        )
        return np.concatenate([frame.positions, frame.body_positions]), triangles

    def __repr__(self) -> str:
        end = f", to {self.times[-1]:g} s" if len(self) else ""
        return f"Run({str(self.directory)!r}: {len(self)} frames{end})"


def checkpoint_files(directory: Path) -> list[Path]:
    """Checkpoints of a run, oldest first."""
    return sorted(directory.glob("checkpoint-*.h5"))


def write_checkpoint(directory: Path, step: int, checkpoint: Checkpoint) -> None:
    """Writes a checkpoint and keeps one before it."""
    _core.write_checkpoint(str(directory / f"checkpoint-{step:010d}.h5"), checkpoint)
    for old in checkpoint_files(directory)[:-2]:
        old.unlink()


def latest_checkpoint(directory: Path) -> Checkpoint | None:
    """The newest readable checkpoint; None where the run was killed before the first."""
    problem: CacheError | None = None
    for path in reversed(checkpoint_files(directory)):
        try:
            return _core.read_checkpoint(str(path))
        except CacheError as error:
            problem = problem or error
    if problem:
        raise CacheError(
            f"{directory}: none of its checkpoints can be read, so it cannot go on; its frames can"
            f" still be rendered. Run the scene again into another directory. ({problem})"
        )
    return None
