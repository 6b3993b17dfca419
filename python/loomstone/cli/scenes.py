"""The command loomstone scenes."""

from __future__ import annotations

import ast
import difflib
import shlex
from pathlib import Path
from typing import Annotated

import typer

from .._core import CacheError, InvalidInput
from .application import app, session
from .new import write_new_file

__all__ = ["scene_files"]


def scene_files() -> dict[str, Path]:
    """Returns the scene files of this project by name, from the package or the source tree."""
    package = Path(__file__).parents[1]
    for directory in (package / "scenes", package.parents[1] / "scenes"):
        if found := {path.stem: path for path in sorted(directory.glob("*.py"))}:
            return found
    raise CacheError(f"{package / 'scenes'}: has no scene files; install loomstone again")


def _names(incomplete: str) -> list[str]:
    return [name for name in scene_files() if name.startswith(incomplete)]


@app.command()
def scenes(
    name: Annotated[
        str, typer.Argument(help="scene to copy; without it, lists all", autocompletion=_names)
    ] = "",
    out: Annotated[
        Path | None, typer.Option(help="file to write; default: NAME.py in this directory")
    ] = None,
) -> None:
    """Lists the scenes that come with loomstone, or copies one.

    \b
        loomstone scenes
        loomstone scenes drape --out mine.py
    """
    with session(parallel=False):
        known = scene_files()
        if not name:
            width = max(map(len, known))
            for each, path in known.items():
                print(f"{each:{width}}  {_first_line(path)}")
            return
        if name not in known:
            close = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {close[0]}?" if close else "loomstone scenes lists all"
            raise InvalidInput(f"there is no scene {name!r}; {hint}")
        target = out or Path(f"{name}.py")
        write_new_file(target, known[name].read_text())
        print(f"scene: {target}\nrun it: loomstone run {shlex.quote(str(target))}")


def _first_line(path: Path) -> str:
    """Returns the first sentence of the description of a scene file, without its full stop."""
    text = " ".join((ast.get_docstring(ast.parse(path.read_text())) or "").split())
    return text.partition(". ")[0].rstrip(".")
