"""Plots of a run over time, from its table of steps."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from ..base.arguments import takes
from ..base.figures import new_figure, plain, save_figure

__all__ = ["KINDS", "ROUNDING", "plot_steps", "scale_of_gains"]

Steps = Mapping[str, NDArray[Any]]
KINDS = ("energy", "stages", "contacts", "stretch", "strain", "iterations", "step")

# Stages that take at most this fraction of the wall time of all stages are left out of the plot.
LEAST_SHARE = 1e-3

# Energies of at most this fraction of the largest one are left out, because they are considered
# rounding errors. The value is our choice.
ROUNDING = 1e-12

# A scene counts as hardly moving if its largest kinetic energy is less than this fraction of the
# magnitude of the work of scripts.
STILL = 1e-3

# Width and height of a figure without its legend, and height of a row of the legend [inches].
SIZE = (8.0, 4.5)
LEGEND_ROW = 0.19

# Names of columns in legends. Other columns are shown by their own names.
WORDS = {
    "energy.kinetic": "kinetic energy of cloth",
    "energy.membrane": "membrane energy",
    "energy.bending": "bending energy",
    "energy.gravity": "gravitational energy of cloth",
    "energy.contact": "energy of contacts",
    "energy.body_kinetic": "kinetic energy of bodies",
    "energy.body_gravity": "gravitational energy of bodies",
    "energy.magnetic": "magnetic energy",
    "account.friction": "lost to friction",
    "account.damping": "lost to damping",
    "account.limits": "lost to strain limits",
    "account.withheld": "lost to impacts and withheld motion",
    "account.lost": "lost otherwise, mostly to damping of the integrator",
    "seconds.loads": "loads and scripts",
    "seconds.proximity": "search for contacts",
    "seconds.integrate": "integration of cloth",
    "seconds.bodies": "bodies and magnets",
    "seconds.limit": "strain limits",
    "seconds.certify": "certification",
    "seconds.check": "checks",
    "contacts.near": "contacts",
    "contacts.impacts": "impacts",
    "withheld.vertices": "vertices with withheld motion",
    "solver.linear_iterations": "linear iterations",
    "solver.newton_iterations": "Newton iterations",
}


@takes()
def plot_steps(
    steps: Steps, path: str | os.PathLike[str], *, kind: str = "energy", title: str = ""
) -> Path:
    """Plots columns of a table of steps over time; returns the path of the picture.

    steps : columns by name, as returned by loomstone.Run.steps
    path : path of the picture; its suffix selects the format, and is .png by default
    kind : energy, stages, contacts, stretch, strain, iterations or step
    title : title of the picture, for instance the name of the run

    Energies of at most 1e-12 of the largest and stages that take at most 0.1 % of the time of all
    stages are left out, and so are curves of contacts, strains and iterations that are always 0.

    Raises InvalidInput for an unknown kind, or for kind strain if the table lacks its columns,
    CacheError if the picture cannot be written, and Unsupported without matplotlib.
    """
    if kind not in KINDS:
        raise InvalidInput(f"plot must be one of {', '.join(KINDS)}, got {kind!r}")
    figure = new_figure(SIZE)
    axes = figure.add_subplot()
    _DRAW[kind](axes, steps)
    if title:
        figure.suptitle(plain(title), fontsize="medium", wrap=True)
    if not axes.lines and not axes.collections:
        axes.text(0.5, 0.5, "all values are 0", transform=axes.transAxes, ha="center")
    axes.set_xlabel("time [s]")
    axes.grid(alpha=0.3)
    _add_legend(figure, axes)
    return save_figure(figure, path, dpi=150)


def _add_legend(figure: Any, axes: Any) -> None:
    """Adds a legend below the axes, where it covers no curve, and makes the figure taller."""
    series = len(axes.get_legend_handles_labels()[0])
    if series == 0:
        return
    columns = 1 if series == 1 else 2
    width, height = SIZE
    figure.set_size_inches(width, height + LEGEND_ROW * -(-series // columns))
    figure.legend(loc="outside lower center", ncols=columns, fontsize="small")


def scale_of_gains(largest_kinetic: float, scripts: float) -> tuple[float, str]:
    """Returns the energy with which gains of energy are compared [J], and its name.

    It is the largest kinetic energy or, if this is below STILL times the magnitude of the work of
    scripts, this magnitude. In the second case, scripts press or stretch cloth that hardly moves.

    scripts : work of scripts [J]
    """
    if largest_kinetic < STILL * abs(scripts):
        return abs(scripts), "work of scripts"
    return largest_kinetic, "largest kinetic energy"


def _energy(axes: Any, steps: Steps) -> None:
    energies = {
        name.removeprefix("energy."): values
        for name, values in steps.items()
        if name.startswith("energy.")
    }
    least = ROUNDING * max(float(np.abs(values).max()) for values in energies.values())
    _lines(axes, steps, [f"energy.{name}" for name in energies], least)
    axes.plot(steps["time"], sum(energies.values()), "k", label="sum of energies")
    work = steps["account.scripts"] + steps["account.loads"]
    if work.any():
        axes.plot(steps["time"], work, "k:", label="work of scripts, air and external forces")
        axes.plot(steps["time"], sum(energies.values()) - work, "k--", label="sum minus work")
    losses = ("friction", "damping", "limits", "withheld", "lost")
    _lines(axes, steps, [f"account.{name}" for name in losses], least, linestyle=":")
    kinetic = steps["account.largest_kinetic"]
    if kinetic.any():
        scale, relative_to = scale_of_gains(kinetic.max(), steps["account.scripts"][-1])
        gain = steps["account.balance"] * kinetic / scale
        with_contacts = steps["account.contact_balance"] * kinetic / scale
        axes.set_title(
            f"rise of energy minus work: at most {gain.max():.1%} ({with_contacts.max():.1%}"
            f" with contacts), {gain[-1]:.1%} at the end,\nrelative to the {relative_to}",
            fontsize="small",
        )
    axes.set_ylabel("energy [J]")


def _lines(axes: Any, steps: Steps, names: list[str], least: float = 0.0, **style: Any) -> None:
    """Plots the columns whose magnitude exceeds `least` at some time, labelled as in WORDS."""
    for name in names:
        if np.abs(steps[name]).max() > least:
            axes.plot(steps["time"], steps[name], label=WORDS.get(name, name), **style)


def _stages(axes: Any, steps: Steps) -> None:
    names = [name for name in steps if name.startswith("seconds.")]
    total = sum(steps[name].sum() for name in names)
    names = [name for name in names if steps[name].sum() > LEAST_SHARE * total]
    milliseconds = [1e3 * steps[name] for name in names]
    axes.stackplot(steps["time"], milliseconds, labels=[WORDS.get(name, name) for name in names])
    axes.set_ylabel("wall time per step [ms]")


def _contacts(axes: Any, steps: Steps) -> None:
    _lines(axes, steps, ["contacts.near", "contacts.impacts", "withheld.vertices"])
    axes.set_ylabel("number [1]")


def _stretch(axes: Any, steps: Steps) -> None:
    axes.plot(steps["time"], steps["strain.stretch"])
    axes.set_ylabel("largest principal stretch [1]")


def _strain(axes: Any, steps: Steps) -> None:
    """Plots the largest weft, warp and shear strain, each with its largest excess over the limit.

    The number of sweeps of strain limiting is plotted on a second axis.
    """
    if "strain.weft" not in steps:
        raise InvalidInput(
            "the table of steps must have strains, but was written by an earlier version; run the"
            " scene again"
        )
    for name, color in (("weft", "C0"), ("warp", "C1"), ("shear", "C2")):
        if steps[f"strain.{name}"].any():
            axes.plot(steps["time"], steps[f"strain.{name}"], color, label=name)
        if steps[f"limits.{name}_excess"].any():
            axes.plot(
                steps["time"],
                steps[f"limits.{name}_excess"],
                color,
                linestyle=":",
                label=f"{name}, excess over the limit",
            )
    axes.set_ylabel("largest strain [1]")
    if steps["limits.sweeps"].any():
        right = axes.twinx()
        right.plot(steps["time"], steps["limits.sweeps"], "0.6", linewidth=0.8, zorder=0)
        right.set_ylabel("sweeps per step [1] (grey)")
        right.set_ylim(bottom=0)


def _iterations(axes: Any, steps: Steps) -> None:
    _lines(axes, steps, ["solver.linear_iterations", "solver.newton_iterations"])
    axes.set_ylabel("iterations per step [1]")


def _step(axes: Any, steps: Steps) -> None:
    axes.step(steps["time"], 1e3 * steps["length"], label="step", where="pre")
    if (steps["parts"] > 1).any():
        shortest = 1e3 * np.where(steps["parts"] > 1, steps["error.least_part"], np.nan)
        axes.plot(steps["time"], shortest, ".", label="shortest part of a step")
    axes.set_yscale("log")
    axes.set_ylabel("length [ms]")


_DRAW = {
    "energy": _energy,
    "stages": _stages,
    "contacts": _contacts,
    "stretch": _stretch,
    "strain": _strain,
    "iterations": _iterations,
    "step": _step,
}
