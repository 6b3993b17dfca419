"""The commands loomstone run and loomstone resume."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from .. import _core
from .._core import Communicator
from ..integrators import METHODS, Integrator, parse_step, step_text, with_method
from ..pictures.directory import drawn_with
from ..runs.cache import Run
from ..runs.execution import execute
from ..runs.frame_times import frame_count
from ..runs.options import RunOptions
from ..runs.progress import observer
from ..runs.scene_file import SceneFile, parse_parameters, stored_options
from ..runs.signals import Interrupted
from ..simulation import Simulation
from .application import app, session
from .inspection import report_text
from .options import Parameters, Render, RunArgument, SceneArgument, Threads, Trust


@app.command()
def run(
    scene: SceneArgument,
    out: Annotated[
        Path | None,
        typer.Option(help="directory for the results; default: out/NAME of the scene file"),
    ] = None,
    p: Parameters = [],  # noqa: B006
    duration: Annotated[
        float | None, typer.Option(help="simulated time [s]; default: that of the scene file")
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(help="frames per second of simulated time; default: that of the scene file"),
    ] = None,
    step: Annotated[
        str | None, typer.Option(help="time step [s], or auto; default: that of the scene file")
    ] = None,
    integrator: Annotated[str | None, typer.Option(help=" | ".join(sorted(METHODS)))] = None,
    threads: Threads = 0,
    render: Render = False,
    verify: Annotated[
        bool, typer.Option("--verify", help="count intersecting triangles of every frame exactly")
    ] = False,
    compression: Annotated[
        int, typer.Option(help="compression of the frames, 0: none, to 9", min=0, max=9)
    ] = 0,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing run")] = False,
) -> None:
    """Simulates a scene.

    Writes run.vtkhdf and bodies.vtkhdf (for ParaView), checkpoints, steps.csv and report.json.
    --render adds frames/*.png and video.mp4. --verify adds frames.csv, and the exit code is 1 if
    triangles of cloth intersect. After Ctrl-C, SIGTERM, SIGUSR1 or a crash, `loomstone resume`
    continues the run with a bit-identical result. On several ranks: mpirun -n 2 loomstone run
    scene.py.

    \b
        loomstone run scenes/drape.py -p triangles=3600 --duration 0.5 --threads 2 --render
    """
    with session() as communicator:
        file = SceneFile.open(scene, parse_parameters(p))
        options = (
            file.integrator
            if integrator is None
            else with_method(file.integrator, integrator, "--integrator")
        )
        if step is not None:
            options = options.replace(step=parse_step(step))
        duration = file.duration if duration is None else duration
        rate = file.rate if rate is None else rate
        frame_count(duration, rate)
        look = file.render if render else None
        directory = out or Path("out") / scene.stem
        settings = RunOptions(duration, rate, look, verify, compression)
        task = _Task(file, options, settings, directory, threads, overwrite=overwrite)
        _advance(task, communicator)


@app.command()
def resume(
    run: RunArgument, threads: Threads = 0, render: Render = False, trust: Trust = False
) -> None:
    """Continues a run that was interrupted or killed, with a bit-identical result.

    Scene, parameters and options are those with which the run began; threads and ranks may differ.
    If frames/ contains pictures, drawing continues with their options. If it contains none,
    --render starts drawing. Missing pictures are drawn at the end.

    A run contains the program of its scene file. It runs if it equals the scene file at hand, or
    with --trust: a run from a stranger contains his program.

    \b
        loomstone resume out/drape
    """
    with session() as communicator:
        begun = Run(run)
        file = SceneFile.of_run(begun, trust=trust)
        duration, rate, options, look = stored_options(begun)
        looks = drawn_with(run / "frames") or (look if render else None)
        del begun
        verify = (run / "frames.csv").exists()
        settings = RunOptions(duration, rate, looks, verify)
        _advance(_Task(file, options, settings, run, threads, resume=True), communicator)


@dataclass(frozen=True)
class _Task:
    """A run to be executed, with its scene file, options and target directory."""

    file: SceneFile
    integrator: Integrator
    options: RunOptions
    directory: Path
    threads: int
    overwrite: bool = False
    resume: bool = False


def _advance(task: _Task, communicator: Communicator) -> None:
    """Runs a task.

    Exits with code 1 if triangles intersect, or with 128 plus the number of the signal that ended
    the run.
    """
    # Ranks on the same node share its processors.
    share = int(os.environ.get("OMPI_COMM_WORLD_LOCAL_SIZE", "1"))
    threads = task.threads or max(1, _core.default_thread_count() // share)
    file, options, rank = task.file, task.options, communicator.rank
    simulation = Simulation(
        file.scene(), integrator=task.integrator, threads=threads, communicator=communicator
    )
    say: Callable[..., None] = print if rank == 0 else (lambda *_: None)
    say(
        f"{simulation!r}, {step_text(task.integrator)}, {simulation.threads} threads,"
        f" {simulation.ranks} ranks"
    )
    try:
        report = execute(
            simulation,
            options,
            task.directory,
            metadata=file.metadata(options.duration, options.rate, task.integrator, file.render),
            overwrite=task.overwrite,
            resume=task.resume,
            control=file.control,
            observer=observer(rank),
        )
    except Interrupted as stop:
        say(
            f"stopped by {stop} at {simulation.time:.3f} s; continue with: loomstone resume"
            f" {task.directory}"
        )
        raise typer.Exit(128 + stop.signal) from None
    say(report_text(report))
    say(f"frames: {task.directory / 'run.vtkhdf'}")
    if options.render:
        say(
            f"pictures: {task.directory / 'frames'}\n"
            f"video: {report.get('video', 'none: the options of frames/ changed during the run')}"
        )
    if report.get("intersecting_frames"):
        raise typer.Exit(1)
