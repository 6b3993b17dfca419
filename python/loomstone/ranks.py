"""Processes that share the work of a simulation, launched by MPI.

One rank's failure becomes the same error on all ranks.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ._core import (
    CacheError,
    Communicator,
    Error,
    InvalidInput,
    SolverFailure,
    Unsupported,
    launched_by_mpi,
    mpi_communicator,
    single_communicator,
)

__all__ = ["Communicator", "launched_by_mpi", "mpi_communicator", "single_communicator"]


def __dir__() -> list[str]:
    return __all__


_KINDS = (
    None,
    Error,
    InvalidInput,
    SolverFailure,
    CacheError,
    Unsupported,
)  # numbered as in core/parallel/agreement.cpp


@contextmanager
def together(ranks: Communicator) -> Iterator[None]:
    """What is inside succeeds on all ranks, or the error of the lowest rank that failed is raised
    on all. Collective.
    """
    if ranks.size == 1:
        yield
        return
    failure: Exception | None = None
    try:
        yield
    except Exception as error:
        failure = error
    kind, text = ranks.agree(*_described(failure))
    if failure and text == str(failure):
        raise failure
    if raised := _KINDS[kind]:
        raise raised(text)


def share_failure(ranks: Communicator, failure: Exception) -> None:
    """Tells the others of a failure they may not have met; where they do not listen, ends them."""
    if ranks.size > 1 and ranks.agreed != str(failure):
        ranks.agree(*_described(failure))


def end_all_on_failure(ranks: Communicator) -> None:
    """An error that nobody catches ends all ranks: the others would wait for ever for the one that
    left.
    """
    if ranks.size == 1 or sys.excepthook is not sys.__excepthook__:  # whoever set a hook decides
        return

    def hook(*failure: Any) -> None:
        sys.__excepthook__(*failure)
        sys.stdout.flush()
        sys.stderr.flush()
        ranks.abort(1)

    sys.excepthook = hook


def _described(failure: Exception | None) -> tuple[int, str]:
    if failure is None:
        return 0, ""
    for kind, known in reversed(list(enumerate(_KINDS))):
        if known and isinstance(failure, known):
            return kind, str(failure)
    return (4 if isinstance(failure, OSError) else 1), str(failure) or type(failure).__name__
