"""Flat pieces of a pattern: outlines of named edges with a grain and a place in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .edges import Edge
from .placement import Placement, Plane

__all__ = ["Panel"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Panel:
    """A flat piece of cloth, viewed from the outside of the garment.

    name : unique in a garment
    edges : counter-clockwise, each begins where the one before ends; darts are notches of the outline
    grain_degrees : direction of the warp from the panel's y axis, counter-clockwise [degrees]
    place : where it starts: Plane, Cylinder, Cone, Ribbon or any function of points (n x 2) to (n x 3) [m]

    Raises InvalidInput naming panel and edge where the outline is open, crosses itself, turns clockwise or is empty.

    >>> import loomstone as ls
    >>> corners = [(0, 0), (0.3, 0), (0.3, 0.4), (0, 0.4)]
    >>> Panel.polygon("front", corners, names=("hem", "right", "top", "left")).area
    0.12
    """

    name: str
    edges: tuple[Edge, ...]
    grain_degrees: float = 0.0
    place: Placement = field(default_factory=Plane)

    def __post_init__(self) -> None:
        object.__setattr__(self, "edges", tuple(self.edges))
        _check(self)

    @classmethod
    def polygon(
        cls,
        name: str,
        corners: Sequence[tuple[float, float]],
        *,
        names: Sequence[str],
        grain_degrees: float = 0.0,
        place: Placement | None = None,
    ) -> Panel:
        """Panel with straight edges; edge i runs from corner i [m] to the next."""
        if len(names) != len(corners):
            raise InvalidInput(f"panel {name!r}: names must be as many as corners, got {len(names)} and {len(corners)}")
        points = [(float(x), float(y)) for x, y in corners]
        ends = zip(names, points, points[1:] + points[:1], strict=True)
        edges = tuple(Edge(side, "polyline", (a, b)) for side, a, b in ends)
        return cls(name, edges, grain_degrees, Plane() if place is None else place)

    @property
    def area(self) -> float:
        """Within the curved outline [m^2]."""
        return _signed_area(np.concatenate([edge.curve()[:-1] for edge in self.edges]))

    def edge(self, name: str) -> Edge:
        for edge in self.edges:
            if edge.name == name:
                return edge
        known = ", ".join(edge.name for edge in self.edges)
        raise InvalidInput(f"panel {self.name!r} has no edge {name!r}; it has {known}")

    def mirrored(self, name: str, *, place: Placement | None = None) -> Panel:
        """The piece for the other side of the body: mirrored about x = 0, edges keep their names."""
        return Panel(
            name,
            tuple(edge.mirrored() for edge in reversed(self.edges)),
            -self.grain_degrees,
            self.place if place is None else place,
        )

    def placed(self, place: Placement) -> Panel:
        return replace(self, place=place)

    def pattern(self, points: Floats) -> Floats:
        """Points of the panel in the frame whose axes are weft and warp [m]."""
        angle = np.radians(self.grain_degrees)
        weft, warp = (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))
        turned: Floats = points @ np.array([weft, warp]).T
        return turned


def _check(panel: Panel) -> None:
    where = f"panel {panel.name!r}"
    if not panel.name or "." in panel.name:
        raise InvalidInput(f"a panel needs a name without a dot, got {panel.name!r}; groups are called panel.edge")
    if not panel.edges or not all(isinstance(edge, Edge) for edge in panel.edges):
        raise InvalidInput(f"{where}: edges must be made by line, polyline, quadratic ..., got {panel.edges!r}")
    names = [edge.name for edge in panel.edges]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(f"{where} has two edges {name!r}; give each its own name")
    curves = [edge.curve() for edge in panel.edges]
    size = float(np.ptp(np.concatenate(curves), axis=0).max())
    for edge, following in zip(panel.edges, panel.edges[1:] + panel.edges[:1], strict=True):
        gap = float(np.hypot(edge.end[0] - following.start[0], edge.end[1] - following.start[1]))
        if gap > 1e-6 * size:
            raise InvalidInput(
                f"{where} is open: edge {edge.name!r} ends {gap:.3g} m from where edge {following.name!r} begins"
            )
    _check_crossings(panel, curves)
    area = panel.area
    if abs(area) < 1e-6 * size**2:
        raise InvalidInput(f"{where} has no area: {abs(area):.3g} m^2 at a size of {size:.3g} m")
    if area < 0:
        raise InvalidInput(f"{where} runs clockwise; list its edges counter-clockwise, viewed from outside the garment")


def _check_crossings(panel: Panel, curves: list[Floats]) -> None:
    """No two parts of the outline meet but at corners."""
    coarse = [c[:: max(1, (len(c) - 1) // 64)] for c in curves]  # 64 chords a curve, its ends included
    starts, ends = np.concatenate([c[:-1] for c in coarse]), np.concatenate([c[1:] for c in coarse])
    owner = np.concatenate([np.full(len(c) - 1, i) for i, c in enumerate(coarse)])
    n = len(starts)
    for i in range(n - 1):
        others = np.arange(i + 1, n)
        # Neighbours share a point; they cross only where they fold back on one another.
        a, b, c, d = starts[i], ends[i], starts[others], ends[others]
        sides = _turn(a, b, c) * _turn(a, b, d), _turn(c, d, a) * _turn(c, d, b)
        crossing = (sides[0] < 0) & (sides[1] < 0)
        touching = (sides[0] <= 0) & (sides[1] <= 0) & ~crossing & _overlap(a, b, c, d)
        neighbour = (others == i + 1) | ((i == 0) & (others == n - 1))
        free_end = np.where(others[:, None] == i + 1, d, c)
        folded = neighbour & ((d - c) @ (b - a) < 0) & (_turn(a, b, free_end) == 0)
        bad = crossing | (touching & ~neighbour) | folded
        if bad.any():
            other = panel.edges[owner[others[np.argmax(bad)]]].name
            mine = panel.edges[owner[i]].name
            what = f"edge {mine!r} crosses itself" if mine == other else f"edges {mine!r} and {other!r} cross or touch"
            raise InvalidInput(f"panel {panel.name!r}: {what} near ({a[0]:.4g}, {a[1]:.4g}) m; correct its outline")


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
