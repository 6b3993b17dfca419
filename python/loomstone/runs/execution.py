"""Runs a simulation into a directory, so that it can be killed at any moment and resumed bit for
bit.

Frames are flushed as they are written; the checkpoint follows its frame. Resuming drops what is
later than the newest checkpoint and computes it again.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from .. import _core
from .._core import CacheError, Checkpoint, Error, Frame, FrameWriter, RenderOptions, StepReport
from .cache import Run, checkpoint_files, latest_checkpoint, write_checkpoint
from ..ranks import together
from ..simulation import Simulation, frame_count, frames_due
from .tables import read_table
from .verification import BROKEN, FORCED, MOST_BROKEN, FrameTable, append_rows, keep_rows
from ..pictures.drawing import Painter, claim, colours_need_all_frames, drawn_with, encode, picture, render_run

# [s] that a run goes on after a signal to reach a step that can be saved; our choice, below usual
# grace periods
LONGEST_WAIT = 10.0

__all__ = ["Interrupted", "Observer", "RunOptions", "StepTable", "execute", "summary_of_steps"]


class Interrupted(Exception):
    """A signal ended the run; it can be resumed."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.signal = number


@dataclass(frozen=True)
class RunOptions:
    """duration [s], rate [1/s], how pictures look, exact count of intersections in every frame.

    Pictures are drawn while it runs, but at its end where their colours span the values of all
    frames.
    """

    duration: float
    rate: float = 25.0
    render: RenderOptions | None = None
    verify: bool = False


class Observer(Protocol):
    """Who is told how far a run is."""

    def start(self, frames: int, done: int) -> None: ...
    def step(self, report: StepReport) -> None: ...
    def frame(self, index: int, frame: Frame) -> None: ...
    def end(self) -> None: ...


class Silence:
    """An observer that says nothing."""

    def start(self, frames: int, done: int) -> None: ...
    def step(self, report: StepReport) -> None: ...
    def frame(self, index: int, frame: Frame) -> None: ...
    def end(self) -> None: ...


def execute(
    simulation: Simulation,
    options: RunOptions,
    out: str | os.PathLike[str],
    *,
    metadata: dict[str, Any] | None = None,
    overwrite: bool = False,
    resume: bool = False,
    control: Callable[[Simulation], None] | None = None,
    observer: Observer | None = None,
) -> dict[str, Any]:
    """Advances to the end and returns the report. Every rank calls it; rank 0 writes."""
    directory, watch, ranks = Path(out), observer or Silence(), simulation.communicator
    n_frames = frame_count(options.duration, options.rate)
    with together(ranks):
        if resume and (checkpoint := latest_checkpoint(directory)):
            simulation.restore(checkpoint)
    following = frames_due(simulation.time, options.rate) if simulation.step_index else 0
    with together(ranks):
        writer = _writer(
            simulation, options, directory, metadata or {}, overwrite, resume, following
        )
    began, first_step = time.perf_counter(), simulation.step_index
    watch.start(n_frames, following)
    with _signals() as received, writer:
        unsaved = stepped = False
        while True:
            with together(ranks):
                if stepped:
                    writer.step(
                        simulation.report, simulation.forced_pairs, simulation.broken_limits
                    )
                    watch.step(simulation.report)
                while following < n_frames and following < frames_due(
                    simulation.time, options.rate
                ):
                    frame = simulation.frame_at(following / options.rate)
                    writer.frame(following, frame)
                    watch.frame(following, frame)
                    following, unsaved = following + 1, True
            finished = following >= n_frames
            number = simulation.agree(received.number)
            if (unsaved or number) and simulation.may_checkpoint:
                state = simulation.checkpoint()
                with together(ranks):
                    writer.checkpoint(simulation.step_index, state)
                unsaved = False
            if finished:
                break
            if number and not unsaved and simulation.may_checkpoint:
                watch.end()
                raise Interrupted(number)
            if number and simulation.agree(
                received.waited() >= LONGEST_WAIT
            ):  # resuming takes the last checkpoint
                watch.end()
                raise Interrupted(number)
            if control:
                with together(ranks):
                    control(simulation)
            simulation.step()
            stepped = True
        watch.end()
        with together(ranks):
            drawn = writer.draw_rest(lambda: received.number != 0)
        if number := simulation.agree(0 if drawn else received.number):
            raise Interrupted(number)
        report = {
            "frames": n_frames,
            "steps": simulation.step_index,
            "time": simulation.time,
            "wall_seconds": time.perf_counter() - began,
            "steps_of_this_process": simulation.step_index - first_step,
            "threads": simulation.threads,
            "ranks": simulation.ranks,
            "digest": simulation.digest(),
        }
        with together(ranks):
            report = writer.finish(report)
        return report


