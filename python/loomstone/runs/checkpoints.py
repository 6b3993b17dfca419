"""Checkpoints of a run as files in its directory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from .. import _core
from .._core import CacheError, Checkpoint

__all__ = ["checkpoint_files", "latest_checkpoint", "readable_checkpoints", "write_checkpoint"]


def checkpoint_files(directory: Path) -> list[Path]:
    """Returns the paths of the checkpoints of a run, oldest first."""
    return sorted(directory.glob("checkpoint-*.h5"))


def write_checkpoint(directory: Path, step: int, checkpoint: Checkpoint) -> None:
    """Writes a checkpoint, and deletes older ones so that the two newest remain."""
    _core.write_checkpoint(str(directory / f"checkpoint-{step:010d}.h5"), checkpoint)
    for old in checkpoint_files(directory)[:-2]:
        old.unlink()


def latest_checkpoint(directory: Path) -> Checkpoint | None:
    """Returns the newest readable checkpoint, or None if there are no checkpoints.

    Raises CacheError if there are checkpoints, but none of them is readable.
    """
    return next(readable_checkpoints(directory), None)


def readable_checkpoints(directory: Path) -> Iterator[Checkpoint]:
    """Yields the readable checkpoints, newest first.

    Raises CacheError if there are checkpoints, but none of them is readable.
    """
    problem: CacheError | None = None
    found = False
    for path in reversed(checkpoint_files(directory)):
        try:
            checkpoint = _core.read_checkpoint(str(path))
        except CacheError as error:
            problem = problem or error
            continue
        found = True
        yield checkpoint
    if problem and not found:
        raise CacheError(
            f"{directory}: none of its checkpoints can be read, so the run cannot be resumed; its"
            f" frames can be rendered. Run the scene again into another directory. ({problem})"
        )
