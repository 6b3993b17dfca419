"""Signals that end a run where it can be resumed."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["LONGEST_WAIT", "Interrupted", "Received", "noted_signals"]

# [s] that a run goes on after a signal to reach a step that can be saved; our choice, below usual
# grace periods
LONGEST_WAIT = 10.0


class Interrupted(Exception):
    """A signal ended the run; it can be resumed."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.signal = number


class Received:
    """The first signal, 0 where there is none, and when it came [s]."""

    number, when = 0, 0.0

    def waited(self) -> float:
        """Seconds since the signal."""
        return time.monotonic() - self.when if self.number else 0.0


@contextmanager
def noted_signals() -> Iterator[Received]:
    """Notes SIGINT, SIGTERM and SIGUSR1; the run looks at the note between two steps.

    A second SIGINT ends at once.
    """
    received = Received()

    def note(number: int, _: Any) -> None:
        if received.number and number == signal.SIGINT:
            raise KeyboardInterrupt
        if not received.number:
            received.when = time.monotonic()
        received.number = number

    try:
        before = {
            n: signal.signal(n, note) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
        }
    except ValueError:  # not the main thread: whoever owns it handles signals
        yield received
        return
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