class StepTable:
    """steps.csv: one row a step."""

    def __init__(self, path: Path, until_step: int) -> None:
        kept: list[list[str]] = []
        if path.exists() and until_step > 0:
            kept = [row for row in read_table(path, "step")[1] if int(row[0]) <= until_step]
        self._path, self._file = path, path.open("w", newline="")
        self._table = csv.writer(self._file)
        self._table.writerow([*self._row(StepReport())])
        self._table.writerows(kept)

    @staticmethod
    def _row(report: StepReport) -> dict[str, Any]:
        row = report.to_dict()
        seconds = row.pop("seconds")
        return row | {f"seconds_{name}": value for name, value in seconds.items()}

    def add(self, report: StepReport) -> None:
        self._table.writerow(self._row(report).values())

    def flush(self) -> None:
        self._file.flush()

    def close(self) -> None:
        self._file.close()

    def summary(self) -> dict[str, Any]:
        """Totals and extremes over all steps of the run."""
        self.flush()
        return summary_of_steps(self._path)


def summary_of_steps(path: Path) -> dict[str, Any]:
    """Totals and extremes over all steps of a steps.csv."""
    header, lines = read_table(path, "step")
    rows = [dict(zip(header, line, strict=True)) for line in lines]
    if not rows:
        return {}
    wanted = sum(float(r["wanted_motion"]) for r in rows)
    squares = [
        float(r["contact_acceleration"]) ** 2
        for r in rows
        if float(r["contact_acceleration"]) > 0.0
    ]
    stages = [name for name in rows[0] if name.startswith("seconds_")]
    return {
        "seconds_per_stage": {
            s.removeprefix("seconds_"): sum(float(r[s]) for r in rows) for s in stages
        },
        "linear_iterations_per_step": sum(int(r["linear_iterations"]) for r in rows) / len(rows),
        "most_contacts": max(int(r["contacts"]) for r in rows),
        "impacts": sum(int(r["impacts"]) for r in rows),
        "truncated": sum(int(r["truncated"]) for r in rows),
        "steps_in_parts": sum(int(r["substeps"]) > 1 for r in rows),
        "unresolved_steps": sum(int(r["unresolved"]) > 0 for r in rows),
        "most_intersections": max(int(r["intersections"]) for r in rows),
        "forced_steps": sum(int(r["forced"]) > 0 for r in rows),
        "most_forced": max(int(r["forced"]) for r in rows),
        "limit_sweeps_per_step": sum(int(r["limit_sweeps"]) for r in rows) / len(rows),
        "largest_excess": max(
            float(r[f"{d}_excess"]) for r in rows for d in ("weft", "warp", "shear")
        ),
        "steps_with_broken_limits": sum(int(r["broken_limits"]) > 0 for r in rows),
        "most_broken_limits": max(int(r["broken_limits"]) for r in rows),
        "most_limit_rounds": max(int(r["limit_rounds"]) for r in rows),
        "limit_retreats": sum(int(r["limit_retreats"]) for r in rows),
        "withheld": sum(float(r["withheld_motion"]) for r in rows) / wanted if wanted else 0.0,
        "withheld_in_worst_step": max(float(r["withheld"]) for r in rows),
        "truncated_momentum": sum(float(r["truncated_momentum"]) for r in rows),
        "contact_acceleration": (sum(squares) / len(squares)) ** 0.5 if squares else 0.0,
        "largest_stretch": max(float(r["max_stretch"]) for r in rows),
        "energy_at_end": {k: float(rows[-1][k]) for k in rows[0] if k.endswith("_energy")},
    }


