"""Reads from the files of a run how its ranks shared the work."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from .._core import CacheError
from ..pictures.parallel import ParallelRun, Replayed
from .cache import Run
from .replay import read_predictions
from .steps import read_steps

__all__ = ["read_parallel"]


def read_parallel(directory: str | os.PathLike[str]) -> ParallelRun:
    """Returns how the ranks of a run shared its work, and any predictions of `loomstone replay`.

    Raises CacheError if the run has not ended, or if its steps.csv or run.vtkhdf is missing.
    """
    path = Path(directory)
    steps, report = read_steps(path), _report(path)
    with Run(path) as run:
        rate = run.rate
    if "ranks.collision_waiting" not in steps:
        raise CacheError(f"{path / 'steps.csv'}: has no times of ranks; run the scene again")
    integration, waiting = steps["seconds.integrate"], steps["ranks.collision_waiting"]
    collision = steps["ranks.collision_computing"] + waiting
    wall = steps["ranks.computing"] + steps["ranks.waiting"]
    frame = np.ceil(steps["time"] * rate - 1e-6).astype(int) - 1
    rest = float(np.sum(wall - integration - collision))
    return ParallelRun(
        name=str(path),
        ranks=int(report["ranks"]),
        decomposition=str(report["decomposition"]),
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


def _report(path: Path) -> dict[str, Any]:
    try:
        report = json.loads((path / "report.json").read_text())
    except FileNotFoundError:
        raise CacheError(f"{path}: has no report.json; let the run end, or resume it") from None
    except ValueError as error:
        raise CacheError(f"{path / 'report.json'}: cannot be read: {error}") from None
    for name in ("ranks", "decomposition", "preparation_seconds"):
        if name not in report:
            raise CacheError(f"{path / 'report.json'}: has no {name}; run the scene again")
    return dict(report)


def _replayed(path: Path) -> tuple[Replayed, ...]:
    """Returns the predictions in replay.csv, one object for each decomposition in the file."""
    predictions = sorted(read_predictions(path / "replay.csv"), key=lambda each: each.ranks)
    found = []
    for name in dict.fromkeys(each.decomposition for each in predictions):
        own = [each for each in predictions if each.decomposition == name and each.seconds > 0]
        gains = [each.serial / each.seconds for each in own]
        found.append(Replayed(name, [each.ranks for each in own], gains))
    return tuple(found)
