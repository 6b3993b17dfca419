"""Signals that end a run at a step from which it can be resumed, or that ask for a checkpoint."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["LONGEST_WAIT", "Abandoned", "Interrupted", "Received", "noted_signals"]

# Longest time for which a run continues after a signal, to reach a step that can be saved [s]. The
# value is our choice, less than the time from SIGTERM to SIGKILL in Slurm (30 s by default).
LONGEST_WAIT = 10.0


class Interrupted(KeyboardInterrupt):
    """Raised when a signal ends the run, which can then be resumed.

    It is not derived from Exception, so `except Exception` does not catch it.

    signal : number of the signal
    """

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.signal = number

    def __reduce__(self) -> tuple[type[Interrupted], tuple[int]]:
        return type(self), (self.signal,)  # by default, pickle would pass the signal's name


class Abandoned(KeyboardInterrupt):
    """Raised on a SIGINT after an earlier signal that ends the run.

    The run then ends at once, without a new checkpoint.
    """


class Received:
    """The number of the latest signal that ends the run (0: none), the time at which the first such
    signal arrived [s], and whether a checkpoint is due.
    """

    number, when, due = 0, 0.0, False

    def waited(self) -> float:
        """Returns the time since the first signal that ends the run [s], or 0 if there was none."""
        return time.monotonic() - self.when if self.number else 0.0


@contextmanager
def noted_signals() -> Iterator[Received]:
    """Records SIGINT, SIGTERM, SIGUSR1 and SIGCONT in the yielded object, for checks between steps.

    A SIGINT that follows a SIGINT, SIGTERM or SIGUSR1 ends the run at once. SIGCONT asks for a
    checkpoint, because mpirun sends it one second before SIGTERM and two seconds before SIGKILL.
    In a thread other than the main thread, no signal is recorded.
    """
    received = Received()

    def note(number: int, _: Any) -> None:
        if number == signal.SIGCONT:
            received.due = True
            return
        if received.number and number == signal.SIGINT:
            raise Abandoned
        if not received.number:
            received.when = time.monotonic()
        received.number = number

    try:
        before = {
            n: signal.signal(n, note)
            for n in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGCONT)
        }
    except ValueError:  # only the main thread can set handlers
        yield received
        return
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
