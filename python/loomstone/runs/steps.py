"""steps.csv: a table with one row per step."""

from __future__ import annotations

import csv
import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError, StepReport
from .tables import read_table, write_table

__all__ = [
    "Columns",
    "StepTable",
    "names_of_summary",
    "read_steps",
    "refuse_sweep",
    "summary_of_steps",
]


def _read(path: Path) -> tuple[list[str], list[list[str]]]:
    """Returns the header and the rows of a steps.csv.

    Raises CacheError unless it is a table of numbers with consecutive step numbers, and with whole
    numbers in the columns of integer quantities.
    """
    header, rows = read_table(path, "step")
    whole = {name for name, value in StepReport().numbers().items() if isinstance(value, int)}
    columns = [column for column, name in enumerate(header) if name in whole]
    for line, row in enumerate(rows, 2):
        for column in columns:
            if not row[column].removeprefix("-").isdecimal():
                raise CacheError(
                    f"{path}, line {line}: {header[column]} must be a whole number, got"
                    f" {row[column]!r}; run the scene again"
                )
    for line, (before, row) in enumerate(pairwise(rows), 3):
        if int(row[0]) != int(before[0]) + 1:
            raise CacheError(
                f"{path}, line {line}: step {before[0]} must be followed by the next step, got"
                f" {row[0]}; run the scene again"
            )
    return header, rows


class StepTable:
    """Writes steps.csv. Rows of an existing file are kept up to the step `until_step`.

    If `until_step` is above 0, raises CacheError if an existing file is invalid, has other columns,
    or has rows but ends before `until_step`.
    """

    def __init__(self, path: Path, until_step: int) -> None:
        kept: list[list[str]] = []
        columns = [*StepReport().numbers()]
        if path.exists() and until_step > 0:
            header, rows = _read(path)
            if header != columns:
                raise CacheError(
                    f"{path}: its columns must be those of this version; run the scene again"
                )
            kept = [row for row in rows if int(row[0]) <= until_step]
            last = int(kept[-1][0]) if kept else until_step
            if last < until_step:
                raise CacheError(
                    f"{path}: must have rows up to step {until_step}, from which the run continues,"
                    f" but ends at step {last}; copy it again, or delete it to continue without the"
                    " rows before"
                )
        write_table(path, columns, kept)  # a run that is killed now keeps the rows
        self._path, self._file = path, path.open("a", newline="", encoding="utf-8")
        self._table = csv.writer(self._file)

    def add(self, report: StepReport) -> None:
        self._table.writerow(report.numbers().values())

    def flush(self) -> None:
        self._file.flush()

    def close(self) -> None:
        self._file.close()

    def summary(self) -> dict[str, Any]:
        """Returns totals, means and extremes over all steps of the run, and values at its end."""
        self.flush()
        return summary_of_steps(self._path)


def summary_of_steps(path: Path) -> dict[str, Any]:
    """Returns totals, means, extremes and final values of the steps in the steps.csv at `path`."""
    header, lines = _read(path)
    return _summary([dict(zip(header, line, strict=True)) for line in lines])


def names_of_summary() -> dict[str, Any]:
    """Returns a summary of steps with all its names; the values have no meaning."""
    return _summary([{name: str(value) for name, value in StepReport().numbers().items()}])


