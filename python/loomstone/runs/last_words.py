"""A sentence that is printed when a run ends early, even by SIGKILL."""

from __future__ import annotations

import atexit
import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from .signals import Interrupted

__all__ = ["last_words"]

# The shell prints its argument unless it receives the word "end" through a pipe. If the process at
# the other end of the pipe dies, the system closes the pipe, and the shell prints.
_SHELL = (
    "trap '' HUP INT TERM USR1 USR2; read -r word; [ \"$word\" = end ] || printf '%s\\n' \"$0\" >&2"
)
# Error messages that contain this command already say how to continue, so nothing is printed after
# them.
RESUME = "loomstone resume"
# Time after SIGTERM at which the sentence is printed if the run has not ended [s]. mpirun kills
# a rank one second after SIGTERM and then forwards no more output.
_PATIENCE = 0.5


@contextmanager
def last_words(sentence: str) -> Iterator[None]:
    """Prints a sentence to standard error if this process ends before the `with` block does.

    It is also printed if the block outlasts a SIGTERM by half a second, or raises an error. An
    empty sentence is not printed. Nothing is printed after Interrupted, or after an error whose
    message says how to continue. After another error, the sentence is printed when Python exits.
    """
    speaker = _Speaker(sentence) if sentence else None
    try:
        yield
    except Interrupted:
        if speaker:
            speaker.end(silent=True)
        raise
    except BaseException as error:
        if speaker and RESUME in str(error):
            speaker.end(silent=True)
        elif speaker:
            atexit.register(speaker.end, silent=False)
        raise
    if speaker:
        speaker.end(silent=True)


class _Speaker:
    """The shell that prints the sentence, and a thread that makes it print after SIGTERM."""

    def __init__(self, sentence: str) -> None:
        self._shell: subprocess.Popen[bytes] | None = None
        with suppress(OSError):  # a container may have no shell
            # A shell in a separate session survives a signal to the process group of the run.
            self._shell = subprocess.Popen(
                ["/bin/sh", "-c", _SHELL, sentence],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
            )
        self._ended = threading.Event()
        self._signals, self._noted = os.pipe()
        os.set_blocking(self._noted, False)
        self._before: int | None = None
        with suppress(ValueError):  # only the main thread may call set_wakeup_fd()
            self._before = signal.set_wakeup_fd(self._noted, warn_on_full_buffer=False)
        # The main thread may wait for a dead rank and never handle signals. Python writes the
        # number of each signal to the pipe given to set_wakeup_fd(), and another thread reads it.
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while number := os.read(self._signals, 1):
            if number[0] == signal.SIGTERM and not self._ended.wait(_PATIENCE):
                self._tell(b"speak\n")
        os.close(self._signals)

    def _tell(self, word: bytes) -> None:
        if self._shell:
            with suppress(OSError, ValueError):
                self._shell.communicate(word)

    def end(self, *, silent: bool) -> None:
        if self._before is not None:
            signal.set_wakeup_fd(self._before)
        self._ended.set()
        os.close(self._noted)
        self._tell(b"end\n" if silent else b"speak\n")
