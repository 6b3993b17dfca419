"""The commands loomstone run and loomstone resume."""

from __future__ import annotations

import os
import platform
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from .._core import Communicator, InvalidInput
from ..integrators import METHODS, Integrator, step_text
from ..pictures.directory import drawn_with
from ..ranks import default_threads
from ..runs.cache import Run
from ..runs.execution import execute
from ..runs.frame_times import frame_count, told_of_part_frame
from ..runs.lock import check_unlocked
from ..runs.options import RunOptions
from ..runs.parameters import given_parameters
from ..runs.scene_file import SceneFile, stored_options
from ..runs.signals import Interrupted
from ..runs.stored_scene import StoredScene, begun_in_python
from ..runs.writer import check_room
from ..simulation import Simulation
from .application import app, command_line, session
from .estimate import memory_text
from .given import check_decomposition, check_given, integrator_of
from .inspection import report_text
from .options import (
    AsJson,
    Decomposition,
    Parameters,
    Quiet,
    RecordTasks,
    Render,
    RunArgument,
    SceneArgument,
    StoredDecomposition,
    StoredRecordTasks,
    Threads,
    Trust,
    one_of,
)
from .words import Words

Duration = Annotated[
    float | None, typer.Option(help="simulated time [s]; default: that of the scene file")
]
LongerDuration = Annotated[
    float | None,
    typer.Option("--duration", help="longer simulated time [s], which extends the run"),
]
Rate = Annotated[
    float | None,
    typer.Option(help="frames per second of simulated time; default: that of the scene file"),
]
Step = Annotated[
    str | None, typer.Option(help="time step [s], or auto; default: that of the scene file")
]
Method = Annotated[
    str | None, typer.Option(help=" | ".join(sorted(METHODS)), autocompletion=one_of(METHODS))
]
Verify = Annotated[
    bool, typer.Option("--verify", help="count intersecting triangles of every frame exactly")
]
Compression = Annotated[
    int, typer.Option(help="compression of the frames, 0: none, to 9", min=0, max=9)
]
Overwrite = Annotated[
    bool,
    typer.Option(
        "--overwrite",
        help="replace an existing run, or write into a directory with other files, which are kept",
    ),
]


