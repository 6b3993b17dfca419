"""Checks and converts the arguments of public functions, and raises readable errors."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput, TriangleMesh
from .explained import MESH_HINT, WrongArguments
from .foreign_meshes import converted
from .quantities import in_unit

__all__ = ["takes", "vector", "whole"]

P = ParamSpec("P")
R = TypeVar("R")


def vector(name: str, value: Any, size: int) -> NDArray[np.float64]:
    """Returns `value` as an array; raises InvalidInput unless it holds `size` finite numbers."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} must be {size} numbers, got {value!r}") from None
    if array.shape != (size,) or not np.isfinite(array).all():
        raise InvalidInput(f"{name} must be {size} finite numbers, got {value}")
    return array


def whole(name: str, value: Any, low: int, high: int) -> int:
    """Returns `value` as an int; raises InvalidInput unless it is a whole number in [low, high]."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float, np.integer, np.floating))
        or value != np.floor(value)
    ):
        raise InvalidInput(f"{name} must be a whole number, got {value!r}")
    if not low <= value <= high:
        raise InvalidInput(f"{name} must be in [{low}, {high}], got {value}")
    return int(value)


def takes(**units: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorates a public function or dataclass so that its arguments may carry units.

    units : unit of each parameter that accepts quantities, as parameter=unit; "1" for pure numbers.
        Quantities are converted to this unit. Quantities of another dimension raise InvalidInput.

    Arguments annotated as TriangleMesh may also be meshes of trimesh or meshio.

    A misspelt keyword raises a TypeError that suggests the right one or lists all keywords. More
    positional arguments than the function takes raise a TypeError that names keywords. If the C++
    core rejects the type of an argument, a TypeError shows the given arguments and the expected
    types.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        if isinstance(function, type):
            function.__init__ = _checked(function.__init__, function.__name__, units)  # type: ignore[misc]
            return function
        return _checked(function, getattr(function, "__name__", "?"), units)

    return decorate


def _checked(function: Callable[P, R], name: str, units: dict[str, str]) -> Callable[P, R]:
    parameters = inspect.signature(function).parameters
    order = list(parameters)
    named = [key for key in order if key != "self"]
    kinds = [parameter.kind for parameter in parameters.values()]
    any_place = inspect.Parameter.VAR_POSITIONAL in kinds
    places_for = sum(kind <= inspect.Parameter.POSITIONAL_OR_KEYWORD for kind in kinds)
    assert units.keys() <= parameters.keys(), f"{name} has no {units.keys() - parameters.keys()}"
    meshes = {
        key: _only_mesh(parameters[key].annotation)
        for key in order
        if "TriangleMesh" in str(parameters[key].annotation)
    }

    @functools.wraps(function)
    def call(*given: Any, **keywords: Any) -> R:
        for key in keywords:
            if key not in parameters:
                raise TypeError(f"{name}() has no argument {key!r}; {_hint(key, named)}")
        if len(given) > places_for and not any_place:
            raise TypeError(_too_many(name, given, order, places_for))
        for key in units.keys() & keywords.keys():
            keywords[key] = in_unit(keywords[key], units[key], f"{name}: {key}")
        for key in meshes.keys() & keywords.keys():
            keywords[key] = _mesh(keywords[key], f"{name}: {key}", meshes[key])
        places = zip(order, given, strict=False)
        plain = [
            in_unit(value, units[key], f"{name}: {key}")
            if key in units
            else (_mesh(value, f"{name}: {key}", meshes[key]) if key in meshes else value)
            for key, value in places
        ]
        try:
            return function(*plain, *given[len(plain) :], **keywords)
        except WrongArguments:
            bound = inspect.signature(function).bind(*given, **keywords).arguments
            text = ", ".join(f"{key}={value!r}" for key, value in bound.items())
            wanted = ", ".join(
                f"{key}: {parameter.annotation}"
                for key, parameter in parameters.items()
                if key in bound and parameter.annotation is not parameter.empty
            )
            raise TypeError(
                f"{name}: an argument has the wrong type, got {text[:300]}; expected {wanted}"
            ) from None

    call.units = units  # type: ignore[attr-defined]
    return call


def _too_many(name: str, given: tuple[Any, ...], order: list[str], places: int) -> str:
    """Returns the message for a call with more positional arguments than the function takes.

    order : all parameters; the first `places` of them may be given by position
    """
    shown = repr(given[places])[:200]
    first = [key for key in order[:places] if key != "self"]
    if not first:
        keyword = f"as in {name}({order[places]}=...), " if order[places:] else ""
        return f"{name}() takes keyword arguments only, {keyword}got {shown} without one"
    return (
        f"{name}() takes no argument without a keyword except {', '.join(first)}, got {shown};"
        f" known: {', '.join(key for key in order if key != 'self')}"
    )


def _only_mesh(annotation: Any) -> bool:
    """Returns whether a parameter takes only meshes, or only meshes and None."""
    return str(annotation) in ("TriangleMesh", "TriangleMesh | None")


def _mesh(value: Any, where: str, only: bool) -> Any:
    """Converts a mesh of another package; returns a TriangleMesh or None unchanged.

    Other objects raise a TypeError if `only` is true, and are returned unchanged otherwise.
    """
    if value is None or isinstance(value, TriangleMesh):
        return value
    mesh = converted(value)
    if mesh is None and only:
        raise TypeError(
            f"{where} must be a TriangleMesh, got the {type(value).__name__}"
            f" {repr(value)[:200]}; {MESH_HINT}"
        )
    return value if mesh is None else mesh


def _hint(key: str, known: list[str]) -> str:
    close = difflib.get_close_matches(key, known, 1)
    return f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
