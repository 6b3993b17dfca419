"""Reads from the files of a run how its ranks shared the work."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError
from ..pictures.parallel import ParallelRun, Replayed
from .cache import Run
from .replay import REPLAYED, read_predictions
from .steps import read_steps

__all__ = ["read_parallel"]

COLUMNS = (  # columns of steps.csv that read_parallel() reads
    "time",
    "length",
    "seconds.integrate",
    "ranks.collision_computing",
    "ranks.collision_waiting",
    "ranks.computing",
    "ranks.waiting",
)


def read_parallel(directory: str | os.PathLike[str]) -> ParallelRun:
    """Returns how the ranks of a run shared its work, and any predictions of `loomstone replay`.

    Raises CacheError if the run has not ended, if its steps.csv, report.json or run.vtkhdf is
    missing, or if one of these files or replay.csv cannot be used.
    """
    path = Path(directory)
    steps, report = read_steps(path), _report(path)
    with Run(path) as run:
        rate, end = run.rate, run.times[-1]
    _check_steps(steps, path / "steps.csv", end + 1.0 / rate)
    integration, waiting = steps["seconds.integrate"], steps["ranks.collision_waiting"]
    collision = steps["ranks.collision_computing"] + waiting
    wall = steps["ranks.computing"] + steps["ranks.waiting"]
    frame = np.ceil(steps["time"] * rate - 1e-6).astype(int) - 1
    rest = float(np.sum(wall - integration - collision))
    return ParallelRun(
        name=str(path),
        ranks=report["ranks"],
        decomposition=report["decomposition"],
        frames=(1 + np.arange(frame[-1] + 1)) / rate,
        collision=np.bincount(frame, collision).astype(float),
        collision_waiting=np.bincount(frame, waiting).astype(float),
        parts=(
            float(report["preparation_seconds"]),
            float(integration.sum()),
            float(np.sum(collision)),
            max(0.0, rest),
        ),
        waiting=float(steps["ranks.waiting"].sum() / wall.sum()),
        replayed=_replayed(path),
    )


def _check_steps(steps: Mapping[str, NDArray[Any]], table: Path, end: float) -> None:
    """Raises CacheError unless all COLUMNS are valid, there are steps with times of ranks, `time`
    increases from a value above 0, and the last step starts at `end` or before.

    end : time of the last frame plus the time between two frames [s]
    """
    for name in COLUMNS:
        if name not in steps:
            raise CacheError(f"{table}: has no column {name}; run the scene again")
        if not np.all(np.isfinite(steps[name]) & (steps[name] >= 0.0)):
            raise CacheError(f"{table}: {name} must be finite and >= 0; run the scene again")
    time = steps["time"]
    if len(time) == 0 or not steps["ranks.computing"].any():
        raise CacheError(f"{table}: has no steps with times of ranks; run the scene again")
    if time[0] <= 0.0 or np.any(np.diff(time) <= 0.0):
        raise CacheError(f"{table}: time must increase from step to step; run the scene again")
    if time[-1] - steps["length"][-1] > end:
        raise CacheError(
            f"{table}: must end with the last frame, but goes on to {time[-1]:.6g} s; run the scene"
            " again"
        )


def _report(path: Path) -> dict[str, Any]:
    """Returns the content of report.json.

    Raises CacheError unless it has usable entries `ranks`, `decomposition` and
    `preparation_seconds`.
    """
    file = path / "report.json"
    try:
        report = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise CacheError(f"{path}: has no report.json; let the run end, or resume it") from None
    except ValueError as error:
        raise CacheError(f"{file}: cannot be read: {error}") from None
    if not isinstance(report, dict):
        raise CacheError(f"{file}: must be a JSON object; run the scene again")
    usable: dict[str, Callable[[Any], bool]] = {
        "ranks": lambda value: type(value) is int and value >= 1,
        "decomposition": lambda value: value in REPLAYED,
        "preparation_seconds": lambda value: type(value) in (int, float) and 0.0 <= value < 1e300,
    }
    for name, is_usable in usable.items():
        if name not in report:
            raise CacheError(f"{file}: has no {name}; run the scene again")
        if not is_usable(report[name]):
            raise CacheError(
                f"{file}: cannot use {name} = {report[name]!r:.60}; run the scene again"
            )
    return report


def _replayed(path: Path) -> tuple[Replayed, ...]:
    """Returns the predictions in replay.csv, one object for each decomposition in the file."""
    predictions = sorted(read_predictions(path / "replay.csv"), key=lambda each: each.ranks)
    found = []
    for name in dict.fromkeys(each.decomposition for each in predictions):
        own = [each for each in predictions if each.decomposition == name and each.seconds > 0]
        gains = [each.serial / each.seconds for each in own]
        found.append(Replayed(name, [each.ranks for each in own], gains))
    return tuple(found)
