"""Field lines as polylines, and as curves for the renderer."""

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

__all__ = ["FieldLines", "LineEnd", "curves_of", "field_lines", "frame_curves", "frame_lines"]

Floats = NDArray[np.float64]
# A frame shows no field lines if there is no uniform field and all components of B near the magnets
# are below this value [T]; see _is_weak(). A straight wire with a current of 1 A causes 200 times
# this flux density at a distance of 10 cm.
WEAK = 1e-8


class LineEnd(IntEnum):
    """Reason why a field line begins or ends at a point."""

    seed = 0  # this end is the seed of a line traced in one direction only
    body = 1  # the line enters or leaves a magnet or a magnetised body
    left = 2  # the line enters or leaves the ball of radius `extent` about `centre`
    closed = 3  # the line returns to its start
    length = 4  # the line reaches the limit of its length or number of steps
    no_field = 5  # the field vanishes or is not finite there, or the line hardly moves


class FieldLines(NamedTuple):
    """Field lines in the direction of B: points (k, 3) [m] of each line, and the reasons why its
    two ends lie where they do (`LineEnd`).
    """

    lines: list[Floats]
    begins: list[LineEnd]
    ends: list[LineEnd]

    def __repr__(self) -> str:
        return f"FieldLines({len(self.lines)} lines, {sum(map(len, self.lines))} points)"


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
    """Traces lines of B by an adaptive Runge-Kutta pair of orders 5 and 4 [Dormand1980].

    Without seeds, `lines` lines start at points that represent equal flux. These points lie where
    flux leaves the surfaces of magnets and of magnetised bodies, on discs in loops and solenoids,
    and on surfaces that closed polylines span. Lines from the surfaces of bodies are traced along
    B, all others in both directions. Lines are dense where the field is strong. seeds (n, 3) [m]:
    starting points to use instead, each traced in both directions. uniform (3): flux density added
    to that of the bodies [T].

    A line ends where it enters a body (or the thin layer around a magnetised body with panels),
    leaves the ball of radius `extent` [m] about `centre`, or returns to its start. It also ends
    where the field vanishes or is not finite, or where the line hardly moves. In each direction, it
    ends after `length` [m] (0: 20 extents) or a thousand steps (more if tolerance < 1e-5) at the
    latest. extent 0: four times the radius of the bounding ball of the bodies, and the centre of
    that ball in place of `centre`. tolerance [1]: error of a step divided by the extent. Between
    neighbouring points a line turns by about 0.1 rad at most, except at surfaces. threads 0:
    OMP_NUM_THREADS or all processors; the result does not depend on it. Raises InvalidInput for
    values out of range, and if no line can start.

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
    """Returns field lines as tubes of a given radius [m] for the renderer.

    Values for colouring are 1 (red) where a line leaves a body, or at its seed if it is traced only
    in the direction of B; -1 (blue) where it enters a body; and 0 (yellow) at other ends and on
    closed lines. Between the two ends of a line, they change linearly with the length along it.
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
def frame_lines(
    simulation: Any, frame: Frame, lines: int, uniform: ArrayLike = (0.0, 0.0, 0.0)
) -> FieldLines | None:
    """Returns the field lines of a frame, or None if there are no sources.

    Also returns None if there is no uniform field and the field of the sources is negligible (see
    _is_weak()). Sources are the magnets of the frame and the coils that carry a current.
    """
    magnets = simulation.magnets(frame)
    if not magnets or (not np.any(uniform) and _is_weak(magnets)):
        return None
    # A line of this length can leave the ball that bounds lines in field_lines(). A line that
    # circles a current and never closes is cut off before it forms a thick bundle.
    length = 6.0 * _size(magnets)
    return field_lines(magnets, lines, uniform=uniform, tolerance=1e-4, length=length, threads=1)


@takes(uniform="T")
def frame_curves(
    simulation: Any, frame: Frame, lines: int, uniform: ArrayLike = (0.0, 0.0, 0.0)
) -> Curves | None:
    """Returns the lines of `frame_lines` as tubes for the renderer, or None if there are none."""
    found = frame_lines(simulation, frame, lines, uniform)
    if found is None:
        return None
    magnets = simulation.magnets(frame)
    return curves_of(found, 0.006 * (_size(magnets) * max(m.radius for m in magnets)) ** 0.5)


def _size(magnets: list[Any]) -> float:
    """Returns half the diagonal of the box that contains all magnets [m]."""
    low, high = box_of(magnets)
    return float(np.linalg.norm(0.5 * (high - low)))


def _is_weak(magnets: list[Any]) -> bool:
    """Returns whether all components of B are within +-WEAK at two points near each magnet."""
    directions = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    beside = np.concatenate([m.position + 1.2 * m.radius * directions for m in magnets])
    return bool(np.abs(field(magnets, beside, threads=1)).max() < WEAK)
