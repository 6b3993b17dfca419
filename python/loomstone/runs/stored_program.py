"""The scene program that is stored in a run, and the rule that decides whether it may run.

A run contains the source of its scene file, so a run from a stranger contains that stranger's
program. This program runs only if it equals the scene file at the stored path, or if the user
trusts the run.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from .._core import CacheError

__all__ = ["Program", "Stored", "printable", "stored_program"]


class Stored(Protocol):
    """The parts of a Run from which its scene file can be restored."""

    @property
    def directory(self) -> Path: ...

    @property
    def metadata(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class Program:
    """The path, source and parameters of a scene file when a run began."""

    path: Path
    source: str
    parameters: dict[str, Any]

    def require_same_file(self, directory: Path) -> None:
        """Raises CacheError unless `path` is absolute and the file there has the content `source`.

        A file in the directory of the run does not count, because it may have come with the run.
        """
        if problem := self._difference(directory):
            raise CacheError(
                f"{directory}: its program is not run, because {problem}; read the program by"
                f" loomstone info --source {directory}, and give --trust (in Python trust=True) to"
                " run it"
            )

    def _difference(self, directory: Path) -> str | None:
        shown = printable(str(self.path))
        if not self.path.is_absolute():
            return f"the path of its scene file, {shown}, is not absolute"
        if self.path.resolve().is_relative_to(directory.resolve()):
            return f"the scene file {shown} lies in the directory of the run"
        try:
            if not self.path.is_file():
                return f"the scene file {shown} does not exist"
            same = self.path.read_text(encoding="utf-8") == self.source
        except (OSError, ValueError):
            return f"the scene file {shown} cannot be read"
        return None if same else f"the scene file {shown} differs from it"


def stored_program(run: Stored) -> Program:
    """Returns the program of a run. Raises CacheError if the run has none or a damaged one."""
    stored = run.metadata.get("scene_file")
    if not stored:
        raise CacheError(
            f"{run.directory}: was not written by `loomstone run`, so it does not contain its scene"
            " file; resume it in Python"
        )
    if isinstance(stored, dict):
        path, source, given = (stored.get(name) for name in ("path", "source", "parameters"))
        exact = _values(stored.get("literals", {}))
        named = given | exact if isinstance(given, dict) and exact is not None else None
        if isinstance(path, str) and isinstance(source, str) and named is not None:
            return Program(Path(path), source, named)
    raise CacheError(f"{run.directory}: the file is damaged: its scene file cannot be read")


def _values(literals: Any) -> dict[str, Any] | None:
    """Returns the values of stored Python literals by name; None if they are damaged."""
    try:
        return {name: ast.literal_eval(text) for name, text in literals.items()}
    except (AttributeError, TypeError, ValueError, SyntaxError, MemoryError, RecursionError):
        return None


def printable(text: str) -> str:
    """Returns a text with its unprintable characters escaped, except line feeds and tabs.

    Control characters could hide parts of the text on a terminal.
    """
    return "".join(
        letter if letter.isprintable() or letter in "\n\t" else ascii(letter)[1:-1]
        for letter in text
    )
