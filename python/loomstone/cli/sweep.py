"""The command loomstone sweep."""

from __future__ import annotations

import os
import shlex
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from .._core import InvalidInput
from ..ranks import processors_of_rank
from ..runs.frame_times import told_of_part_frame
from ..runs.scene_file import SceneFile
from ..runs.signals import Interrupted
from ..sweeps.earlier import with_earlier
from ..sweeps.engines import Command, on_dask, on_this_machine
from ..sweeps.plan import Point, claim, first_values, open_with, parse_values, points_of
from ..sweeps.point import finished
from ..sweeps.results import FIGURES, check_figures, plot_figures, write_table
from .application import app, command_line, session
from .given import check_given, integrator_of
from .options import SceneArgument

Values = Annotated[
    list[str],
    typer.Option(
        "-p",
        "--parameter",
        help="values of a parameter of scene(): name=a,b,c or name=first:last:count",
    ),
]


@app.command()
def sweep(
    scene: SceneArgument,
    p: Values = [],  # noqa: B006
    out: Annotated[
        Path | None, typer.Option(help="directory of all runs; default: out/NAME-sweep")
    ] = None,
    duration: Annotated[float | None, typer.Option(help="simulated time of each run [s]")] = None,
    rate: Annotated[float | None, typer.Option(help="frames per second of simulated time")] = None,
    step: Annotated[str | None, typer.Option(help="time step [s], or auto")] = None,
    integrator: Annotated[str | None, typer.Option(help="as in loomstone run")] = None,
    threads: Annotated[int, typer.Option(help="number of threads of each run", min=1)] = 1,
    jobs: Annotated[
        int, typer.Option(help="number of simultaneous runs; 0: processors / --threads", min=0)
    ] = 0,
    scheduler: Annotated[
        str | None,
        typer.Option(help="address or file of a Dask scheduler, whose workers run the scene"),
    ] = None,
    plot: Annotated[
        list[str], typer.Option(help="name of a value in the report to plot; may be repeated")
    ] = list(FIGURES),  # noqa: B006
) -> None:
    """Runs a scene for all combinations of parameters.

    Each run has a directory of its own in --out. table.csv has the parameters of each finished run
    and numbers from its report; figures.png plots some of these numbers. Both include runs of
    earlier sweeps in --out. If a sweep is interrupted, the same command continues it: finished runs
    are kept, and the other runs are resumed or started. More values may be added. The exit code is
    1 if a run fails; the output of each run is in its log.txt. docs/cluster.md describes how to run
    a sweep on a cluster.

    \b
        loomstone sweep scenes/twist.py -p triangles=800,3200 -p friction=0.1:0.5:5 --out out/sweep
    """
    with session(parallel=False):
        given = _given(duration=duration, rate=rate, step=step, integrator=integrator)
        with command_line():
            check_figures(plot)
        target = out or Path("out") / f"{scene.stem}-sweep"
        file, values = _read_values(scene, p)
        points = points_of(values, scene, target)
        _begin(file, target, given, scheduler)
        arguments = [str(scene.resolve())]
        for name, value in given.items():
            arguments += [] if value is None else [f"--{name}", str(value)]
        command = Command(arguments, ["--threads", str(threads)])
        left = [point for point in points if not finished(point.directory)]
        print(f"{len(points)} runs in {target}, {len(points) - len(left)} finished", flush=True)
        if scheduler:
            ends = on_dask(left, command, scheduler)
        else:
            ends = on_this_machine(left, command, jobs or max(1, processors_of_rank() // threads))
        shown = with_earlier(points, file, target)
        failed = _follow(ends, shown, len(left), target)
        _show(shown, len(points), plot, target)
        _tell(failed)
        if failed:
            raise typer.Exit(1)


def _given(**options: Any) -> dict[str, Any]:
    """Checks and returns the options that all runs have in common."""
    check_given(**options)
    return options


def _tell(failed: list[tuple[Point, int]]) -> None:
    for point, code in failed:
        print(f"failed with exit code {code}: {point.directory / 'log.txt'}")


def _read_values(scene: Path, p: list[str]) -> tuple[SceneFile, dict[str, list[Any]]]:
    """Returns the scene file, opened with the first value of each parameter, and all values."""
    with command_line():
        try:
            first = {name: each[0] for name, each in parse_values(p).items()}
        except InvalidInput as refused:
            if (file := _with_texts(scene, p)) is None:
                raise refused
            return file, parse_values(p, file.texts)
    file = open_with(scene, first)
    return file, parse_values(p, file.texts)


def _with_texts(scene: Path, p: list[str]) -> SceneFile | None:
    """Opens a scene with the first value of each parameter; an invalid range counts as a string.

    Returns None if the scene refuses these values.
    """
    try:
        return open_with(scene, first_values(p))
    except InvalidInput:
        return None


def _begin(file: SceneFile, target: Path, given: dict[str, Any], scheduler: str | None) -> None:
    """Checks the options of a sweep, and makes its directory (see claim() in sweeps/plan.py).

    Prints a message if the duration is not a whole number of frames.
    """
    integrator_of(file, given["integrator"], given["step"])
    claim(target, {"scene": file.source, **given}, besides=Path(scheduler or "").name)
    duration = file.duration if given["duration"] is None else given["duration"]
    if told := told_of_part_frame(duration, file.rate if given["rate"] is None else given["rate"]):
        print(told)


def _show(points: list[Point], n_own: int, plot: list[str], target: Path) -> None:
    """Writes the table and the plots.

    points : combinations of parameters; those after the first `n_own` belong to earlier sweeps
    """
    rows, earlier = write_table(points, target / "table.csv"), len(points) - n_own
    told = f", {earlier} of them of earlier sweeps" if earlier else ""
    print(f"table: {target / 'table.csv'} ({len(rows)} runs{told})")
    if picture := plot_figures(rows, points, plot, target / "figures.png"):
        print(f"plots: {picture}")


def _follow(
    ends: Iterator[tuple[Point, int]], points: list[Point], n_left: int, target: Path
) -> list[tuple[Point, int]]:
    """Prints a line for each run that ends, and updates the table.

    Returns the point (combination of parameters) and the exit code of each run that failed.

    If `ends` raises Interrupted, raises typer.Exit with 128 plus the number of the signal.
    """
    failed: list[tuple[Point, int]] = []
    began, done = time.perf_counter(), 0
    try:
        for point, code in ends:
            done += 1
            if code:
                failed.append((point, code))
            write_table(points, target / "table.csv")
            left = (time.perf_counter() - began) / done * (n_left - done)
            print(f"{done}/{n_left}  {point.name}  {_said(point, code)}  left {left:.0f} s",
                  flush=True)  # fmt: skip
    except Interrupted as stop:
        print(f"stopped by {stop}; continue with: {_again()}")
        raise typer.Exit(128 + stop.signal) from None
    return failed


def _said(point: Point, code: int) -> str:
    report: dict[str, Any] = finished(point.directory) or {}
    if code or "wall_seconds" not in report:
        return f"exit code {code}"
    said = f"{report['wall_seconds']:.1f} s"
    if "largest_stretch" in report:  # absent without steps
        said += f", largest stretch {report['largest_stretch']:.3f}"
    return said


def _again() -> str:
    return shlex.join([os.path.basename(sys.argv[0]), *sys.argv[1:]])
