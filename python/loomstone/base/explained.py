"""Errors in one sentence for calls that the C++ core rejects.

pybind11 reports a wrong number or type of arguments in several lines, with all signatures. This
module wraps the functions and methods of the core, so that they raise WrongArguments instead. It
must be imported before modules that import functions of the core.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from typing import Any

from .. import _core

__all__ = ["MESH_HINT", "WrongArguments"]

MESH_HINT = (
    "create one with TriangleMesh(vertices, triangles), or read a file with"
    " loomstone.meshes.read(path)"
)

_SHORT = (
    ("loomstone._core.", ""),
    ("typing.SupportsFloat | typing.SupportsIndex", "float"),
    ("typing.SupportsInt | typing.SupportsIndex", "int"),
    ("typing.", ""),
    ("collections.abc.", ""),
)
_REJECTED = re.compile(r"(\w+)\(\): incompatible (constructor|function) arguments")


class WrongArguments(TypeError):
    """Raised if a function of the core is called with a wrong number or type of arguments."""


def _sentence(text: str) -> str:
    """Turns the message of pybind11, which has several lines, into one sentence."""
    found = _REJECTED.match(text)
    assert found is not None
    name, constructor = found[1], found[2] == "constructor"
    wanted = re.findall(r"^ +\d+\. (.*)$", text, re.M)[-1]
    for long, short in _SHORT:
        wanted = wanted.replace(long, short)
    method = wanted.startswith("(self: ")
    wanted = re.sub(r"^\(self: \w+(, )?", "(", wanted)
    given = " ".join(text.partition("Invoked with: ")[2].split())
    given, _, keywords = given.partition("; kwargs: ")
    if method:
        given = _without_first(given)
    given = ", ".join(part for part in (given[:200], keywords[:200]) if part)
    if constructor:
        name = wanted.partition("(")[0]
        wanted = wanted[len(name) :]
    lacks_mesh = ": TriangleMesh" in wanted and "TriangleMesh(" not in given
    hint = f"; a TriangleMesh is missing: {MESH_HINT}" if lacks_mesh else ""
    return f"{name}({given}) has wrong arguments; expected {name}{wanted}{hint}"


def _without_first(given: str) -> str:
    """Removes the first argument from `given`, the arguments of a call as text.

    Commas in brackets do not separate arguments.
    """
    depth = 0
    for place, letter in enumerate(given):
        depth += (letter in "([{<") - (letter in ")]}>")
        if letter == "," and depth == 0:
            return given[place + 2 :]
    return ""


def _explained(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def call(*given: Any, **keywords: Any) -> Any:
        try:
            return function(*given, **keywords)
        except TypeError as error:
            if not _REJECTED.match(str(error)):
                raise
            raise WrongArguments(_sentence(str(error))) from None

    return call


def _explain(owner: Any) -> None:
    """Wraps the public functions, methods and constructors of the core or of one of its classes."""
    for name, value in list(vars(owner).items()):
        if isinstance(value, type):
            if owner is _core:
                _explain(value)
        elif isinstance(value, staticmethod):
            setattr(owner, name, staticmethod(_explained(value.__func__)))
        elif callable(value) and (not name.startswith("_") or _is_constructor(owner, name)):
            setattr(owner, name, _explained(value))


def _is_constructor(owner: Any, name: str) -> bool:
    """Returns whether an attribute is the constructor of a class without field_names.

    Constructors of classes with field_names, such as Cloth, explain errors themselves.
    """
    return name == "__init__" and isinstance(owner, type) and not hasattr(owner, "field_names")


_explain(_core)
