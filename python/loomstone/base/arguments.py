"""Arguments of public functions: one sentence where they have the wrong kind."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput

__all__ = ["explained", "vector", "whole"]

P = ParamSpec("P")
R = TypeVar("R")


def vector(name: str, value: Any, size: int) -> NDArray[np.float64]:
    """`size` finite numbers."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} must be {size} numbers, got {value!r}") from None
    if array.shape != (size,) or not np.isfinite(array).all():
        raise InvalidInput(f"{name} must be {size} finite numbers, got {value}")
    return array


def whole(name: str, value: Any, low: int, high: int) -> int:
    """A whole number within limits."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float, np.integer, np.floating))
        or value != np.floor(value)
    ):
        raise InvalidInput(f"{name} must be a whole number, got {value!r}")
    if not low <= value <= high:
        raise InvalidInput(f"{name} must be in [{low}, {high}], got {value}")
    return int(value)


def explained(function: Callable[P, R]) -> Callable[P, R]:
    """Tells which argument of a function has the wrong kind, where the core only lists what it
    could take.
    """

    @functools.wraps(function)
    def call(*arguments: P.args, **keywords: P.kwargs) -> R:
        try:
            return function(*arguments, **keywords)
        except TypeError as error:
            if "incompatible function arguments" not in str(error):
                raise
            given = inspect.signature(function).bind(*arguments, **keywords).arguments
            text = ", ".join(f"{name}={value!r}" for name, value in given.items())
            raise TypeError(
                f"{function.__name__}: an argument has the wrong kind, got {text}"[:400]
            ) from None

    return call
