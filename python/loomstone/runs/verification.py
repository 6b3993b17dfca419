"""Exact counts of intersecting triangle pairs in frames, independent of collision handling, and
tables of the intersections and exceeded strain limits that remained after steps.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from .._core import Frame, FrameTopology
from .stacked import StoredFrames
from .tables import read_rows, read_table, write_table

__all__ = [
    "BROKEN",
    "FORCED",
    "MOST_BROKEN",
    "FrameTable",
    "Intersections",
    "append_rows",
    "count_intersections",
    "keep_rows",
]


class Intersections(NamedTuple):
    """Numbers of intersecting triangle pairs.

    cloth : pairs with at least one cloth triangle
    bodies : pairs of triangles of bodies and obstacles
    """

    cloth: int
    bodies: int


def count_intersections(topology: FrameTopology, frame: Frame) -> Intersections:
    """Counts intersecting triangle pairs by exact predicates, except pairs that share a vertex."""
    points = np.concatenate([frame.positions, frame.body_vertices])
    triangles = np.concatenate([topology.triangles, topology.body_triangles + len(frame.positions)])
    pairs = np.asarray(_core.intersecting_pairs(points, triangles)).reshape(-1, 2)
    cloth = int((pairs < len(topology.triangles)).any(axis=1).sum())
    return Intersections(cloth, len(pairs) - cloth)


class FrameTable:
    """frames.csv: one row of counts per frame.

    stored : the frames that the run has stored; the last one has the index `until_frame` - 1

    Counts the intersections of those stored frames that have no row in an existing table. Raises
    CacheError if this table is damaged.
    """

    HEADER = ("frame", "time", "intersecting_pairs", "pairs_among_bodies")

    def __init__(
        self, path: Path, topology: FrameTopology, stored: StoredFrames, until_frame: int
    ) -> None:
        self._path, self._topology = path, topology
        known: dict[float, list[Any]] = {}
        if path.exists() and until_frame > 0:
            _, rows = read_table(path, self.HEADER[0])
            known = {float(row[0]): list(row) for row in rows}
        indices = range(until_frame - len(stored), until_frame)
        kept = [
            known[index] if index in known else self._row(index, stored[place])
            for place, index in enumerate(indices)
        ]
        write_table(path, self.HEADER, kept)

    def add(self, index: int, frame: Frame) -> None:
        row = self._row(index, frame)
        with self._path.open("a", newline="") as file:
            csv.writer(file).writerow(row)

    def _row(self, index: int, frame: Frame) -> list[Any]:
        counts = count_intersections(self._topology, frame)
        return [index, frame.time, counts.cloth, counts.bodies]

    def summary(self) -> dict[str, Any]:
        with self._path.open(newline="") as file:
            counts = [int(row["intersecting_pairs"]) for row in csv.DictReader(file)]
        return {
            "verified_frames": len(counts),
            "intersecting_frames": sum(count > 0 for count in counts),
            "most_intersecting_pairs": max(counts, default=0),
        }


# File names and columns of two tables, each of which exists only if it has rows. FORCED lists the
# triangle pairs in Simulation.forced_pairs after each step. BROKEN lists the largest excesses over
# strain limits that remain after each step.
FORCED = (
    "forced.csv",
    ("step", "triangle", "other_triangle"),
)
BROKEN = (
    "limits.csv",
    ("step", "triangle", "direction", "excess"),
)
MOST_BROKEN = 20  # largest number of rows per step in the table BROKEN


def append_rows(
    path: Path, columns: Sequence[str], step: int, rows: Iterable[Sequence[object]]
) -> None:
    """Appends rows of a step. Triangles are numbered over cloth, then over bodies and obstacles."""
    new = not path.exists()
    with path.open("a", newline="") as file:
        table = csv.writer(file)
        if new:
            table.writerow(columns)
        table.writerows([step, *row] for row in rows)


def keep_rows(path: Path, until_step: int) -> None:
    """Removes incomplete rows, rows of steps after `until_step`, and the file if no rows remain."""
    if not path.exists():
        return
    header, rows = read_rows(path)  # a killed run can leave an empty file
    kept = [
        row
        for row in rows
        if len(row) == len(header) and row[0].isdecimal() and int(row[0]) <= until_step
    ]
    if kept:
        write_table(path, header, kept)
    else:
        path.unlink()
