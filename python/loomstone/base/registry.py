"""`loomstone.units`: the units of Pint, of the textile industry and of data sheets of magnets.

>>> import loomstone as ls
>>> weight = 5.5 * ls.units["oz/yd^2"]
>>> print(f"{weight.to('g/m^2').magnitude:.1f}")
186.5
>>> ls.ClothMaterial(density=weight).density == weight.to("kg/m^2").magnitude
True
>>> print(f"{(12 * ls.units['kG']).to('T').magnitude:.1f}")
1.2
"""

from __future__ import annotations

import re
from typing import Any

import pint

from .._core import InvalidInput

__all__ = ["Units", "units"]

_OF_TEXTILES = (
    "gram_per_square_meter = gram / meter ** 2 = gsm",
    "cotton_count = 840 * yard / pound = Nec",
    "metric_count = kilometer / kilogram = Nmc",
)
# Pint itself gives the gauss, the oersted and the maxwell fractional dimensions, so they would not
# convert to units of the SI.
_OF_MAGNETS = (
    "gauss = 1e-4 * tesla = G",
    "oersted = 250 / pi * ampere / meter = Oe",
    "maxwell = 1e-8 * weber = Mx",
    "gauss_oersted = gauss * oersted = GOe",
)


class Units(pint.UnitRegistry[Any]):
    """A Pint registry with the units of textiles, such as gsm, tex, denier and gf/cm.

    The gauss, the oersted and the maxwell are 1e-4 T, 1000/(4 pi) A/m and 1e-8 Wb. MGOe is the unit
    of the energy product of magnets.

    units["gf cm^2/cm"] is the quantity 1 gf cm^2/cm, which can be multiplied by a number or an
    array. Classes and functions of loomstone accept quantities of this or any other Pint registry
    for parameters that have a unit. Plain numbers are in SI units, or in degrees for parameters
    such as angle_degrees. Angles are pure numbers (1 rad = 1), so 1 gf/(cm deg) equals 56.19 N/m.
    gf is gram-force, oz and lb are masses (avoirdupois), and % is 0.01.
    """

    def __getitem__(self, unit: str) -> Any:
        if not isinstance(unit, str) or not unit.strip():
            raise InvalidInput(f"a unit must be a string like 'gf/cm', got {unit!r}")
        if _ambiguous(unit):
            raise InvalidInput(
                f"unit {unit!r} is ambiguous; put the denominator in parentheses, as in gf/(cm deg)"
            )
        try:
            return self.Quantity(1.0, self.parse_units(unit.replace("%", "percent")))
        except pint.UndefinedUnitError as error:
            names = ", ".join(map(repr, error.unit_names))
            raise InvalidInput(
                f"unit {unit!r}: {names} is not known; write powers like m^2, and see"
                " pint.readthedocs.io for names"
            ) from None
        except Exception:  # Pint and its tokenizer raise exceptions of many types
            raise InvalidInput(
                f"unit {unit!r} is not understood; write it like 'gf cm^2/cm'"
            ) from None

    def __contains__(self, unit: object) -> bool:
        try:
            self[unit]  # type: ignore[index]
        except InvalidInput:
            return False
        return True


def _ambiguous(unit: str) -> bool:
    """Returns whether a product without parentheses follows the fraction bar, as in gf/cm deg."""
    flat = unit
    while (inner := re.sub(r"\([^()]*\)", "u", flat)) != flat:
        flat = inner
    flat = re.sub(r"\s*(\^|\*\*)\s*[-+]?\d+", "", flat)
    after = flat.partition("/")[2]
    return bool(re.search(r"[^\s*·⋅/]\s*[\s*·⋅]\s*[^\s*·⋅/]", after))


units = Units(on_redefinition="ignore")
units.define("@alias degree = degrees")
for _definition in _OF_TEXTILES + _OF_MAGNETS:
    units.define(_definition)
units._on_redefinition = "warn"  # the default of Pint
units._build_cache()  # Pint keeps the first definition of a unit in its cache
units.formatter.default_format = "~"
