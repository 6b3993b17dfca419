"""Output of a command: all text, only warnings and errors (--quiet), or a JSON object (--json)."""

from __future__ import annotations

import json
import sys
from contextlib import ExitStack, redirect_stdout
from typing import Any

from ..runs.observer import Observer, Silence
from ..runs.progress import observer
from .application import WrongCommand

__all__ = ["Words"]


class Words:
    """Prints the output of a command on rank 0, and nothing on other ranks.

    With `as_json`, text that other code, such as a scene file, prints inside the `with` block of
    this object goes to standard error.

    quiet : print no text except by insist()
    as_json : print no text except by insist(), but print the objects passed to json()
    """

    def __init__(self, rank: int = 0, *, quiet: bool = False, as_json: bool = False) -> None:
        if quiet and as_json:
            raise WrongCommand("--quiet and --json must not be given together; give one of them")
        self._rank, self._text, self._as_json = rank, not (quiet or as_json), as_json
        self._out = sys.stdout
        self._block = ExitStack()

    def __enter__(self) -> Words:
        if self._as_json:
            self._block.enter_context(redirect_stdout(sys.stderr))
        return self

    def __exit__(self, *_: object) -> None:
        self._block.close()

    def say(self, line: str) -> None:
        """Prints a line of text."""
        if self._rank == 0 and self._text:
            print(line, flush=True)

    def insist(self, line: str) -> None:
        """Prints a line in every mode; to standard error if other text is off."""
        if self._rank == 0:
            print(line, file=sys.stdout if self._text else sys.stderr, flush=True)

    def json(self, content: dict[str, Any]) -> None:
        """Prints a JSON object if the user has asked for JSON."""
        if self._rank == 0 and self._as_json:
            print(json.dumps(content, indent=1, default=str), file=self._out, flush=True)

    def observer(self) -> Observer:
        """Returns an observer of a run. It shows the progress on rank 0, unless text is off."""
        return observer(self._rank) if self._text else Silence()
