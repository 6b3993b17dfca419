"""Processes launched by MPI that share the work of a simulation.

If one rank fails in a collective function, all ranks raise an error with the same message.
"""

from __future__ import annotations

import json
import os
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
    available_processors,
    launched_by_mpi,
    mpi_communicator,
    single_communicator,
    threads_in_environment,
)
from .base.claims import broken_claim

__all__ = ["Communicator", "launched_by_mpi", "mpi_communicator", "single_communicator"]


def __dir__() -> list[str]:
    return __all__


# Error types, indexed by their numbers in core/parallel/agreement.cpp; None means no failure. The
# last number is that of StepFailure, which is a SolverFailure in Python.
_KINDS = (
    None,
    Error,
    InvalidInput,
    SolverFailure,
    CacheError,
    Unsupported,
    SolverFailure,
)


def launched_rank() -> int:
    """Returns the rank in the environment variables of the launcher, or 0 without them.

    Unlike Communicator.rank, it is known before MPI starts.
    """
    names = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID")
    return next((_count(name) for name in names if name in os.environ), 0)


# Open MPI sets this variable to "none" if it was told not to bind ranks to processors (mpirun
# --bind-to none).
_BINDING = "OMPI_MCA_hwloc_base_binding_policy"


def default_threads() -> int:
    """Returns the number of threads that this rank should use.

    This is the number in the environment variable OMP_NUM_THREADS or, without it, the number that
    processors_of_rank() returns.
    """
    return threads_in_environment() or processors_of_rank()


def processors_of_rank() -> int:
    """Returns the number of processors in the share of this rank.

    Ranks on the same node share its processors equally. If Slurm sets a number of processors per
    rank in a job step, this number is the share instead. In both cases, the share is at most the
    number of processors on which this rank may run, for example those to which Open MPI binds it.
    """
    usable = available_processors()
    if "SLURM_STEP_ID" in os.environ and (given := _count("SLURM_CPUS_PER_TASK")):
        return min(usable, given)
    # Open MPI sets the first variable; MPICH and Intel MPI set the second.
    neighbours = _count("OMPI_COMM_WORLD_LOCAL_SIZE") or _count("MPI_LOCALNRANKS") or 1
    bound = "OMPI_COMM_WORLD_SIZE" in os.environ and os.environ.get(_BINDING) != "none"
    shared = (os.cpu_count() or usable) if bound else usable
    return min(usable, max(1, shared // neighbours))


def _count(variable: str) -> int:
    """Returns the whole number in an environment variable, or 0 if it contains none."""
    text = os.environ.get(variable, "")
    return int(text) if text.isdecimal() else 0


@contextmanager
def together(ranks: Communicator) -> Iterator[None]:
    """Runs the `with` block, and raises the error of the lowest failing rank on all ranks.

    All ranks must take part.
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


def check_same(ranks: Communicator, call: str, **given: object) -> None:
    """Raises InvalidInput on all ranks unless all ranks give the same arguments to a function.

    All ranks must call this function. If a rank calls share_failure() instead, its error is raised.
    Arguments count as equal if their reprs are equal.

    call : name of the function, for the message
    given : the arguments by name
    """
    if ranks.size == 1:
        return
    with together(ranks):  # a rank that has failed would not take part in gather()
        text = json.dumps({name: repr(value) for name, value in given.items()})
    first, *others = map(json.loads, ranks.gather(text))
    with together(ranks):
        for rank, other in enumerate(others, 1):
            for name in (name for name in first if other[name] != first[name]):
                raise InvalidInput(
                    f"{call}: {name} must be the same on all ranks, got {first[name]} on rank 0 and"
                    f" {other[name]} on rank {rank}"
                )


def share_failure(ranks: Communicator, failure: Exception) -> None:
    """Reports a failure to the other ranks, unless all ranks have agreed on it already.

    If the other ranks do not respond within ten seconds, all ranks are terminated.
    """
    if ranks.size > 1 and ranks.agreed != str(failure):
        ranks.agree(*_described(failure))


def end_all_on_failure(ranks: Communicator) -> None:
    """Makes an uncaught error on one rank end all ranks, since the others would wait for ever."""
    # An exception hook that the user or another package has set takes precedence.
    if ranks.size == 1 or sys.excepthook is not sys.__excepthook__:
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
    if isinstance(failure, AssertionError):
        return 1, broken_claim(failure)
    for kind, known in reversed(list(enumerate(_KINDS))):
        if known and isinstance(failure, known):
            return kind, str(failure)
    return (4 if isinstance(failure, OSError) else 1), str(failure) or type(failure).__name__
