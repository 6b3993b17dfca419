"""Edges of a flat panel: polylines, Bézier curves, arcs and circles, sampled evenly by length.

All functions that make an edge raise InvalidInput for points that are not pairs of finite numbers,
for an edge of length 0, and for a name that is empty or contains a dot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core import InvalidInput
from ..base.arguments import takes

__all__ = ["Edge", "arc", "circle", "cubic", "line", "polyline", "quadratic"]

Floats = NDArray[np.float64]
Point = tuple[float, float]

# Number of chords that approximate a curve. The relative error of a half circle's length is then
# below 1e-5.
FINE = 512


@dataclass(frozen=True)
class Edge:
    """One directed edge of a panel's outline or of a hole.

    Edges are made by line, polyline, quadratic, cubic, arc or circle.

    name : name within the panel
    kind : "polyline", "quadratic", "cubic", "arc" or "circle"
    points : points that define the edge [m], as seen from the outside of the garment: all points of
        a polyline; ends and control points of a Bézier curve; start, intermediate point and end of
        an arc; start, opposite point and start of a circle
    """

    name: str
    kind: str
    points: tuple[Point, ...]

    @property
    def start(self) -> Point:
        """First point [m]."""
        return self.points[0]

    @property
    def end(self) -> Point:
        """Last point [m]."""
        return self.points[-1]

    @property
    def length(self) -> float:
        """Length of the curve [m]."""
        return float(np.linalg.norm(np.diff(self.curve(), axis=0), axis=1).sum())

    def curve(self) -> Floats:
        """Returns the points (k x 2) [m] of a polyline that approximates the edge."""
        control = np.array(self.points, float)
        t = np.linspace(0.0, 1.0, FINE + 1)[:, None]
        fine: Floats
        if self.kind == "quadratic":
            a, b, c = control
            fine = (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t**2 * c
        elif self.kind == "cubic":
            a, b, c, d = control
            fine = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
        elif self.kind == "arc":
            centre, radius, first, sweep = _circle(control)
            angle = first + sweep * t[:, 0]
            fine = centre + radius * np.c_[np.cos(angle), np.sin(angle)]
            fine[0], fine[-1] = control[0], control[2]
        elif self.kind == "circle":
            centre, arm = (control[0] + control[1]) / 2, (control[0] - control[1]) / 2
            angle = 2 * np.pi * t
            fine = centre + np.cos(angle) * arm + np.sin(angle) * (arm[1], -arm[0])  # clockwise
            fine[0], fine[-1] = control[0], control[0]
        else:
            fine = control
        return fine

    def sampled(self, segments: int) -> Floats:
        """Returns points ((segments + 1) x 2) [m] that divide the edge evenly by length.

        Corners of a polyline are in general not among these points.
        """
        fine = self.curve()
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
        at = np.linspace(0.0, along[-1], segments + 1)
        sampled = np.c_[np.interp(at, along, fine[:, 0]), np.interp(at, along, fine[:, 1])]
        sampled[0], sampled[-1] = self.start, self.end
        return np.asarray(sampled, float)

    def mirrored(self) -> Edge:
        """Returns the edge mirrored about x = 0 and reversed.

        The reversal keeps the outline of a mirrored panel counter-clockwise.
        """
        return Edge(self.name, self.kind, tuple((-x, y) for x, y in reversed(self.points)))


@takes(start="m", end="m")
def line(name: str, start: ArrayLike, end: ArrayLike) -> Edge:
    """Straight edge between two points [m]. Raises InvalidInput if they coincide.

    >>> line("side", (0, 0), (0, 0.4)).length
    0.4
    """
    return _edge(name, "polyline", [start, end])


@takes(points="m")
def polyline(name: str, points: ArrayLike) -> Edge:
    """Polyline through points (k x 2) [m]."""
    return _edge(name, "polyline", points)


@takes(start="m", control="m", end="m")
def quadratic(name: str, start: ArrayLike, control: ArrayLike, end: ArrayLike) -> Edge:
    """Quadratic Bézier curve from start to end; points in [m]."""
    return _edge(name, "quadratic", [start, control, end])


@takes(start="m", control="m", second_control="m", end="m")
def cubic(
    name: str, start: ArrayLike, control: ArrayLike, second_control: ArrayLike, end: ArrayLike
) -> Edge:
    """Cubic Bézier curve from start to end; points in [m]."""
    return _edge(name, "cubic", [start, control, second_control, end])


@takes(start="m", through="m", end="m")
def arc(name: str, start: ArrayLike, through: ArrayLike, end: ArrayLike) -> Edge:
    """Circular arc from start to end through a third point [m].

    Raises InvalidInput if the three points lie on a line.

    >>> round(arc("neck", (0.1, 0), (0, 0.1), (-0.1, 0)).length, 5)
    0.31416
    """
    edge = _edge(name, "arc", [start, through, end])
    _circle(np.array(edge.points, float), name)
    return edge


@takes(centre="m", radius="m")
def circle(name: str, centre: ArrayLike, radius: float) -> Edge:
    """Full circle, clockwise from its topmost point, for round holes; lengths in [m].

    Raises InvalidInput unless the centre is two finite numbers and the radius is positive and
    finite, and for an empty name or a name with a dot.

    >>> round(circle("eyelet", (0, 0), 0.01).length, 4)
    0.0628
    """
    try:
        middle, arm = np.asarray(centre, float), float(radius)
    except (TypeError, ValueError):
        middle, arm = np.empty(0), 0.0
    if middle.shape != (2,) or not (np.isfinite(middle).all() and np.isfinite(arm) and arm > 0):
        got = f"{centre!r}, {radius!r}"
        raise InvalidInput(
            f"circle {name!r} needs a centre of two numbers and a radius > 0 [m], got {got}"
        )
    top, bottom = middle + (0.0, arm), middle - (0.0, arm)
    return _edge(name, "circle", [top, bottom, top])


def _edge(name: str, kind: str, points: Any) -> Edge:
    try:
        array = np.asarray(points, float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) < 2 or not np.isfinite(array).all():
        got = points.tolist() if isinstance(points, np.ndarray) else points
        raise InvalidInput(
            f"edge {name!r} needs at least two points of two finite numbers [m], got {got!r}"
        )
    if "." in name or not name:
        raise InvalidInput(
            f"an edge needs a name without a dot, got {name!r}; groups are called panel.edge"
        )
    if not np.linalg.norm(np.diff(array, axis=0), axis=1).sum() > 0:
        x, y = array[0]
        raise InvalidInput(f"edge {name!r} has no length: all its points are ({x:g}, {y:g})")
    return Edge(name, kind, tuple((float(x), float(y)) for x, y in array))


def _circle(points: Floats, name: str = "") -> tuple[Floats, float, float, float]:
    """Returns centre, radius [m], angle of the first point and sweep [rad] of an arc by 3 points.

    The sweep is positive if the arc runs counter-clockwise.
    """
    a, b, c = points
    system = 2.0 * np.array([b - a, c - a])
    determinant = float(np.linalg.det(system))
    if abs(determinant) < 1e-9 * float(np.abs(system).max()) ** 2:
        raise InvalidInput(
            f"arc {name!r}: its three points lie on a line; use line(), or move the middle point"
        )
    centre = np.linalg.solve(system, [b @ b - a @ a, c @ c - a @ a])
    first, middle, last = (np.arctan2(*(p - centre)[::-1]) for p in (a, b, c))
    sweep = float((last - first) % (2 * np.pi))
    if float((middle - first) % (2 * np.pi)) > sweep:
        sweep -= 2 * np.pi
    return centre, float(np.linalg.norm(a - centre)), float(first), sweep
