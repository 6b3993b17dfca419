"""Conversion of quantities with units to plain numbers, for the whole package.

A quantity is recognised by its Pint attributes. Quantities of any Pint registry are therefore
accepted, and Pint is not imported here.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from .._core import InvalidInput

__all__ = ["in_unit", "is_angle", "number_in"]

_PLAIN = frozenset({float, int, bool, str, type(None), np.ndarray, np.float64, np.int64})
_DIMENSIONS = (
    *("1", "m", "kg", "s", "N", "N/m", "N m", "kg/m^2", "kg/m^3", "Pa", "m^2", "1/m", "N s/m"),
    *("m/s", "m/s^2", "1/s", "A", "T", "A m^2", "A/m", "V", "ohm", "H"),
)
_ANGLES = ("degree", "radian", "milliradian", "arcminute", "arcsecond", "turn", "grade")


def in_unit(value: Any, unit: str, where: str) -> Any:
    """Returns a quantity as a plain number or array in `unit`, and any other value unchanged.

    Lists and tuples may contain quantities. A quantity of another dimension raises an InvalidInput
    whose message begins with `where`.
    """
    if type(value) in _PLAIN:
        return value
    if isinstance(value, (list, tuple)):
        if not _carries_unit(value):
            return value
        plain = [in_unit(each, unit, where) for each in value]
        return tuple(plain) if isinstance(value, tuple) else plain
    if not hasattr(value, "dimensionality"):
        return value
    wanted = "dimensionless" if unit == "1" else unit
    try:
        return value.to(wanted).magnitude
    except Exception:  # Pint is not imported, so its exceptions cannot be named
        if any(power % 1 for power in value.dimensionality.values()):
            with suppress(Exception):  # gauss and oersted of another registry
                return value.to(wanted, "Gaussian").magnitude
        raise InvalidInput(
            f"{where} must be {_wanted(unit)}: {_shown(value)} has the dimension {_named(value)}"
        ) from None


def number_in(value: Any, unit: str, where: str) -> float:
    """Returns a number or quantity as a float in `unit`; raises InvalidInput for other values."""
    number = in_unit(value, unit, where)
    if isinstance(number, (str, bytes)) or np.ndim(number) != 0:
        raise InvalidInput(f"{where} must be a number, {_wanted(unit)}, got {value!r}")
    try:
        return float(number)
    except (TypeError, ValueError):
        raise InvalidInput(f"{where} must be a number, {_wanted(unit)}, got {value!r}") from None


def is_angle(value: Any) -> bool:
    """Returns whether a value carries a unit of angle."""
    units = getattr(value, "_units", None) if hasattr(value, "dimensionality") else None
    return units is not None and len(units) == 1 and next(iter(units)) in _ANGLES


def _carries_unit(values: list[Any] | tuple[Any, ...]) -> bool:
    return any(
        _carries_unit(each) if isinstance(each, (list, tuple)) else hasattr(each, "dimensionality")
        for each in values
        if type(each) not in _PLAIN
    )


def _wanted(unit: str) -> str:
    return "a pure number" if unit == "1" else f"in {unit}"


def _shown(value: Any) -> str:
    """Formats a quantity for messages, for instance as 5 gf/cm."""
    return f"{value:g~C}" if np.ndim(value.magnitude) == 0 else str(value)[:80]


def _named(value: Any) -> str:
    """Names the dimension of a quantity by a familiar unit such as N/m, or else as Pint does."""
    for name in _DIMENSIONS:
        if value.is_compatible_with(name if name != "1" else "dimensionless"):
            return name
    return str(value.dimensionality)
