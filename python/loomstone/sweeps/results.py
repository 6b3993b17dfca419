"""The table of a sweep, and plots of its figures over a parameter.

A figure is a number, a Boolean value or a string in the report of a run.
"""

from __future__ import annotations

import csv
import difflib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .._core import CacheError, InvalidInput
from ..base.figures import new_figure, plain, save_figure
from ..runs.steps import names_of_summary
from .plan import Point
from .point import finished

__all__ = ["FIGURES", "check_figures", "plot_figures", "write_table"]

FIGURES = ("wall_seconds", "largest_stretch", "most_contacts", "linear_iterations_per_step")


def write_table(points: Sequence[Point], path: Path) -> list[dict[str, Any]]:
    """Writes a table (CSV) with one row per finished run; returns its rows.

    The columns are the name of the run's directory, the parameters, and the figures of report.json.
    If a parameter is named "run", the first column is "report.run".

    Raises CacheError if the file cannot be written.
    """
    rows, first = [], "run"
    if any(first in point.parameters for point in points):
        first = "report.run"
    for point in points:
        report = finished(point.directory)
        if report is not None:
            kept = {name: _cell(value) for name, value in point.parameters.items()}
            rows.append({first: point.name, **kept, **_flat(report, kept)})
    columns = list(dict.fromkeys(name for row in rows for name in row)) or [first]
    temporary = path.with_suffix(".new")
    try:
        with temporary.open("w", newline="") as file:
            table = csv.DictWriter(file, columns, restval="")
            table.writeheader()
            table.writerows(rows)
        temporary.replace(path)
    except OSError as error:
        raise CacheError(f"{path}: the table cannot be written: {error.strerror}") from error
    return rows


def _cell(value: Any) -> Any:
    return value if isinstance(value, (bool, int, float, str)) else json.dumps(value, default=str)


def _flat(report: dict[str, Any], taken: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Returns the figures of a report by dotted names such as energy_at_end.kinetic.

    A figure that has the name of a parameter gets the prefix "report.".
    """
    flat: dict[str, Any] = {}
    for name, value in report.items():
        path = prefix + name
        if isinstance(value, dict):
            flat |= _flat(value, taken, f"{path}.")
        elif isinstance(value, (bool, int, float, str)):
            flat[f"report.{path}" if path in taken else path] = value
    return flat


def check_figures(names: Sequence[str]) -> None:
    """Raises InvalidInput unless each name is that of a figure that can be plotted.

    These are frames, steps, time, wall_seconds and all figures of names_of_summary().
    """
    known = ["frames", "steps", "time", "wall_seconds", *_flat(names_of_summary(), {})]
    for name in names:
        if name not in known:
            close = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {close[0]}?" if close else f"known: {', '.join(known)}"
            raise InvalidInput(f"--plot must name a value in the reports, got {name!r}; {hint}")


def plot_figures(
    rows: Sequence[dict[str, Any]], points: Sequence[Point], figures: Sequence[str], path: Path
) -> Path | None:
    """Plots figures (values of reports) over the numeric parameter with the most values.

    rows : rows of the table of the sweep
    points : points from which the table was made, including those whose runs are not finished
    figures : names of the figures; each has a diagram of its own

    Each combination of the other parameters is a line. Returns the path of the picture, or None if
    no numeric parameter has several values or no run is finished. Raises Unsupported if matplotlib
    is not installed, and CacheError if the picture cannot be written.
    """
    values = _values_of(points)
    numeric = [name for name, each in values.items() if len(each) > 1 and all(map(_number, each))]
    if not rows or not numeric:
        return None
    # If a figure of the report has the name of a parameter, the table adds a prefix to its name.
    figures = [f"report.{name}" if name in values else name for name in figures]
    across = max(numeric, key=lambda name: len(values[name]))
    others = [name for name, each in values.items() if len(each) > 1 and name != across]
    columns = min(2, len(figures))
    lines = -(-len(figures) // columns)
    picture = new_figure((5 * columns, 3.4 * lines))
    panels = picture.subplots(lines, columns, squeeze=False).ravel()
    for axes, name in zip(panels, figures, strict=False):
        _draw(axes, rows, across, others, name)
    for axes in panels[len(figures) :]:
        axes.set_axis_off()
    return save_figure(picture, path, dpi=150)


def _values_of(points: Sequence[Point]) -> dict[str, list[Any]]:
    """Returns the different values of each parameter."""
    values: dict[str, dict[Any, None]] = {}
    for point in points:
        for name, value in point.parameters.items():
            values.setdefault(name, {})[_cell(value)] = None
    return {name: list(each) for name, each in values.items()}


def _draw(
    axes: Any, rows: Sequence[dict[str, Any]], across: str, others: list[str], name: str
) -> None:
    series: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        label = ", ".join(f"{other}={_shown(row.get(other))}" for other in others)
        # Reports of older versions may lack a figure.
        if _number(row.get(name)) and _number(row.get(across)):
            series.setdefault(label, []).append((row[across], row[name]))
    for label, found in series.items():
        x, y = zip(*sorted(found), strict=True)
        axes.plot(x, y, "o-", label=plain(label) or None, markersize=3)
    axes.set_xlabel(across)
    axes.set_ylabel(name)
    axes.grid(alpha=0.3)
    if others:
        axes.legend(fontsize="small")


def _shown(value: Any) -> str:
    return f"{value:.12g}" if _number(value) else str(value)


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
