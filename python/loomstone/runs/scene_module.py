"""Executes scene files as modules."""

from __future__ import annotations

import ast
import difflib
import os
import re
import sys
import threading
import types
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..base.cautions import SceneWarning

__all__ = ["absolute_files", "execute_module", "in_directory_of"]

# All threads of a process share its working directory, so only one at a time may change it.
_directory = threading.RLock()

# The global names of a scene file that loomstone reads.
KNOWN = ("scene", "duration", "rate", "integrator", "render", "control", "check")


# Global names that have no effect, and what should be given instead.
ELSEWHERE = {
    "step": "integrator = ls.SemiImplicitEuler(step=...)",
    "camera": "render = ls.RenderOptions(camera=...)",
    "fps": "rate",
    "frame_rate": "rate",
}


def execute_module(path: Path, source: str) -> types.ModuleType:
    """Executes a scene file as a module that is registered in sys.modules, and returns it.

    The directory of the file is put first in sys.path, so that the file can import modules from
    it. Warns with SceneWarning of globals that have no effect but resemble options.
    """
    directory = str(path.parent)
    with suppress(ValueError):
        sys.path.remove(directory)
    sys.path.insert(0, directory)
    module = types.ModuleType("loomstone_scene_" + re.sub(r"\W", "_", path.stem))
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    try:
        code = compile(source, str(path), "exec")
        _warn_of_misspelt_globals(path, source)
        exec(code, module.__dict__)
    except BaseException:
        sys.modules.pop(module.__name__, None)
        raise
    return module


@contextmanager
def in_directory_of(path: Path) -> Iterator[None]:
    """Makes the directory of a scene file the working directory of the `with` block.

    If that is not possible, the working directory stays the same. Other threads that call this
    function wait until the block ends.
    """
    with _directory:
        try:
            before = os.getcwd()
            os.chdir(path.parent)
        except OSError:
            yield
            return
        try:
            yield
        finally:
            with suppress(OSError):
                os.chdir(before)


def absolute_files(parameters: dict[str, Any]) -> dict[str, Any]:
    """Returns the parameters, with absolute paths for names of existing files that have a suffix.

    A parameter such as mesh=figure.obj is relative to the working directory of the command, but
    scene() runs in the directory of its file.
    """

    def absolute(value: Any) -> Any:
        named = isinstance(value, str) and "\0" not in value and Path(value).suffix
        return os.path.abspath(value) if named and Path(value).is_file() else value

    return {name: absolute(value) for name, value in parameters.items()}


def _warn_of_misspelt_globals(path: Path, source: str) -> None:
    tree = ast.parse(source)
    names = _assigned(tree)
    read = {
        node.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
    }
    absent = [name for name in KNOWN if name not in names]
    for name, line in names.items():
        if name in KNOWN or name in read or name.startswith("_"):
            continue
        if name in ELSEWHERE:
            _warn(f"{path.name}, line {line}: {name!r} has no effect; give {ELSEWHERE[name]}")
            continue
        close = difflib.get_close_matches(name.lower(), absent, 1, 0.75)
        close = close or difflib.get_close_matches(name.lower(), KNOWN, 1, 0.92)
        if close:
            _warn(f"{path.name}, line {line}: {name!r} has no effect; did you mean {close[0]!r}?")


def _warn(sentence: str) -> None:
    warnings.warn(sentence, SceneWarning, stacklevel=3)


def _assigned(tree: ast.Module) -> dict[str, int]:
    """Returns the names and line numbers of a module's top-level functions and variables."""
    names: dict[str, int] = {}
    for node in tree.body:
        targets: list[ast.expr] = []
        if isinstance(node, ast.FunctionDef):
            names[node.name] = node.lineno
        elif isinstance(node, ast.Assign):
            targets = node.targets
        elif isinstance(node, ast.AnnAssign):
            targets = [node.target]
        for target in targets:
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            names |= {part.id: part.lineno for part in parts if isinstance(part, ast.Name)}
    return names