class _NoWriter:
    """Ranks other than 0 write nothing; they take part in what is collective."""

    def __enter__(self) -> _NoWriter:
        return self

    def __exit__(self, *_: object) -> None: ...

    def frame(self, index: int, frame: Frame) -> None: ...

    def step(
        self, report: StepReport, forced: list[list[int]], broken: list[tuple[int, str, float]]
    ) -> None: ...

    def checkpoint(self, step: int, state: Checkpoint) -> None: ...

    def draw_rest(self, stop: Callable[[], bool]) -> bool:
        return True

    def finish(self, report: dict[str, Any]) -> dict[str, Any]:
        return report


class _Writer(_NoWriter):
    def __init__(
        self,
        directory: Path,
        frames: FrameWriter,
        steps: StepTable,
        checks: FrameTable | None,
        options: RunOptions,
        simulation: Simulation,
        painter: Painter | None,
    ) -> None:
        self._directory, self._frames, self._steps, self._checks, self._options = (
            directory,
            frames,
            steps,
            checks,
            options,
        )
        self._simulation, self._painter = simulation, painter

    def __exit__(self, *failure: object) -> None:
        try:
            self._steps.close()
        except OSError:
            if failure[0] is None:  # else what ended the run is told already
                raise

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """A file that cannot be written is one clear error that says how to go on."""
        try:
            yield
        except OSError as error:
            told = (
                str(error)
                if isinstance(error, Error)
                else f"{self._directory}: could not write: {error.strerror}"
            )
            raise CacheError(
                f"{told.rstrip('.')}; the {self._frames.n_frames} frames before are kept: "
                f"make room and continue with loomstone resume {self._directory}"
            ) from error

    def frame(self, index: int, frame: Frame) -> None:
        with self._writing():
            self._frames.write(frame)
            if self._checks:
                self._checks.add(index, frame)
            if self._painter and self._draws():
                self._painter.draw(
                    picture(self._directory / "frames", self._frames.n_frames - 1), frame
                )

    def step(
        self, report: StepReport, forced: list[list[int]], broken: list[tuple[int, str, float]]
    ) -> None:
        with self._writing():
            self._steps.add(report)
            if forced:
                append_rows(self._directory / FORCED[0], FORCED[1], report.step, forced)
            if broken:
                append_rows(
                    self._directory / BROKEN[0], BROKEN[1], report.step, broken[:MOST_BROKEN]
                )

    def checkpoint(self, step: int, state: Checkpoint) -> None:
        with self._writing():
            self._steps.flush()
            write_checkpoint(self._directory, step, state)

    def _draws(self) -> bool:
        """Pictures are asked for, and nobody has given their directory other options meanwhile."""
        return (
            self._options.render is not None
            and drawn_with(self._directory / "frames") == self._options.render
        )

    def draw_rest(self, stop: Callable[[], bool]) -> bool:
        """Draws from the cache what has no picture yet; False where that was stopped."""
        options = self._options.render
        if options is None or not self._draws():
            return True
        if not colours_need_all_frames(options):
            drawn = (
                picture(self._directory / "frames", i).exists()
                for i in range(self._frames.n_frames)
            )
            if all(drawn):
                return True
        with self._writing():
            paths = render_run(
                Run(self._directory), options, jobs=1, stop=stop, simulation=self._simulation
            )
        return all(path.exists() for path in paths)

    def finish(self, report: dict[str, Any]) -> dict[str, Any]:
        with self._writing():
            report = report | self._steps.summary()
            if self._checks:
                report = report | self._checks.summary()
        if self._draws():
            target = self._directory / "video.mp4"
            report["video"] = encode(
                self._directory / "frames",
                target,
                frames=self._frames.n_frames,
                rate=self._options.rate,
            )
        with self._writing():
            text = json.dumps(report, indent=1)
            (self._directory / "report.json").write_text(text + "\n")
        return report


