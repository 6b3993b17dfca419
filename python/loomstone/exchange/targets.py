"""Checks and replaces the file or directory that an export writes."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .._core import CacheError, InvalidInput
from ..base.replacement import replacement, written

__all__ = ["check_free", "has_content", "remove_sequences", "unfinished", "unfinished_directory"]

# Directory in the target of an export that holds the files until all are complete.
_UNFINISHED = "unfinished-export"


def check_free(path: Path, *, overwrite: bool) -> None:
    """Raises InvalidInput if `path` is a file or a non-empty directory, unless `overwrite` is set.

    A directory counts as empty if it contains only _UNFINISHED, left by an export that was killed.
    Creates the parent directory of `path`. Raises CacheError if a directory cannot be created or
    read.
    """
    try:
        taken = path.exists()
        if path.is_dir():
            taken = any(each.name != _UNFINISHED for each in path.iterdir())
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CacheError(f"{path}: cannot be written: {error.strerror or error}") from error
    if taken and not overwrite:
        raise InvalidInput(
            f"{path}: exists already; give another path, or overwrite it with --overwrite"
            " (overwrite=True)"
        )


def has_content(path: Path, content: bytes) -> bool:
    """Returns whether a file exists, can be read and has this content."""
    try:
        return path.read_bytes() == content
    except OSError:
        return False


@contextmanager
def unfinished(path: Path, *, size: int) -> Iterator[Path]:
    """Yields the path of a temporary file, which is to be written in the `with` block.

    When the block ends, this file replaces `path`. If the block raises an error, the temporary file
    is removed, and an OSError becomes a CacheError.

    size : free space [bytes] that is required before the block begins
    """
    with replacement(path) as partial:
        with partial.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, size)
        partial.unlink()
        yield partial


@contextmanager
def unfinished_directory(directory: Path) -> Iterator[Path]:
    """Yields the path of a new directory, whose files are to be written in the `with` block.

    When the block ends, the files move to `directory`. The new directory lies in `directory`, so
    `directory` may be a mount point. If the block raises an error, the new directory is removed, as
    is `directory` if it is empty and did not exist before. An OSError then becomes a CacheError.
    """
    partial = directory / _UNFINISHED
    new = not directory.exists()
    try:
        with written(directory):
            shutil.rmtree(partial, ignore_errors=True)
            partial.mkdir(parents=True)
            yield partial
            for path in sorted(partial.iterdir()):
                path.replace(directory / path.name)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        if new:
            with suppress(OSError):  # it holds the files of a complete export
                directory.rmdir()


def remove_sequences(directory: Path, names: list[str], suffixes: list[str]) -> None:
    """Removes the files of an earlier export from `directory`. Their names consist of one of
    `names` and one of `suffixes`, possibly with a number between them: "dress.obj" and
    "dress-00012.obj" for "dress" and ".obj".
    """
    wanted = re.compile(
        rf"({'|'.join(map(re.escape, names))})(-\d+)?({'|'.join(map(re.escape, suffixes))})"
    )
    for path in directory.iterdir() if directory.is_dir() else ():
        if wanted.fullmatch(path.name):
            path.unlink()
