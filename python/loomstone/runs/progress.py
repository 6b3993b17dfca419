"""Progress of a run: a bar on a terminal without MPI, or else plain lines; only rank 0 prints."""

from __future__ import annotations

import os
import sys

from .observer import Observer, Silence
from .progress_lines import Lines

__all__ = ["observer"]


def observer(rank: int = 0) -> Observer:
    """Returns the observer that suits the rank, the standard output and the launcher."""
    if rank != 0:
        return Silence()
    # MPI launchers may provide a pseudo-terminal, which must not get a progress bar.
    launched = "OMPI_COMM_WORLD_SIZE" in os.environ or "PMI_SIZE" in os.environ
    if launched or not sys.stdout.isatty():
        return Lines()
    from .progress_bar import Bar  # a late import, because rich loads slowly

    return Bar()
