"""Field lines, as polylines and as curves for the renderer."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import Curves, Frame
from ..base.arguments import takes
from .fields import field
from .sources import Bodies, as_list, box_of

__all__ = ["FieldLines", "LineEnd", "curves_of", "field_lines", "frame_curves"]

Floats = NDArray[np.float64]
# a flux density that pictures leave out, a two-hundredth of what one ampere makes ten centimetres
# off [T]
WEAK = 1e-8


class LineEnd(IntEnum):
    """Why a field line ends."""

    seed = 0  # it was followed one way only
    body = 1  # it enters a magnet or a body that magnetises, or comes out of one
    left = 2  # it leaves the ball of radius extent
    closed = 3  # it meets itself
    length = 4  # it is too long
    no_field = 5  # the field vanishes


class FieldLines(NamedTuple):
    """Field lines in the sense of B: points (k, 3) of each [m]; why each begins and ends where it
    does (`LineEnd`).
    """

    lines: list[Floats]
    begins: list[LineEnd]
    ends: list[LineEnd]


@takes(seeds="m", uniform="T", centre="m", extent="m", length="m", tolerance="1")
def field_lines(
    bodies: Bodies,
    lines: int = 100,
    *,
    seeds: ArrayLike | None = None,
    uniform: ArrayLike = (0.0, 0.0, 0.0),
    centre: ArrayLike = (0.0, 0.0, 0.0),
    extent: float = 0.0,
    length: float = 0.0,
    tolerance: float = 1e-5,
    threads: int = 0,
) -> FieldLines:
    """Traces lines of B by an adaptive Runge-Kutta pair of order 5 and 4.

    Without seeds, `lines` of them begin where equal shares of the flux leave the surfaces of
    magnets and of bodies that magnetise, or pass through loops, solenoids and closed polylines, so
    that they lie dense where the field is strong. seeds (n, 3) [m] are followed both ways instead.
    uniform (3): flux density besides that of the bodies [T]. A line ends where it enters such a
    body, where it leaves the ball of radius `extent` [m] about `centre` (0: four times the ball
    that holds the bodies, about its centre), where it meets itself, after `length` [m] (0: 20
    extents) or a thousand steps, or where the field vanishes. tolerance [1]: error of a step over
    the extent. Neighbouring points turn by about 0.1 at most. threads 0: all processors; the result
    does not depend on it. Raises InvalidInput for values out of range, and where there is nothing
    to begin at.

    >>> import loomstone as ls
    >>> magnet = ls.magnetics.sphere(radius=0.01, polarization=(0, 0, 1))
    >>> found = ls.magnetics.field_lines(magnet, seeds=[[0.02, 0, 0]])
    >>> found.begins[0].name, found.ends[0].name
    ('body', 'body')
    """
    points, first, begins, ends = _core.magnetic_field_lines(
        as_list(bodies), lines, seeds, uniform, centre, extent, length, tolerance, threads
    )
    return FieldLines(
        np.split(points, first[1:-1]), [LineEnd(i) for i in begins], [LineEnd(i) for i in ends]
    )


@takes(radius="m")
def curves_of(found: FieldLines, radius: float) -> Curves:
    """Field lines as tubes of a radius [m]: red where they leave a magnet, blue where they enter
    one, yellow far from both.
    """
    values = []
    for points, begin, end in zip(found.lines, found.begins, found.ends, strict=True):
        lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        share = lengths / max(lengths[-1], 1e-300)
        from_body = begin in (LineEnd.body, LineEnd.seed) and end != LineEnd.closed
        values.append(from_body * (1 - share) - (end == LineEnd.body) * share)
    first = np.append(0, np.cumsum([len(points) for points in found.lines]))
    return Curves(np.concatenate(found.lines), first, np.concatenate(values), radius)


@takes(uniform="T")
def frame_curves(
    simulation: Any, frame: Frame, lines: int, uniform: ArrayLike = (0.0, 0.0, 0.0)
) -> Curves | None:
    """Field lines of a frame of a simulation, of its magnets and of the coils that carry a current;
    None where there is hardly a field.
    """
    magnets = simulation.magnets(frame)
    if not magnets:
        return None
    beside = np.concatenate(
        [
            m.position + 1.2 * m.radius * np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
            for m in magnets
        ]
    )
    if not np.any(uniform) and np.abs(field(magnets, beside, threads=1)).max() < WEAK:
        return None
    low, high = box_of(magnets)
    size = float(np.linalg.norm(0.5 * (high - low)))
    thin = 0.006 * size**0.5 * max(m.radius for m in magnets) ** 0.5
    # Long enough to leave the ball that lines are drawn in, too short for a bundle of those that
    # wind round a current for ever.
    return curves_of(
        field_lines(magnets, lines, uniform=uniform, tolerance=1e-4, length=6.0 * size, threads=1),
        thin,
    )
