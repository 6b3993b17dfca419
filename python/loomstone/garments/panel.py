"""Flat panels of a pattern: outline and holes of named edges, with a grain and a placement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from ..base.arguments import takes
from .edges import Edge, line
from .placement import Placement, Plane
from .triangulation import Boundary

__all__ = ["Panel"]

Floats = NDArray[np.float64]


@takes(grain_degrees="degrees")
@dataclass(frozen=True)
class Panel:
    """A flat piece of cloth, as seen from the outside of the garment.

    name : unique name in the garment
    edges : edges of the outline, counter-clockwise; each begins where the previous one ends. Darts
        are notches of the outline.
    holes : closed loops of edges, clockwise, so that cloth lies on their left, as for the outline.
        A round hole is a single edge, made by circle(). Triangles around a hole that is narrower
        than two mesh edges may have smaller angles than elsewhere.
    grain_degrees : direction of the warp relative to the panel's y axis, counter-clockwise
        [degrees]
    place : initial placement: Plane, Cylinder, Cone, Ribbon, or any function that maps points (n x
        2) to (n x 3) [m]

    Raises InvalidInput if a loop of edges is open or empty, has no area or the wrong orientation,
    or crosses or touches itself or another loop; if a hole lies outside the outline or inside
    another hole; if two edges have the same name; or if `name` or `place` is invalid.

    >>> import loomstone as ls
    >>> corners = [(0, 0), (0.3, 0), (0.3, 0.4), (0, 0.4)]
    >>> Panel.polygon("front", corners, names=("hem", "right", "top", "left")).area
    0.12
    >>> eyelet = [ls.garments.circle("eyelet", (0.15, 0.35), 0.01)]
    >>> names = ("foot", "leech", "head", "luff")
    >>> round(Panel.polygon("sail", corners, names=names, holes=[eyelet]).area, 5)
    0.11969
    """

    name: str
    edges: tuple[Edge, ...]
    grain_degrees: float = 0.0
    place: Placement = field(default_factory=Plane)
    holes: tuple[tuple[Edge, ...], ...] = ()

    def __post_init__(self) -> None:
        where = f"panel {self.name!r}"
        object.__setattr__(self, "edges", _loop(where, self.edges))
        object.__setattr__(self, "holes", tuple(_loop(where, hole) for hole in self.holes))
        if not callable(self.place):
            raise InvalidInput(
                f"{where}: place must be a Placement or a function, got {self.place!r}"
            )
        _check(self)

    @classmethod
    @takes(corners="m", grain_degrees="degrees")
    def polygon(
        cls,
        name: str,
        corners: Sequence[tuple[float, float]],
        *,
        names: Sequence[str],
        grain_degrees: float = 0.0,
        place: Placement | None = None,
        holes: Sequence[Edge | Sequence[Edge]] = (),
    ) -> Panel:
        """Returns a panel with straight edges; edge i runs from corner i [m] to the next one."""
        if len(names) != len(corners):
            raise InvalidInput(
                f"panel {name!r}: names must be one for each corner, got {len(names)} names"
                f" and {len(corners)} corners"
            )
        points = list(corners)
        ends = zip(names, points, points[1:] + points[:1], strict=True)
        edges = tuple(line(side, a, b) for side, a, b in ends)
        return cls(name, edges, grain_degrees, Plane() if place is None else place, holes)  # type: ignore[arg-type]

    @property
    def area(self) -> float:
        """Area of the panel without its holes [m^2]."""
        return sum(_signed_area(_outline(loop)) for loop in self.loops)

    @property
    def loops(self) -> tuple[tuple[Edge, ...], ...]:
        """The outline, followed by the holes."""
        return self.edges, *self.holes

    def edge(self, name: str) -> Edge:
        """Returns an edge of the outline or of a hole. Raises InvalidInput for an unknown name."""
        edges = [edge for loop in self.loops for edge in loop]
        for edge in edges:
            if edge.name == name:
                return edge
        known = ", ".join(edge.name for edge in edges)
        raise InvalidInput(f"panel {self.name!r} has no edge {name!r}; it has {known}")

    def mirrored(self, name: str, *, place: Placement | None = None) -> Panel:
        """Returns a panel mirrored about x = 0, as needed to make a left sleeve of a right one.

        Edges keep their names.

        place : placement of the mirrored panel; None: that of this panel
        """
        return Panel(
            name,
            tuple(edge.mirrored() for edge in reversed(self.edges)),
            -self.grain_degrees,
            self.place if place is None else place,
            tuple(tuple(edge.mirrored() for edge in reversed(hole)) for hole in self.holes),
        )

    def placed(self, place: Placement) -> Panel:
        """Returns the panel with a new placement."""
        return replace(self, place=place)

    def pattern(self, points: Floats) -> Floats:
        """Converts points of the panel (n x 2) [m] to the axes of weft and warp."""
        angle = np.radians(self.grain_degrees)
        weft, warp = (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))
        turned: Floats = points @ np.array([weft, warp]).T
        return turned


def _loop(where: str, edges: Edge | Sequence[Edge]) -> tuple[Edge, ...]:
    """Returns the edges of a loop. Raises InvalidInput if it is empty or contains other objects."""
    loop = (edges,) if isinstance(edges, Edge) or not np.iterable(edges) else tuple(edges)
    if not loop or not all(isinstance(edge, Edge) for edge in loop):
        raise InvalidInput(
            f"{where}: edges must be created with line, polyline, quadratic ..., got {edges!r}"
        )
    return loop


def _check(panel: Panel) -> None:
    where = f"panel {panel.name!r}"
    if not panel.name or "." in panel.name:
        raise InvalidInput(
            f"a panel needs a name without a dot, got {panel.name!r}; groups are called panel.edge"
        )
    names = [edge.name for loop in panel.loops for edge in loop]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(f"{where} has two edges {name!r}; give each its own name")
    called = [where, *(f"{where}: hole {hole[0].name!r}" for hole in panel.holes)]
    for which, loop in zip(called, panel.loops, strict=True):
        _check_closed(which, loop)
    _check_crossings(panel)
    for which, loop in zip(called, panel.loops, strict=True):
        _check_turn(which, loop, hole=loop is not panel.edges)
    _check_nesting(panel)


def _size(edges: tuple[Edge, ...]) -> float:
    return float(np.ptp(np.concatenate([edge.curve() for edge in edges]), axis=0).max())


def _check_closed(where: str, edges: tuple[Edge, ...]) -> None:
    size = _size(edges)
    for edge, following in zip(edges, edges[1:] + edges[:1], strict=True):
        gap = float(np.hypot(edge.end[0] - following.start[0], edge.end[1] - following.start[1]))
        if gap > 1e-6 * size:
            raise InvalidInput(
                f"{where} is open: edge {edge.name!r} ends {gap:.3g} m from where edge"
                f" {following.name!r} begins"
            )


def _check_turn(where: str, edges: tuple[Edge, ...], *, hole: bool) -> None:
    area, size = _signed_area(_outline(edges)), _size(edges)
    if abs(area) < 1e-6 * size**2:
        raise InvalidInput(f"{where} has no area: {abs(area):.3g} m^2 at a size of {size:.3g} m")
    if hole and area > 0:
        raise InvalidInput(
            f"{where} runs counter-clockwise; list its edges clockwise: cloth lies to their left"
        )
    if not hole and area < 0:
        raise InvalidInput(
            f"{where} runs clockwise; list its edges counter-clockwise, viewed from outside the"
            " garment"
        )


def _thinned(points: Floats, stride: int) -> Floats:
    """Returns every stride-th of the points (n x 2), from the first one on, and the last one."""
    kept: Floats = points[np.unique(np.append(np.arange(0, len(points), stride), len(points) - 1))]
    return kept


def _check_crossings(panel: Panel) -> None:
    """Raises InvalidInput if parts of the outline or holes meet anywhere but at common corners."""
    curves = [[edge.curve() for edge in loop] for loop in panel.loops]
    # Curves of 128 chords or more are approximated by 64 to 96 chords.
    coarse = [[_thinned(c, max(1, (len(c) - 1) // 64)) for c in loop] for loop in curves]
    starts = np.concatenate([c[:-1] for loop in coarse for c in loop])
    ends = np.concatenate([c[1:] for loop in coarse for c in loop])
    names = [edge.name for loop in panel.loops for edge in loop]
    owner = np.repeat(np.arange(len(names)), [len(c) - 1 for loop in coarse for c in loop])
    lengths = [sum(len(c) - 1 for c in loop) for loop in coarse]
    following = np.concatenate(
        [np.roll(np.arange(n), -1) + sum(lengths[:i]) for i, n in enumerate(lengths)]
    )
    n = len(starts)
    for i in range(n - 1):
        others = np.arange(i + 1, n)
        # Neighbouring chords share a point. They overlap only if one folds back onto the other.
        a, b, c, d = starts[i], ends[i], starts[others], ends[others]
        sides = _turn(a, b, c) * _turn(a, b, d), _turn(c, d, a) * _turn(c, d, b)
        crossing = (sides[0] < 0) & (sides[1] < 0)
        touching = (sides[0] <= 0) & (sides[1] <= 0) & ~crossing & _overlap(a, b, c, d)
        after = others == following[i]
        neighbour = after | (following[others] == i)
        free_end = np.where(after[:, None], d, c)
        folded = neighbour & ((d - c) @ (b - a) < 0) & (_turn(a, b, free_end) == 0)
        bad = crossing | (touching & ~neighbour) | folded
        if bad.any():
            other, mine = names[owner[others[np.argmax(bad)]]], names[owner[i]]
            what = (
                f"edge {mine!r} crosses itself"
                if mine == other
                else f"edges {mine!r} and {other!r} cross or touch"
            )
            raise InvalidInput(
                f"panel {panel.name!r}: {what} near ({a[0]:.4g}, {a[1]:.4g}) m; correct its outline"
            )


def _check_nesting(panel: Panel) -> None:
    """Raises InvalidInput if a hole lies outside the outline or inside another hole.

    Assumes that _check_crossings() has found no crossing edges.
    """
    loops = [Boundary([_outline(loop)]) for loop in panel.loops]
    for i, hole in enumerate(panel.holes, 1):
        at = np.array([hole[0].start])
        if not loops[0].contains(at)[0]:
            raise InvalidInput(
                f"panel {panel.name!r}: hole {hole[0].name!r} lies outside the outline"
            )
        for j, other in enumerate(panel.holes, 1):
            if i != j and loops[j].contains(at)[0]:
                raise InvalidInput(
                    f"panel {panel.name!r}: hole {hole[0].name!r} lies within hole"
                    f" {other[0].name!r}"
                )


def _outline(edges: tuple[Edge, ...]) -> Floats:
    return np.concatenate([edge.curve()[:-1] for edge in edges])


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    e, f = b - a, c - a
    turned: Floats = e[..., 0] * f[..., 1] - e[..., 1] * f[..., 0]
    return turned


def _overlap(a: Floats, b: Floats, c: Floats, d: Floats) -> NDArray[np.bool_]:
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.asarray(((np.minimum(c, d) <= high) & (np.maximum(c, d) >= low)).all(axis=1))


def _signed_area(outline: Floats) -> float:
    x, y = outline.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)
