"""Files that are written under another name and replace earlier ones when they are complete."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .._core import CacheError

__all__ = ["replacement", "written"]


@contextmanager
def replacement(path: Path, what: str = "") -> Iterator[Path]:
    """Yields the path at which to write a file. Once complete, this file replaces `path`.

    If writing fails, the unfinished file is removed, and an OSError becomes a CacheError.

    what : what is written, for the message, such as "the plot"
    """
    target = path.resolve()  # a link to a file stays
    unfinished = target.with_name(f"unfinished-{target.name}")
    try:
        with written(path, what):
            yield unfinished
            unfinished.replace(target)
    except BaseException:
        with suppress(OSError):  # the error that ended writing is reported
            unfinished.unlink(missing_ok=True)
        raise


@contextmanager
def written(path: Path, what: str = "") -> Iterator[None]:
    """Turns an OSError of the `with` block into a CacheError with one sentence about `path`.

    what : as in replacement()
    """
    try:
        yield
    except CacheError:
        raise
    except OSError as error:
        raise CacheError(
            f"{path}:{f' {what}' if what else ''} cannot be written: {error.strerror or error};"
            " check the path and the space on the disk"
        ) from error
