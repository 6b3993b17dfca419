"""Seams between edges of panels, and the merging of vertices along them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .edges import Edge
from .panel import Panel
from .placement import Placement

__all__ = ["Pattern", "Seam"]

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Seam:
    """Two edges that are sewn together.

    first, second : names of the edges as "panel.edge"
    reverse : True joins the end of one edge to the start of the other, as for two panels whose
        outsides face the same way. False joins start to start. None selects the order in which the
        placed edges are closer together, or True if both orders are equally close.
    """

    first: str
    second: str
    reverse: bool | None = None

    def __str__(self) -> str:
        return f"seam {self.first} - {self.second}"


@dataclass(frozen=True)
class Pattern:
    """Panels and the seams between their edges, to be sewn by garment() or close_seams().

    panels : at least one Panel; no two may have the same name
    seams : seams, each a Seam or a pair of names "panel.edge"

    Raises InvalidInput for other panels or seams. Only check() tests whether the edges exist.
    """

    panels: tuple[Panel, ...]
    seams: tuple[Seam, ...]

    def __post_init__(self) -> None:
        if not np.iterable(self.seams):
            raise InvalidInput(f"seams must be a list of seams, got {self.seams!r}")
        panels = tuple(self.panels) if np.iterable(self.panels) else (self.panels,)
        _check_panels(panels)
        object.__setattr__(self, "panels", panels)
        object.__setattr__(self, "seams", tuple(_seam(s) for s in self.seams))

    def __repr__(self) -> str:
        names = ", ".join(panel.name for panel in self.panels)
        return f"Pattern({names}: {len(self.seams)} seams)"

    def panel(self, name: str) -> Panel:
        """Returns a panel by its name. Raises InvalidInput for an unknown name."""
        for panel in self.panels:
            if panel.name == name:
                return panel
        raise InvalidInput(
            f"there is no panel {name!r}; there are {', '.join(p.name for p in self.panels)}"
        )

    def edge(self, name: str) -> Edge:
        """Returns an edge by its name "panel.edge"."""
        panel, _, edge = name.partition(".")
        return self.panel(panel).edge(edge)

    def placed(self, places: Mapping[str, Placement]) -> Pattern:
        """Returns the pattern with new placements of the named panels."""
        for name in places:
            self.panel(name)
        return Pattern(
            tuple(p.placed(places[p.name]) if p.name in places else p for p in self.panels),
            self.seams,
        )

    def check(self, ease: float) -> None:
        """Raises InvalidInput if the pattern cannot be sewn.

        Reasons are edges that are unknown or sewn twice, sewn edges whose lengths differ by more
        than `ease` times the longer one, panels that are not connected, and an `ease` outside
        [0, 1).
        """
        if not (np.isfinite(ease) and 0 <= ease < 1):
            raise InvalidInput(f"ease must be in [0, 1), got {ease}")
        _check_seams(self, ease)
        _check_connected(self)


def _seam(given: Seam | Sequence[str]) -> Seam:
    if isinstance(given, Seam):
        return given
    pair = isinstance(given, (list, tuple)) and len(given) == 2
    if not pair or not all(isinstance(name, str) for name in given):
        raise InvalidInput(f'a seam must be a Seam or two names "panel.edge", got {given!r}')
    return Seam(given[0], given[1])


def _check_panels(panels: Sequence[Panel]) -> None:
    if not panels or not all(isinstance(panel, Panel) for panel in panels):
        raise InvalidInput(f"a garment needs at least one Panel, got {panels!r}")
    names = [panel.name for panel in panels]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(f"two panels are called {name!r}; give each its own name")


def _check_seams(pattern: Pattern, ease: float) -> None:
    sewn: dict[str, Seam] = {}
    for seam in pattern.seams:
        for name in (seam.first, seam.second):
            pattern.edge(name)
            if name in sewn or seam.first == seam.second:
                other = sewn.get(name, seam)
                raise InvalidInput(
                    f"edge {name} is sewn twice, by {other} and by {seam}; three layers cannot"
                    " meet: split the edge"
                )
            sewn[name] = seam
        lengths = pattern.edge(seam.first).length, pattern.edge(seam.second).length
        miss = abs(lengths[0] - lengths[1]) / max(lengths)
        if miss > ease:
            raise InvalidInput(
                f"{seam}: the edges are {lengths[0]:.4f} m and {lengths[1]:.4f} m long,"
                f" {100 * miss:.1f} % apart, and ease is {ease:g}; correct the panels, or allow"
                " more ease"
            )


def _check_connected(pattern: Pattern) -> None:
    joined = {panel.name: panel.name for panel in pattern.panels}

    def root(name: str) -> str:
        while joined[name] != name:
            name = joined[name]
        return name

    for seam in pattern.seams:
        joined[root(seam.first.partition(".")[0])] = root(seam.second.partition(".")[0])
    main = root(pattern.panels[0].name)
    loose = [panel.name for panel in pattern.panels if root(panel.name) != main]
    if loose:
        raise InvalidInput(
            f"the garment falls into pieces: no seam leads from {pattern.panels[0].name!r} to"
            f" {', '.join(map(repr, loose))}; add the missing seams, or make them garments of"
            " their own"
        )


def turned_panels(pattern: Pattern, reverse: Mapping[Seam, bool]) -> dict[str, bool]:
    """Returns, by name, whether each panel must be turned over so that all outsides match.

    They match if they lie on one side of the sewn garment. The first panel is not turned. Raises
    InvalidInput if this is impossible, as on a Moebius strip.
    """
    turned = {pattern.panels[0].name: False}
    queue = [pattern.panels[0].name]
    while queue:
        name = queue.pop(0)
        for seam in pattern.seams:
            ends = [side.partition(".")[0] for side in (seam.first, seam.second)]
            if name not in ends:
                continue
            other = ends[1] if ends[0] == name else ends[0]
            wanted = turned[name] != (not reverse[seam])
            if other not in turned:
                turned[other] = wanted
                queue.append(other)
            elif turned[other] != wanted:
                raise InvalidInput(
                    f"{seam} twists the garment into a one-sided surface; reverse it"
                )
    return turned


def merged(count: int, pairs: Iterable[tuple[int, int]]) -> Indices:
    """Returns, for each of `count` vertices, its index after pairs of vertices have been joined.

    The new vertices are in the order of their smallest original indices.
    """
    parent = list(range(count))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for a, b in pairs:
        low, high = sorted((root(int(a)), root(int(b))))
        parent[high] = low
    roots = np.array([root(i) for i in range(count)])
    _, index = np.unique(roots, return_inverse=True)
    return index.astype(np.int64)
