"""Units of textile practice, with their dimensions.

>>> import loomstone as ls
>>> weight = 5.5 * ls.units["oz/yd^2"]
>>> round(weight.to("g/m^2"), 1)
186.5
>>> ls.ClothMaterial(density=weight).density == weight.to("kg/m^2")
True

Every number of a description may be given with a unit, ours or one of Pint where that is installed;
it is converted to the unit of its field, and a wrong dimension is refused. Plain numbers are SI.
Angles count as pure numbers (1 rad = 1), so gf/(cm deg) is N/m per rad: 56.19 N/m. gf is
gram-force, oz and lb are masses (avoirdupois), % is 0.01.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ._core import InvalidInput

__all__ = ["Quantity", "in_unit", "is_angle", "number_in", "units"]

Dimension = tuple[int, int, int]  # exponents of kg, m, s

_G = 9.80665  # standard gravity [m/s^2], exact
_INCH, _POUND = 0.0254, 0.45359237  # exact

_MASS, _LENGTH, _TIME, _PURE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
_FORCE, _PRESSURE, _ENERGY = (1, 1, -2), (1, -1, -2), (1, 2, -2)

_TABLE: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, _LENGTH),
    "cm": (1e-2, _LENGTH),
    "mm": (1e-3, _LENGTH),
    "um": (1e-6, _LENGTH),
    "km": (1e3, _LENGTH),
    "in": (_INCH, _LENGTH),
    "ft": (12 * _INCH, _LENGTH),
    "yd": (36 * _INCH, _LENGTH),
    "kg": (1.0, _MASS),
    "g": (1e-3, _MASS),
    "mg": (1e-6, _MASS),
    "oz": (_POUND / 16, _MASS),
    "lb": (_POUND, _MASS),
    "s": (1.0, _TIME),
    "ms": (1e-3, _TIME),
    "min": (60.0, _TIME),
    "N": (1.0, _FORCE),
    "mN": (1e-3, _FORCE),
    "uN": (1e-6, _FORCE),
    "cN": (1e-2, _FORCE),
    "kN": (1e3, _FORCE),
    "gf": (1e-3 * _G, _FORCE),
    "kgf": (_G, _FORCE),
    "lbf": (_POUND * _G, _FORCE),
    "dyn": (1e-5, _FORCE),
    "Pa": (1.0, _PRESSURE),
    "kPa": (1e3, _PRESSURE),
    "MPa": (1e6, _PRESSURE),
    "GPa": (1e9, _PRESSURE),
    "J": (1.0, _ENERGY),
    "gsm": (1e-3, (1, -2, 0)),
    "tex": (1e-6, (1, -1, 0)),
    "den": (1e-3 / 9000, (1, -1, 0)),
    "rad": (1.0, _PURE),
    "deg": (math.pi / 180, _PURE),
    "degrees": (math.pi / 180, _PURE),
    "°": (math.pi / 180, _PURE),
    "%": (1e-2, _PURE),
    "1": (1.0, _PURE),
}


class Quantity:
    """A number, or an array of numbers, and its unit. Made by multiplying with units: 200 *
    ls.units["gf/cm"].

    value : number or array; unit : text such as "gf cm^2/cm"; `si` is the value in SI.
    """

    __slots__ = ("_dimension", "_factor", "_unit", "_value")
    __array_ufunc__ = None  # array * unit is a Quantity, and not an array of quantities

    def __init__(self, value: Any, unit: str) -> None:
        self._factor, self._dimension = _parse(unit)
        self._value = float(value) if np.ndim(value) == 0 else np.asarray(value, float)
        self._unit = unit

    @property
    def value(self) -> Any:
        """The number or array in `unit`."""
        return self._value

    @property
    def unit(self) -> str:
        """The unit as it was given."""
        return self._unit

    @property
    def si(self) -> Any:
        """The number or array in SI."""
        return self._value * self._factor

    def to(self, unit: str) -> Any:
        """The plain number or array in another unit; InvalidInput where the dimensions differ."""
        factor, dimension = _parse(unit)
        if dimension != self._dimension:
            raise InvalidInput(
                f"{self!r} has the dimension {_named(self._dimension)} and cannot be given"
                f" {_as(unit)}"
            )
        return self._value * (self._factor / factor)

    def __mul__(self, other: Any) -> Quantity:
        if isinstance(other, Quantity):
            return Quantity(self._value * other._value, f"({self._unit}) ({other._unit})")
        return Quantity(self._value * np.asarray(other, float), self._unit)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Quantity:
        if isinstance(other, Quantity):
            return Quantity(self._value / other._value, f"({self._unit})/({other._unit})")
        return Quantity(self._value / np.asarray(other, float), self._unit)

    def __float__(self) -> float:
        if self._dimension != _PURE:
            raise InvalidInput(
                f"{self!r} is no pure number; take .to(unit) of it, or give it where a unit is"
                " expected"
            )
        return float(self.si)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Quantity)
            and self._dimension == other._dimension
            and bool(np.all(self.si == other.si))
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        if np.ndim(self._value) == 0:
            return f"{self._value:g} {self._unit}"
        return f"{np.array2string(np.asarray(self._value), threshold=6, edgeitems=2)} {self._unit}"


class _Units(Mapping[str, Quantity]):
    """Units by name; products, quotients and powers are understood: "gf cm^2/cm", "gf/(cm deg)",
    "g/m²".
    """

    def __getitem__(self, unit: str) -> Quantity:
        return Quantity(1.0, unit)

    def __contains__(self, unit: object) -> bool:
        try:
            _parse(str(unit))
        except InvalidInput:
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(_TABLE)

    def __len__(self) -> int:
        return len(_TABLE)

    def __repr__(self) -> str:
        return f"units({', '.join(_TABLE)}, and their products, quotients and powers)"

    def convert(self, value: Any, unit: str, to: str) -> Any:
        """A number or array given in one unit, in another one.

        >>> round(units.convert(1.0, "gf/(cm deg)", "N/m"), 2)
        56.19
        """
        return Quantity(value, unit).to(to)


units = _Units()


def in_unit(value: Any, unit: str, where: str) -> Any:
    """`value` as plain number or array in `unit`: converted where it carries a unit (ours or
    Pint's), else as it is.
    """
    if isinstance(value, Quantity):
        try:
            return value.to(unit)
        except InvalidInput as error:
            raise InvalidInput(f"{where} must be {_wanted(unit)}: {error}") from None
    if hasattr(value, "magnitude") and hasattr(value, "dimensionality"):  # Pint
        try:
            return value.to("dimensionless" if unit == "1" else unit).magnitude
        except (
            Exception
        ) as error:  # Pint's own error: a subclass of TypeError, but known only where Pint is
            raise InvalidInput(
                f"{where} must be {_wanted(unit)}, got {value} [{value.dimensionality}]: {error}"
            ) from None
    return value


def number_in(value: Any, unit: str, where: str) -> float:
    """The same for one number; InvalidInput where it is none."""
    number = in_unit(value, unit, where)
    if isinstance(number, (str, bytes)) or np.ndim(number) != 0:
        raise InvalidInput(f"{where} must be a number, {_wanted(unit)}, got {value!r}")
    try:
        return float(number)
    except (TypeError, ValueError):
        raise InvalidInput(f"{where} must be a number, {_wanted(unit)}, got {value!r}") from None


def is_angle(value: Any) -> bool:
    """Whether a value carries a unit of angle, ours or Pint's."""
    if isinstance(value, Quantity):
        return value.unit in ("deg", "degrees", "°", "rad")
    units_of_pint = getattr(value, "units", None) if hasattr(value, "dimensionality") else None
    return str(units_of_pint) in (
        "degree",
        "radian",
        "milliradian",
        "arcminute",
        "arcsecond",
        "turn",
        "grade",
    )


def _as(unit: str) -> str:
    return "as a pure number" if unit == "1" else f"in {unit}"


def _wanted(unit: str) -> str:
    return "a pure number" if unit == "1" else f"in {unit}"


_TOKEN = re.compile(
    r"\s*(?:(?P<name>[A-Za-z%°]+|1(?![0-9]))|(?P<power>\^|\*\*)\s*(?P<exponent>[+-]?\d+)|(?P<sign>[*·/()]))"
)
_SUPERSCRIPTS = str.maketrans({"²": "^2", "³": "^3", "µ": "u", "μ": "u", "⋅": "·"})


def _parse(unit: str) -> tuple[float, Dimension]:
    """Factor to SI and dimension."""
    if not isinstance(unit, str):
        raise InvalidInput(f"a unit must be a text like 'gf/cm', got {unit!r}")
    text, tokens, at = unit.translate(_SUPERSCRIPTS).strip(), [], 0
    while at < len(text):
        if not (found := _TOKEN.match(text, at)):
            raise InvalidInput(
                f"unit {unit!r} is not understood at {text[at:]!r}; write it like 'gf cm^2/cm'"
            )
        tokens.append("^" + found["exponent"] if found["power"] else found["name"] or found["sign"])
        at = found.end()
    factor, dimension, rest = _product(tokens, unit)
    if rest:
        raise InvalidInput(f"unit {unit!r} has a ')' without '('")
    return factor, dimension


def _product(tokens: list[str], unit: str) -> tuple[float, Dimension, list[str]]:
    """Factors up to the end or a closing parenthesis."""
    factor, dimension, sign, divided = 1.0, _PURE, 1, False
    empty = True
    while tokens and tokens[0] != ")":
        token, *tokens = tokens
        if token in "*·/":
            if empty or not tokens or tokens[0] in "*·/)":
                raise InvalidInput(f"unit {unit!r} lacks a factor beside {token!r}")
            sign, divided = (-1, True) if token == "/" else (1, divided)
            if token != "/" and divided:
                raise InvalidInput(
                    f"unit {unit!r} is ambiguous; put what is below the line in parentheses, as in"
                    " gf/(cm deg)"
                )
            continue
        if divided and sign == 1:
            raise InvalidInput(
                f"unit {unit!r} is ambiguous; put what is below the line in parentheses, as in"
                " gf/(cm deg)"
            )
        if token == "(":
            scale, exponents, tokens = _product(tokens, unit)
            if not tokens:
                raise InvalidInput(f"unit {unit!r} has a '(' without ')'")
            tokens = tokens[1:]
        elif token in _TABLE:
            scale, exponents = _TABLE[token]
        else:
            raise InvalidInput(f"unit {unit!r}: {token!r} is not known; known: {', '.join(_TABLE)}")
        power = sign
        if tokens and tokens[0].startswith("^"):
            power, tokens = sign * int(tokens[0][1:]), tokens[1:]
        factor *= scale**power
        dimension = tuple(a + power * b for a, b in zip(dimension, exponents, strict=True))  # type: ignore[assignment]
        sign, empty = 1, False
    if empty:
        raise InvalidInput(f"a unit must be a text like 'gf/cm', got {unit!r}")
    return factor, dimension, tokens


def _named(dimension: Dimension) -> str:
    """For people: N/m, kg/m^2 ..., else base units."""
    for name in (
        "1",
        "m",
        "kg",
        "s",
        "N",
        "N/m",
        "N m",
        "kg/m^2",
        "kg/m^3",
        "Pa",
        "m^2",
        "1/m",
        "N s/m",
    ):
        if _parse(name)[1] == dimension:
            return name
    return " ".join(
        f"{name}^{power}" for name, power in zip(("kg", "m", "s"), dimension, strict=True) if power
    )