def _summary(rows: list[dict[str, str]]) -> dict[str, Any]:
    if not rows:
        return {}
    wanted = sum(float(r["withheld.requested"]) for r in rows)
    squares = [
        float(r["contacts.acceleration"]) ** 2
        for r in rows
        if float(r["contacts.acceleration"]) > 0.0
    ]
    stages = [name for name in rows[0] if name.startswith("seconds.")]
    return {
        "seconds_per_stage": {
            s.removeprefix("seconds."): sum(float(r[s]) for r in rows) for s in stages
        },
        "linear_iterations_per_step": sum(int(r["solver.linear_iterations"]) for r in rows)
        / len(rows),
        "events": sum(int(r["solver.events"]) for r in rows),
        "synchronous_events": sum(int(r["solver.synchronous_events"]) for r in rows),
        "most_contacts": max(int(r["contacts.near"]) for r in rows),
        "impacts": sum(int(r["contacts.impacts"]) for r in rows),
        "withheld_vertices": sum(int(r["withheld.vertices"]) for r in rows),
        "steps_in_parts": sum(int(r["parts"]) > 1 for r in rows),
        "mean_part": _duration(rows) / sum(max(1, int(r["parts"])) for r in rows),
        "least_part": min(float(r["error.least_part"]) for r in rows),
        "steps_beyond_accuracy": sum(int(r["error.beyond"]) > 0 for r in rows),
        **_balances(rows),
        "largest_neglected_strain": max(float(r["error.strain"]) for r in rows),
        "unresolved_steps": sum(int(r["contacts.unresolved"]) > 0 for r in rows),
        "most_intersections": max(int(r["contacts.intersections"]) for r in rows),
        "forced_steps": sum(int(r["contacts.forced"]) > 0 for r in rows),
        "most_forced": max(int(r["contacts.forced"]) for r in rows),
        "limit_sweeps_per_step": sum(int(r["limits.sweeps"]) for r in rows) / len(rows),
        "largest_excess": max(
            float(r[f"limits.{d}_excess"]) for r in rows for d in ("weft", "warp", "shear")
        ),
        "steps_with_broken_limits": sum(int(r["limits.broken"]) > 0 for r in rows),
        "most_broken_limits": max(int(r["limits.broken"]) for r in rows),
        "most_limit_rounds": max(int(r["limits.rounds"]) for r in rows),
        "limit_fallbacks": sum(int(r["limits.fallbacks"]) for r in rows),
        "withheld": sum(float(r["withheld.motion"]) for r in rows) / wanted if wanted else 0.0,
        "withheld_in_worst_step": max(float(r["withheld.share"]) for r in rows),
        "withheld_momentum": sum(float(r["withheld.momentum"]) for r in rows),
        "contact_acceleration": (sum(squares) / len(squares)) ** 0.5 if squares else 0.0,
        "largest_stretch": max(float(r["strain.stretch"]) for r in rows),
        "energy_at_end": {
            name.removeprefix("energy."): float(rows[-1][name])
            for name in rows[0]
            if name.startswith("energy.")
        },
        "account_at_end": {
            name: float(rows[-1][f"account.{name}"])
            for name in ("scripts", "loads", "friction", "damping", "limits", "withheld", "lost")
        },
    }


def _duration(rows: list[dict[str, str]]) -> float:
    """Returns the time from the start of the first step to the end of the last step [s]."""
    first, last = rows[0], rows[-1]
    return float(last["time"]) - (float(first["time"]) - float(first["length"]))


def _balances(rows: list[dict[str, str]]) -> dict[str, float]:
    """Returns the run's largest kinetic energy [J] and, relative to it [1], balances of energy.

    Two of the balances are the largest over all steps, without and with the energy of contacts. The
    third is the balance at the end, without the energy of contacts. See AccountReport in
    core/base/report.h. The balances are 0 if nothing has moved.
    """
    kinetic = [float(r["account.largest_kinetic"]) for r in rows]
    largest = max(kinetic)

    def balances(name: str) -> list[float]:
        gains = (float(r[f"account.{name}"]) * k for r, k in zip(rows, kinetic, strict=True))
        return [gain / largest if largest > 0.0 else 0.0 for gain in gains]

    without = balances("balance")
    return {
        "largest_kinetic_energy": largest,
        "largest_energy_balance": max(without),
        "largest_contact_balance": max(balances("contact_balance")),
        "energy_balance_at_end": without[-1],
    }


class Columns(dict[str, NDArray[Any]]):
    """Columns of a table by name, with a repr of one line."""

    def __repr__(self) -> str:
        length = len(next(iter(self.values()), ()))
        return f"<{len(self)} columns of {length} steps: {', '.join(self)}>"


def refuse_sweep(directory: str | os.PathLike[str]) -> None:
    """Raises CacheError if a directory is that of a parameter sweep. The message names one of its
    runs, if there are any.
    """
    path = Path(directory)
    if not (path / "sweep.json").exists():
        return
    runs = sorted(file.parent for file in path.glob("*/run.vtkhdf"))
    example = f", such as {runs[0]}" if runs else ""
    raise CacheError(f"{path}: holds a sweep; give the directory of one of its runs{example}")


def read_steps(directory: str | os.PathLike[str]) -> Columns:
    """Returns the columns of steps.csv by name, with one entry per step.

    A column in which all numbers are written as integers is returned as integers. Raises CacheError
    if the table is missing, has no steps or is invalid.
    """
    path = Path(directory) / "steps.csv"
    if not path.exists():
        refuse_sweep(directory)
        raise CacheError(
            f"{path}: no table of steps; give the directory of a run of `loomstone run`"
        )
    header, rows = _read(path)
    if not rows:
        raise CacheError(f"{path}: has no steps yet")
    columns = zip(*rows, strict=True)
    return Columns({name: _column(texts) for name, texts in zip(header, columns, strict=True)})


def _column(texts: tuple[str, ...]) -> NDArray[Any]:
    whole = all(text.lstrip("-").isdigit() for text in texts)
    return np.array(texts, dtype=float).astype(np.int64 if whole else float)
