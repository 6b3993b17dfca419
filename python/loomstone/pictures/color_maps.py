"""Colour maps by name, from the tables of the package cmap."""

from __future__ import annotations

import logging
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput

__all__ = ["color_table"]

_ALIASES = {"diverging": "coolwarm"}


@cache
def color_table(name: str) -> tuple[NDArray[np.uint8], bool]:
    """Returns the colours (256 x 3) of a map in sRGB, and whether the map is diverging.

    Raises InvalidInput for an unknown name.
    """
    import cmap

    # cmap logs a warning if several collections have a map of the same name.
    logging.getLogger("cmap").setLevel(logging.ERROR)
    try:
        found = cmap.Colormap(_ALIASES.get(name, name))
    except (ValueError, TypeError):
        raise InvalidInput(
            "render.color_map must be a colour map of matplotlib, such as viridis, magma, cividis,"
            f" coolwarm or RdBu_r, or diverging, got {name!r}"
        ) from None
    colors = np.asarray(found(np.linspace(0.0, 1.0, 256)))[:, :3]
    table = np.rint(255.0 * colors).astype(np.uint8)
    return table, found.category == "diverging"
