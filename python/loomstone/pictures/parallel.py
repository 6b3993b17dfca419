"""Picture of how ranks share the work of runs, as in figures 5.7 to 5.9 of [Thomaszewski2010]."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from ..base.figures import new_figure, plain, save_figure

__all__ = ["ParallelRun", "Replayed", "plot_parallel"]

Array = NDArray[np.float64]
STYLES = ("-", "--", ":", "-.")
COLORS = {"predicted": "C0", "static": "C1", "dynamic": "C2"}
PARTS = ("preprocessing", "integration", "collision handling", "other")


@dataclass(frozen=True)
class Replayed:
    """Predicted speed-up of collision searches for several numbers of ranks.

    decomposition : the way in which ranks divide collision handling, as in Simulation
    ranks : numbers of ranks, ascending
    acceleration : speed-up, the time on one rank divided by that on each number of ranks [1]
    """

    decomposition: str
    ranks: Sequence[int]
    acceleration: Sequence[float]


@dataclass(frozen=True)
class ParallelRun:
    """How the ranks of one run shared its work.

    name : path of the directory of the run
    ranks : number of ranks
    decomposition : the way in which ranks divide collision handling, as in Simulation
    frames (f) : times of the frames after the first [s]
    collision, collision_waiting (f) : for each of these frames, the wall time of collision handling
        in the steps since the preceding frame, and the part of it in which a rank communicates or
        waits for others; means over the ranks [s]
    parts : wall time of preprocessing, integration, collision handling and the rest [s]
    waiting : time in which a rank communicates or waits, divided by the wall time of all steps;
        mean over the ranks [1]
    replayed : predictions for the recorded steps of this run
    """

    name: str
    ranks: int
    decomposition: str
    frames: Array
    collision: Array
    collision_waiting: Array
    parts: tuple[float, float, float, float]
    waiting: float
    replayed: tuple[Replayed, ...] = ()


@dataclass(frozen=True)
class _Group:
    """Runs on the same number of ranks with the same decomposition."""

    runs: list[ParallelRun]

    @property
    def ranks(self) -> int:
        return self.runs[0].ranks

    @property
    def decomposition(self) -> str:
        return self.runs[0].decomposition

    @property
    def label(self) -> str:
        return f"{self.ranks} rank{'s' if self.ranks > 1 else ''}, {self.decomposition}"

    def mean(self, name: str) -> Any:
        return np.mean([getattr(run, name) for run in self.runs], axis=0)


def plot_parallel(
    runs: Sequence[ParallelRun], path: str | os.PathLike[str], *, title: str = ""
) -> Path:
    """Draws how ranks share the work of runs of one scene; returns the path of the picture.

    Runs on the same number of ranks with the same decomposition are averaged. The upper row shows
    collision handling over time: the share of time in which ranks compute, the wall time per frame,
    and the speed-up compared with one rank. The lower row shows the wall time of each part of a
    run, the share of time in which ranks communicate or wait, and speed-ups. Filled markers show
    measured speed-ups of collision handling, and open markers predicted speed-ups of collision
    searches (`replayed`).

    path : path of the picture; its suffix selects the format, and is .png by default

    Raises InvalidInput if there are no runs or if the runs differ in their number of frames,
    CacheError if the picture cannot be written, and Unsupported without matplotlib.
    """
    groups = _grouped(runs)
    alone = next((group for group in groups if group.ranks == 1), None)
    figure = new_figure((13, 7.5))
    (used, times, faster), (parts, communication, scaling) = figure.subplots(2, 3)
    numbers = sorted({group.ranks for group in groups})
    for group in groups:
        style: dict[str, Any] = {
            "color": COLORS[group.decomposition],
            "linestyle": STYLES[numbers.index(group.ranks) % len(STYLES)],
            "label": group.label,
        }
        frames, collision = runs[0].frames, group.mean("collision")
        utilization = 1.0 - _ratio(group.mean("collision_waiting"), collision)
        used.plot(frames, 100 * utilization, **style)
        times.plot(frames, 1e3 * collision, **style)
        if alone and group is not alone:
            faster.plot(frames, _ratio(alone.mean("collision"), collision), **style)
    _finish_upper_row(used, times, faster)
    _draw_parts(parts, groups)
    _draw_communication(communication, groups)
    _draw_scaling(scaling, groups, alone, runs)
    if title:
        figure.suptitle(plain(title), fontsize="medium", wrap=True)
    return save_figure(figure, path, dpi=120)


def _grouped(runs: Sequence[ParallelRun]) -> list[_Group]:
    """Returns a group of runs for each number of ranks and decomposition, sorted by both.

    Raises InvalidInput if there are no runs, or if the runs differ in their number of frames.
    """
    if not runs:
        raise InvalidInput("the plot needs at least one run, got none")
    for run in runs:
        if len(run.frames) != len(runs[0].frames):
            raise InvalidInput(
                f"all runs must be of the same scene and length, but {runs[0].name} has"
                f" {len(runs[0].frames)} frames and {run.name} has {len(run.frames)}"
            )
    order = list(COLORS)
    groups: dict[tuple[int, int], list[ParallelRun]] = {}
    for run in runs:
        groups.setdefault((run.ranks, order.index(run.decomposition)), []).append(run)
    return [_Group(groups[key]) for key in sorted(groups)]


def _ratio(a: Array, b: Array) -> Array:
    """Returns a / b, or nan where b is not positive."""
    found: Array = np.full(np.shape(a), np.nan)
    np.divide(a, b, out=found, where=b > 0)
    return found


def _finish_upper_row(used: Any, times: Any, faster: Any) -> None:
    used.set_title("utilization of ranks in collision handling", fontsize="medium")
    used.set_ylabel("computing [%]")
    used.set_ylim(0, 103)
    times.set_title("collision handling", fontsize="medium")
    times.set_ylabel("wall time per frame [ms]")
    if any((line.get_ydata() > 0).any() for line in times.lines):
        times.set_yscale("log")
    faster.set_title("speed-up of collision handling", fontsize="medium")
    faster.set_ylabel("time on one rank / time [1]")
    if not faster.lines:
        faster.text(
            0.5,
            0.5,
            "needs runs on one\nand on several ranks",
            transform=faster.transAxes,
            ha="center",
        )
    for axes in (used, times, faster):
        axes.set_xlabel("time [s]")
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(fontsize="small")


def _leave_empty(axes: Any, reason: str) -> None:
    axes.text(0.5, 0.5, reason, transform=axes.transAxes, ha="center")
    axes.set_xticks([])
    axes.set_yticks([])


def _draw_parts(axes: Any, groups: Sequence[_Group]) -> None:
    """Draws the mean wall time of each part of a run, as one stacked bar for each group."""
    bottom = np.zeros(len(groups))
    places = np.arange(len(groups))
    for part, seconds in zip(PARTS, np.array([g.mean("parts") for g in groups]).T, strict=True):
        axes.bar(places, seconds, 0.7, bottom, label=part)
        bottom += seconds
    several = {len(group.runs) for group in groups} - {1}
    axes.set_title(
        "run time" + (f", mean of {max(several)} runs" if several else ""), fontsize="medium"
    )
    axes.set_xticks(places, [f"{g.ranks}\n{g.decomposition}" for g in groups], fontsize="small")
    axes.set_xlabel("ranks")
    axes.set_ylabel("wall time [s]")
    axes.set_ylim(top=1.4 * bottom.max())
    axes.legend(fontsize="small", ncols=2, loc="upper left")


def _draw_communication(axes: Any, groups: Sequence[_Group]) -> None:
    """Draws the fraction of the wall time in which ranks communicate or wait.

    Each group has one bar for whole steps and one for collision handling.
    """
    places = np.arange(len(groups))
    collision = [
        g.mean("collision_waiting").sum() / max(g.mean("collision").sum(), 1e-300) for g in groups
    ]
    axes.bar(places - 0.18, [100 * g.mean("waiting") for g in groups], 0.36, label="whole steps")
    axes.bar(places + 0.18, 100 * np.array(collision), 0.36, label="collision handling")
    axes.set_title("communication and waiting for other ranks", fontsize="medium")
    axes.set_xticks(places, [f"{g.ranks}\n{g.decomposition}" for g in groups], fontsize="small")
    axes.set_xlabel("ranks")
    axes.set_ylabel("share of the wall time [%]")
    axes.set_ylim(0, 120)
    axes.legend(fontsize="small", ncols=2, loc="upper left")


def _draw_scaling(
    axes: Any, groups: Sequence[_Group], alone: _Group | None, runs: Sequence[ParallelRun]
) -> None:
    """Plots measured and predicted (`replayed`) speed-ups against the number of ranks."""
    most = max(run.ranks for run in runs)
    for name, color in COLORS.items():
        measured = [group for group in groups if group.decomposition == name]
        if alone and any(group.ranks > 1 for group in measured):
            serial = alone.mean("collision").sum()
            axes.plot(
                [group.ranks for group in measured],
                [serial / group.mean("collision").sum() for group in measured],
                f"{color}o-",
                label=f"{name}, measured",
            )
        label: str | None = f"{name}, replayed"
        for replayed in (each for run in runs for each in run.replayed):
            if replayed.decomposition != name:
                continue
            axes.plot(replayed.ranks, replayed.acceleration, f"{color}o--", mfc="w", label=label)
            most, label = max(most, *replayed.ranks), None
    axes.set_title("speed-up of collision handling (replayed: of searches)", fontsize="medium")
    if axes.lines:
        axes.plot([1, most], [1, most], "0.6", linewidth=0.8, label="ideal")
        axes.set_xscale("log", base=2)
        axes.set_yscale("log", base=2)
        axes.legend(fontsize="small")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_major_formatter("{x:g}")
    else:
        _leave_empty(axes, "needs runs on one and on several ranks,\nor `loomstone replay`")
    axes.set_xlabel("ranks")
    axes.set_ylabel("time on one rank / time [1]")
    axes.grid(alpha=0.3)
