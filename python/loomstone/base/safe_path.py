"""Keeps processes of Python from importing what lies in the working directory.

With `-c` or `-m`, Python searches the working directory first, where a file such as random.py would
take the place of a module. Python 3.10 has no way to leave it out.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["python", "safe_path"]

_VARIABLE = "PYTHONSAFEPATH"
_lock = threading.Lock()  # one thread at a time changes the environment


def python() -> list[str]:
    """Returns the start of a command that runs Python without the working directory."""
    return [sys.executable, "-P"] if sys.version_info >= (3, 11) else [sys.executable]


@contextmanager
def safe_path() -> Iterator[None]:
    """Applies to the processes of Python that start in the `with` block. Other threads wait."""
    with _lock:
        before = os.environ.get(_VARIABLE)
        os.environ[_VARIABLE] = "1"
        try:
            yield
        finally:
            os.environ.pop(_VARIABLE)
            if before is not None:
                os.environ[_VARIABLE] = before