def _writer(
    simulation: Simulation,
    options: RunOptions,
    directory: Path,
    metadata: dict[str, Any],
    overwrite: bool,
    resume: bool,
    following: int,
) -> _NoWriter:
    if simulation.rank != 0:
        return _NoWriter()
    renderer = _core.Renderer(simulation.topology, options.render) if options.render else None
    first, text = None, json.dumps(metadata)
    if resume:
        _check_rate(directory, options.rate)
        if options.render:
            begun = Run(directory)
            text, first = begun.metadata_text, begun[0] if following else None
            claim(
                directory / "frames",
                options.render,
                text,
                advice="move it away, and resuming draws all anew",
            )
            del begun
        frames = FrameWriter.reopen(str(directory), (following - 0.5) / options.rate)
    else:
        if (directory / "run.vtkhdf").exists():
            if not overwrite:
                raise CacheError(
                    f"{directory} must hold no run yet, but has run.vtkhdf; resume it, give another"
                    " directory, or overwrite"
                )
            _remove_run(directory)
        try:
            directory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CacheError(
                f"{directory} must be a directory that can be written: {error.strerror}; give"
                " another"
            ) from error
        if options.render:
            claim(
                directory / "frames",
                options.render,
                text,
                again=overwrite,
                advice="give another directory, or overwrite",
            )
        frames = FrameWriter(str(directory), simulation.topology, text)
    steps = StepTable(directory / "steps.csv", simulation.step_index)
    for name, _ in (FORCED, BROKEN):
        keep_rows(directory / name, simulation.step_index)
    checks = (
        FrameTable(directory / "frames.csv", simulation.topology, following)
        if options.verify
        else None
    )
    painter = None
    if renderer and options.render and not colours_need_all_frames(options.render):
        painter = Painter(
            renderer, first=first, lines=options.render.field_lines, simulation=simulation
        )
    return _Writer(directory, frames, steps, checks, options, simulation, painter)


def _check_rate(directory: Path, rate: float) -> None:
    """Frames of a run are 1/rate apart."""
    times = Run(directory).times
    if len(times) > 1 and abs(times[1] * rate - 1.0) > 1e-6:
        raise CacheError(
            f"{directory}: rate must be that of the run, {1.0 / times[1]:.9g} frames/s, got"
            f" {rate:g}; resume with it, or give another directory"
        )


def _remove_run(directory: Path) -> None:
    """Removes what a run has written, and nothing else."""
    for name in (
        "run.vtkhdf",
        "bodies.vtkhdf",
        "steps.csv",
        "frames.csv",
        "forced.csv",
        "limits.csv",
        "report.json",
        "video.mp4",
    ):
        (directory / name).unlink(missing_ok=True)
    for path in checkpoint_files(directory):
        path.unlink()
    if (directory / "frames").is_dir() and not (directory / "frames").is_symlink():
        shutil.rmtree(directory / "frames")


class _Received:
    number, when = 0, 0.0

    def waited(self) -> float:
        """Seconds since the signal."""
        return time.monotonic() - self.when if self.number else 0.0


@contextmanager
def _signals() -> Iterator[_Received]:
    """Notes SIGINT, SIGTERM and SIGUSR1; the run looks at the note between two steps.

    A second SIGINT ends at once.
    """
    received = _Received()

    def note(number: int, _: Any) -> None:
        if received.number and number == signal.SIGINT:
            raise KeyboardInterrupt
        if not received.number:
            received.when = time.monotonic()
        received.number = number

    try:
        before = {
            n: signal.signal(n, note) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
        }
    except ValueError:  # not the main thread: whoever owns it handles signals
        yield received
        return
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