@app.command()
def run(
    scene: SceneArgument,
    out: Annotated[
        Path | None,
        typer.Option(help="directory for the results; default: out/NAME of the scene file"),
    ] = None,
    p: Parameters = [],  # noqa: B006
    duration: Duration = None,
    rate: Rate = None,
    step: Step = None,
    integrator: Method = None,
    threads: Threads = 0,
    decomposition: Decomposition = "predicted",
    record_tasks: RecordTasks = 0,
    render: Render = False,
    verify: Verify = False,
    compression: Compression = 0,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Simulates a scene.

    Writes run.vtkhdf and, if there are bodies or obstacles, bodies.vtkhdf (both for ParaView).
    Also writes checkpoints, steps.csv and report.json.
    --render adds frames/*.png and video.mp4. --verify adds frames.csv, and the exit code is 1 if
    triangles of cloth intersect. After Ctrl-C, SIGTERM, SIGUSR1 or a crash, `loomstone resume`
    continues the run with a bit-identical result. On several ranks: mpirun -n 2 loomstone run
    scene.py; srun and exit codes: docs/cluster.md.

    \b
        loomstone run scenes/drape.py -p triangles=3600 --duration 0.5 --threads 2 --render
    """
    with (
        session() as communicator,
        Words(communicator.rank, quiet=quiet, as_json=as_json) as words,
    ):
        words.say(f"reading {scene}")
        check_given(duration=duration, rate=rate, step=step, integrator=integrator)
        check_decomposition(decomposition)
        with command_line():
            given = given_parameters(p)
        file = SceneFile.open(scene, given)
        options = integrator_of(file, integrator, step)
        duration = file.duration if duration is None else duration
        rate = file.rate if rate is None else rate
        if told := told_of_part_frame(duration, rate):
            words.insist(told)
        look = file.render if render else None
        directory = out or Path("out") / scene.stem
        if communicator.rank == 0:
            check_unlocked(directory)
            check_room(directory, overwrite)
        settings = RunOptions(duration, rate, look, verify, record_tasks, compression)
        metadata = file.metadata(duration, rate, options, file.render)
        work = _Work(threads, decomposition)
        task = _Task(file, options, settings, directory, work, metadata, overwrite)
        _advance(task, communicator, words)


@app.command()
def resume(
    run: RunArgument,
    duration: LongerDuration = None,
    threads: Threads = 0,
    decomposition: StoredDecomposition = None,
    record_tasks: StoredRecordTasks = None,
    render: Render = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
    trust: Trust = False,
) -> None:
    """Continues a run that was interrupted or killed, or extends one, with a bit-identical result.

    Scene, parameters and options are those with which the run began, unless other options are
    given here. The number of ranks may differ.
    --duration extends a run, finished or not, to a longer simulated time.
    If frames/ contains pictures, drawing continues with their options. If it contains none,
    --render starts drawing. Missing pictures are drawn at the end.

    A run contains the program of its scene file. This program is executed only if the scene file
    at its original path equals it, or if --trust is given. The program of a run from a stranger can
    do anything that you can do.

    \b
        loomstone resume out/drape --duration 2
    """
    with (
        session() as communicator,
        Words(communicator.rank, quiet=quiet, as_json=as_json) as words,
    ):
        check_given(duration=duration)
        if decomposition is not None:
            check_decomposition(decomposition)
        if communicator.rank == 0:
            check_unlocked(run if run.is_dir() else run.parent)
        begun = Run(run)
        run, kept = begun.directory, begun.metadata
        file: SceneFile | StoredScene
        if begun_in_python(kept):
            file = StoredScene(run, kept)
        else:
            file = SceneFile.of_run(begun, trust=trust)
        before, rate, options, look = stored_options(begun)
        duration = before if duration is None else _longer(duration, run, before, rate, words)
        looks = drawn_with(run / "frames") or (look if render else None)
        del begun
        if record_tasks is None:
            record_tasks = kept.get("record_tasks", 0)
        if decomposition is None:
            decomposition = kept.get("decomposition", "predicted")
        verify = (run / "frames.csv").exists()
        settings = RunOptions(duration, rate, looks, verify, record_tasks)
        _advance(
            _Task(file, options, settings, run, _Work(threads, decomposition)), communicator, words
        )


def _longer(duration: float, run: Path, before: float, rate: float, words: Words) -> float:
    """Returns the duration [s] to which a run is extended: the larger of `duration` and `before`.

    Raises InvalidInput if `duration` gives fewer frames than `before`, or if the run belongs to a
    sweep. Prints a message if `duration` is not a whole number of frames.

    run : directory of the run
    before : duration that the run had until now [s]
    """
    if (run.absolute().parent / "sweep.json").exists():
        raise InvalidInput(
            f"{run} belongs to a sweep, whose runs have the same duration; copy it to another"
            " directory to extend it"
        )
    if frame_count(duration, rate) < frame_count(before, rate):
        raise InvalidInput(
            f"--duration must be at least that of the run, {before:.9g} s, got {duration:.9g} s"
        )
    if told := told_of_part_frame(duration, rate):
        words.insist(told)
    return max(duration, before)


@dataclass(frozen=True)
class _Work:
    """How a run is divided among threads and ranks."""

    threads: int
    decomposition: Any  # name of a decomposition; Simulation checks it


@dataclass(frozen=True)
class _Task:
    """A run to be executed, with its scene, options and target directory.

    metadata : metadata of a new run; None: the run is resumed
    """

    file: SceneFile | StoredScene
    integrator: Integrator
    options: RunOptions
    directory: Path
    work: _Work
    metadata: dict[str, Any] | None = None
    overwrite: bool = False


def _place(threads: int) -> str:
    """Returns a text with the host, threads and processors of this rank."""
    allowed, n_processors = sorted(os.sched_getaffinity(0)), os.cpu_count() or 1
    where = f"bound to processors {','.join(map(str, allowed))} of {n_processors}"
    if len(allowed) == n_processors:
        where = f"not bound, {n_processors} processors"
    return f"host {platform.node()}, {threads} threads, {where}"


def _advance(task: _Task, communicator: Communicator, words: Words) -> None:
    """Executes the run that a task describes.

    Exits with code 1 if the run is verified and triangles of cloth intersect. If a signal ends the
    run, exits with 128 plus the number of the signal.
    """
    threads = task.work.threads or default_threads()
    scene = task.file.scene()
    words.say(memory_text(scene, task.integrator))
    simulation = Simulation(
        scene,
        integrator=task.integrator,
        threads=threads,
        communicator=communicator,
        decomposition=task.work.decomposition,
    )
    words.say(
        f"{simulation!r}, {step_text(task.integrator)}, {simulation.threads} threads,"
        f" {simulation.ranks} ranks"
    )
    if communicator.size > 1:
        for rank, place in enumerate(communicator.gather(_place(simulation.threads))):
            words.say(f"rank {rank}: {place}")
    way_on = f"continue with: loomstone resume {shlex.quote(str(task.directory))}"
    try:
        report = execute(
            simulation,
            task.options,
            task.directory,
            metadata=task.metadata,
            overwrite=task.overwrite,
            resume=task.metadata is None,
            control=task.file.control,
            observer=words.observer(),
            farewell=way_on,
        )
    except Interrupted as stop:
        words.insist(f"stopped by {stop} at {simulation.time:.3f} s; {way_on}")
        raise typer.Exit(128 + stop.signal) from None
    _conclude(task, report, words)
    if report.get("intersecting_frames"):
        raise typer.Exit(1)


def _conclude(task: _Task, report: dict[str, Any], words: Words) -> None:
    """Prints the report of a run, and where its files are."""
    frames = task.directory / "run.vtkhdf"
    words.say(report_text(report))
    words.say(f"frames: {frames}")
    if task.options.render:
        words.say(
            f"pictures: {task.directory / 'frames'}\n"
            f"video: {report.get('video', 'none: the options of frames/ changed during the run')}"
        )
    words.json({"directory": str(task.directory), "run": str(frames), **report})
