"""Fabrics made from levels such as "soft" and "stiff", for users without measured numbers."""

from __future__ import annotations

from typing import Any

from .._core import ClothMaterial, InvalidInput
from ..base.arguments import takes
from ..base.quantities import number_in
from .fabric import Fabric
from .table import LEVELS, Level

__all__ = ["of_levels"]


@takes(density="kg/m^2")
def of_levels(
    *,
    weft: str = "medium",
    warp: str = "medium",
    shear: str = "medium",
    bending: str = "medium",
    density: Any = 0.15,
) -> Fabric:
    """Returns a fabric made from levels, as in section 3.3.3 of [Thomaszewski2010].

    Levels are "very soft", "soft", "medium", "firm" and "stiff".

    weft, warp, shear : levels, each of which sets a stiffness and a strain limit
    bending : level of the bending rigidity, which is equal in all directions
    density : mass per area [kg/m^2], or a quantity with a unit

    >>> of_levels(weft="soft", warp="stiff").limits
    (0.15, 0.02, 0.15)
    """
    levels = {mode: _level(mode, level) for mode, level in
              (("weft", weft), ("warp", warp), ("shear", shear), ("bending", bending))}  # fmt: skip
    material = ClothMaterial(
        weft_stiffness=levels["weft"].stiffness,
        warp_stiffness=levels["warp"].stiffness,
        shear_stiffness=levels["shear"].shear,
        bending_weft=levels["bending"].bending,
        bending_warp=levels["bending"].bending,
        density=number_in(density, "kg/m^2", "of_levels: density"),
    )
    limits = (levels["weft"].limit, levels["warp"].limit, levels["shear"].shear_limit)
    name = f"{weft} weft, {warp} warp, {shear} shear, {bending} bending"
    return Fabric(
        material,
        name=name,
        limits=limits,
        source="levels for artists, chosen for loomstone; bending: percentiles of 618 fabrics",
    )


def _level(mode: str, level: str) -> Level:
    if level not in LEVELS:
        raise InvalidInput(f"of_levels: {mode} must be one of {', '.join(LEVELS)}, got {level!r}")
    return LEVELS[level]
