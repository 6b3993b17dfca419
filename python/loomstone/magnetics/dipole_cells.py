"""Magnets as hierarchies of dipole cells, the method of [Thomaszewski2010].

The method is fast, but inaccurate near contact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import InvalidInput, MagneticBody
from ..base.arguments import takes

__all__ = ["as_cells", "cell_front", "cell_level", "cells"]

Floats = NDArray[np.float64]


@takes(density="1/m^3", separation="1")
def cells(body: MagneticBody, *, density: float, separation: float = 3.0) -> MagneticBody:
    """Returns a solid hard magnet as a hierarchy of dipole cells of [Thomaszewski2010].

    The method follows section 6.3.2. Pose and moment are kept. The bounding box is bisected
    repeatedly, each cell across its longest edge, until there are at least `density` cells per
    volume [1/m^3]. A leaf of volume v is dropped if its centre lies outside the magnet, or closer
    to the magnet's surface than v^(1/3) / 2. If no leaf remains, a single dipole is used. The
    moments that cell_level() returns for a level add up to the moment of the magnet.

    Between two such bodies, force() and forces() sum over the cells that cell_front() returns. A
    cell that is not a leaf is only used if its distance from the bounding box of the other body is
    at least `separation` times its longest edge. This is eq. (6.19) with r_0 = separation /
    density^(1/3). If two cells are closer to each other than the smaller v^(1/3) of the two bodies,
    their force grows only like 1 / distance. field() sums over the leaves.

    The force between two cubes of 8 x 8 x 8 cells is 39 % too large in contact, and 4 % too large
    at a gap of a twentieth of their size. Raises InvalidInput for currents, dipoles and induced
    bodies, density <= 0, separation < 1, and density * volume of the bounding box > 4,000,000.

    >>> import loomstone as ls
    >>> magnet = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    >>> body = ls.magnetics.cells(magnet, density=8e6)
    >>> len(ls.magnetics.cell_level(body, 99)[0])
    8
    """
    return _core.magnetic_cells(body, density=density, separation=separation)


@takes()
def cell_level(body: MagneticBody, level: int) -> tuple[Floats, Floats]:
    """Returns positions [m] and moments [A m^2], each (n, 3), of the cells of one level.

    Level 0 is the whole body. Leaves that lie on coarser levels are included. Raises InvalidInput
    for a negative level, and for a body that cells() has not made.
    """
    if level < 0:
        raise InvalidInput(f"level must be at least 0, got {level}")
    return _core.magnetic_cell_level(body, level)


@takes()
def cell_front(body: MagneticBody, other: MagneticBody) -> tuple[Floats, Floats]:
    """Returns positions [m] and moments [A m^2], each (n, 3), of the cells that act on `other`.

    These are the coarsest cells of `body` that are far enough from `other` for their size (see
    cells()), and leaves where no cell is far enough. Raises InvalidInput unless cells() has made
    both bodies.
    """
    return _core.magnetic_cell_front(body, other)


def as_cells(body: MagneticBody, engine: str, density: float | None) -> MagneticBody:
    """Returns the body itself for engine "exact", or its dipole cells for engine "cells"."""
    if engine == "exact" and density is None:
        return body
    if engine == "exact":
        raise InvalidInput(f'density must be None with engine="exact", got {density}; leave it out')
    if engine != "cells":
        raise InvalidInput(f'engine must be "exact" or "cells", got {engine!r}')
    if density is None:
        raise InvalidInput(
            'density [1/m^3] must be given with engine="cells"; 8e6 makes eight cells per'
            " cubic centimetre"
        )
    return cells(body, density=density)
