"""Replacement of standard streams that are closed, as daemons and some launchers leave them."""

from __future__ import annotations

import os
import sys

__all__ = ["open_closed_streams"]


def open_closed_streams() -> None:
    """Opens the null device in place of closed standard streams.

    Otherwise the next opened file would get the descriptor of a closed stream, and what libraries
    print would go into this file.
    """
    for stream, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(stream)
        except OSError:
            _open_null(stream)
        if getattr(sys, name) is None:
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(stream, mode, encoding="utf-8", closefd=False))  # noqa: SIM115


def _open_null(stream: int) -> None:
    opened = os.open(os.devnull, os.O_RDWR)
    if opened == stream:
        os.set_inheritable(stream, True)
    else:
        os.dup2(opened, stream)
        os.close(opened)
