"""While modules load, lets Ctrl-C end the command `loomstone` with a message and exit code 130.

Modules are loaded before the command can catch a KeyboardInterrupt. Other programs that import
loomstone are not affected.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from typing import Any, NoReturn

__all__ = ["leave_interrupts_to_python"]


def _end(*_: Any) -> NoReturn:
    os.write(2, b"loomstone: interrupted\n")
    os._exit(128 + signal.SIGINT)


def _is_command(words: list[str]) -> bool:
    """Returns whether the interpreter runs the script `loomstone` or `-m loomstone`.

    words : arguments of the interpreter
    """
    if sys.argv[:1] == ["-m"]:
        return "-m" in words and words[words.index("-m") + 1 :][:1] == ["loomstone"]
    return sys.argv[0] in words and os.path.basename(sys.argv[0]) == "loomstone"


def leave_interrupts_to_python() -> None:
    """Lets Ctrl-C raise KeyboardInterrupt again, if this module has replaced the handler."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


# An ignored signal stays ignored, as in background jobs of a shell.
if (
    threading.current_thread() is threading.main_thread()
    and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    and _is_command(sys.orig_argv)
):
    signal.signal(signal.SIGINT, _end)
