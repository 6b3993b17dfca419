"""A lock on a directory, so that only one process at a time writes the run in it.

The lock is that of flock(2) on a hidden file. The system releases it when the process ends, even by
SIGKILL; the file may then remain, without effect. On file systems without locks, nothing prevents
two processes from writing the same run.
"""

from __future__ import annotations

import fcntl
import os
import platform
from contextlib import suppress
from pathlib import Path

from .._core import CacheError

__all__ = ["DirectoryLock", "check_unlocked"]

_NAME = ".lock"  # hidden, so that a directory with this file alone counts as empty


class DirectoryLock:
    """A lock on a directory. take() takes it, and the end of a `with` block releases it.

    Processes that are forked from this one do not hold the lock.

    name : name of the lock file, which exists while the lock is held. Locks with different names
        are independent.
    """

    def __init__(self, directory: Path, name: str = _NAME) -> None:
        self.directory, self._file = directory, directory / name
        self._descriptor: int | None = None

    def __enter__(self) -> DirectoryLock:
        return self

    def __exit__(self, *_: object) -> None:
        if self._descriptor is None:
            return
        with suppress(OSError):
            if self._is_current(self._descriptor):
                self._file.unlink()
        self._close()

    @property
    def descriptors(self) -> list[int]:
        """File descriptors that a started process must inherit to hold the lock as well."""
        return [] if self._descriptor is None else [self._descriptor]

    def take(self, *, wait: bool = False) -> None:
        """Takes the lock. Does nothing if this object has it already.

        If another process has the lock, raises CacheError or, with `wait`, waits until it is free.
        Takes no lock if the lock file cannot be created, or if its file system has no locks.
        """
        while self._descriptor is None:
            try:
                descriptor = os.open(self._file, os.O_RDWR | os.O_CREAT, 0o666)
            except OSError:  # absent or read-only directory; the writer of files reports this
                return
            try:
                locked = _lock(descriptor, fcntl.LOCK_EX, self.directory, wait=wait)
            except BaseException:
                os.close(descriptor)
                raise
            if not locked:
                self._file.unlink(missing_ok=True)
                os.close(descriptor)
                return
            # The process that had the lock may have removed the file after it was opened here.
            if not self._is_current(descriptor):
                os.close(descriptor)
                continue
            self._descriptor = descriptor
            _held.add(self)
            with suppress(OSError):  # a full disk; error messages then do not name this process
                os.ftruncate(descriptor, 0)
                os.pwrite(
                    descriptor, f"process {os.getpid()} on host {platform.node()}".encode(), 0
                )

    def _is_current(self, descriptor: int) -> bool:
        """Returns whether the open file is still the one at the path of the lock."""
        try:
            return os.path.samestat(os.fstat(descriptor), self._file.stat())
        except OSError:
            return False

    def _close(self) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)
        self._descriptor = None
        _held.discard(self)


def check_unlocked(directory: Path) -> None:
    """Raises CacheError if a process is writing the run in a directory. Writes nothing."""
    try:
        descriptor = os.open(directory / _NAME, os.O_RDONLY)
    except OSError:
        return
    try:
        _lock(descriptor, fcntl.LOCK_SH, directory, wait=False)
    finally:
        os.close(descriptor)


def _lock(descriptor: int, kind: int, directory: Path, *, wait: bool) -> bool:
    """Locks an open file; returns False if the file system has no locks.

    If another process has the lock, waits if `wait` is True, or else raises a CacheError that names
    the process.
    """
    try:
        fcntl.flock(descriptor, kind if wait else kind | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        owner = os.pread(descriptor, 1000, 0).decode(errors="replace") or "another process"
        raise CacheError(
            f"{directory} must be written by one process at a time, but {owner} is writing it; wait"
            " until that ends, or give another directory"
        ) from None
    except OSError:
        return False
    return True


_held: set[DirectoryLock] = set()


def _let_go() -> None:
    """Closes the lock files in a forked process, so that this process does not hold the locks."""
    for lock in list(_held):
        lock._close()


os.register_at_fork(after_in_child=_let_go)
