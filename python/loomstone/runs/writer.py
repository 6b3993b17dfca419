"""Writes the files of a run: frames, steps, checkpoints, pictures and a report."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .. import _core
from .._core import (
    CacheError,
    Checkpoint,
    Error,
    Frame,
    FrameWriter,
    StepReport,
)
from ..pictures.directory import (
    claim,
    drawn_with,
    is_whole,
    make_directory,
    picture,
    remove_pictures,
)
from ..pictures.drawing import render_run
from ..pictures.painter import Painter, needs_all_frames
from ..pictures.renderer import Renderer
from ..pictures.video import encode
from .cache import Run
from .checkpoints import checkpoint_files, write_checkpoint
from .extension import EXTENSION, extend, extension
from .frame_times import frame_count
from .leftovers import PARTS, leftovers
from .lock import DirectoryLock
from .motions import motion_files, write_motion
from .options import RunOptions
from .steps import StepTable
from .stored_scene import STORED_SCENE, write_scene
from .verification import BROKEN, FORCED, MOST_BROKEN, FrameTable, append_rows, keep_rows
from .wall_time import WALL_TIME, WallTime

__all__ = ["NoWriter", "Writer", "check_room", "open_writer", "visible_names"]


class NoWriter:
    """Takes the place of Writer on ranks other than 0, and writes nothing."""

    def __enter__(self) -> NoWriter:
        return self

    def __exit__(self, *_: object) -> None: ...

    @property
    def n_frames(self) -> int:
        """Number of stored frames; 0 on ranks that write nothing."""
        return 0

    def frame(self, index: int, frame: Frame) -> None: ...

    def step(
        self, report: StepReport, forced: list[list[int]], broken: list[tuple[int, str, float]]
    ) -> None: ...

    def motion(self, step: int) -> None: ...

    def checkpoint(self, step: int, state: Checkpoint) -> None: ...

    def draw_rest(self, stop: Callable[[], bool]) -> bool:
        return True

    def finish(self, report: dict[str, Any]) -> dict[str, Any]:
        return report


class Writer(NoWriter):
    """Writes the files of a run; used on rank 0 only."""

    def __init__(
        self,
        directory: Path,
        simulation: _core.Simulation,
        options: RunOptions,
        frames: FrameWriter,
        wall_time: WallTime,
        *,
        following: int,
    ) -> None:
        """Removes the rows of all steps that will be computed again from steps.csv, forced.csv and
        limits.csv. With `options.verify`, frames.csv gets a row for each stored frame.

        following : index of the next frame
        """
        self._directory, self._simulation, self._options = directory, simulation, options
        self._frames = frames
        self._wall_time = wall_time
        self._steps = StepTable(directory / "steps.csv", simulation.step_index)
        for name, _ in (FORCED, BROKEN):
            keep_rows(directory / name, simulation.step_index)
        self._checks: FrameTable | None = None
        if options.verify:
            with Run(directory) as stored:
                checks = directory / "frames.csv"
                self._checks = FrameTable(checks, simulation.topology, stored, following)
        self._painter: Painter | None = None

    def draw_with(self, painter: Painter) -> None:
        """Sets the painter that draws frames as they are written."""
        self._painter = painter

    def __exit__(self, *failure: object) -> None:
        try:
            self._steps.close()
        except OSError:
            if failure[0] is None:  # otherwise, the earlier error that ended the run is reported
                raise

    @property
    def n_frames(self) -> int:
        return self._frames.n_frames

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turns an OSError during writing into an error that says how to continue the run."""
        try:
            yield
        except OSError as error:
            told = (
                str(error)
                if isinstance(error, Error)
                else f"{self._directory}: could not write: {error.strerror}"
            )
            raise CacheError(
                f"{told.rstrip('.')}; the {self._frames.n_frames} frames written so far are kept; "
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

    def motion(self, step: int) -> None:
        """Writes the motion that the simulation kept in its last step."""
        with self._writing():
            write_motion(self._directory, step, self._simulation.collision_motion())

    def checkpoint(self, step: int, state: Checkpoint) -> None:
        with self._writing():
            self._steps.flush()
            write_checkpoint(self._directory, step, state)
            self._wall_time.keep()

    def _draws(self) -> bool:
        """Returns whether pictures are requested, with the options noted in their directory."""
        return (
            self._options.render is not None
            and drawn_with(self._directory / "frames") == self._options.render
        )

    def draw_rest(self, stop: Callable[[], bool]) -> bool:
        """Draws missing pictures from the stored frames; returns False if drawing was stopped."""
        options = self._options.render
        if options is None or not self._draws():
            return True
        if not needs_all_frames(options):
            drawn = (
                is_whole(picture(self._directory / "frames", i))
                for i in range(self._frames.n_frames)
            )
            if all(drawn):
                return True
        with self._writing():
            paths = render_run(
                Run(self._directory), options, jobs=1, stop=stop, simulation=self._simulation
            )
        return all(map(is_whole, paths))

    def finish(self, report: dict[str, Any]) -> dict[str, Any]:
        report["wall_seconds"] = self._wall_time.before + report["wall_seconds"]
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


def open_writer(
    simulation: Any,
    options: RunOptions,
    lock: DirectoryLock,
    metadata: str | None,
    *,
    overwrite: bool,
    following: int,
    controlled: bool,
) -> NoWriter:
    """Returns the writer of a run; on ranks other than 0, a NoWriter.

    `following` is the index of the next frame. If metadata is None, an existing run is continued.
    `controlled` tells whether a control function is given.

    Takes the lock of a new run. If pictures cannot be drawn or the directory must not be used, an
    error is raised before anything is written.
    """
    if simulation.rank != 0:
        return NoWriter()
    directory = lock.directory
    renderer = Renderer(simulation.topology, options.render) if options.render else None
    first = None
    wall_time = WallTime(directory, resumed=metadata is None)
    if metadata is None:
        first = _reopen(directory, options, following, simulation.step_size)
        if following < frame_count(options.duration, options.rate):
            wall_time.keep()  # the report, which also contains the wall time, is removed next
            (directory / "report.json").unlink(missing_ok=True)
            with Run(directory) as begun:
                extend(directory, begun.metadata, options, controlled=controlled)
        frames = FrameWriter.reopen(str(directory), (following - 0.5) / options.rate)
    else:
        _make_room(lock, options, metadata, overwrite)
        frames = FrameWriter(str(directory), simulation.topology, metadata, options.compression)
        _store_scene(directory, simulation, metadata)
    writer = Writer(directory, simulation, options, frames, wall_time, following=following)
    if renderer and options.render and not needs_all_frames(options.render):
        lines = options.render.field_lines
        writer.draw_with(Painter(renderer, first=first, lines=lines, simulation=simulation))
    return writer


def _reopen(directory: Path, options: RunOptions, following: int, step: float) -> Frame | None:
    """Checks that a run can be continued. If pictures are drawn, reserves their directory.

    following : index of the first frame that the continued run writes
    step : largest step [s]

    Returns the first frame of the run, or None if no pictures are drawn or no frame is kept.
    """
    extension(directory)  # raises an error if it is damaged
    _check_rate(directory, options.rate)
    _check_frames(directory, options.rate, following, step)
    if not options.render:
        return None
    begun = Run(directory)
    claim(
        directory / "frames",
        options.render,
        begun.metadata_text,
        advice="move it away, so that resuming draws all pictures again",
    )
    return begun[0] if following and len(begun) else None


def check_room(directory: Path, overwrite: bool) -> None:
    """Raises CacheError if a new run must not or cannot be written into a directory.

    Hidden files, and files of a run that has saved nothing, do not count. With `overwrite`, only
    write permission is checked.
    """
    there = next(path for path in (directory, *directory.absolute().parents) if path.exists())
    if not os.access(there, os.W_OK):
        raise CacheError(
            f"{directory} must be a directory that can be written, but {there} is write-protected;"
            " give another"
        )
    if overwrite:
        return
    if (directory / "run.vtkhdf").exists():
        raise CacheError(
            f"{directory} must hold no run yet, but has run.vtkhdf; resume it, give another"
            " directory, or overwrite"
        )
    ours = leftovers(directory)
    if others := [name for name in visible_names(directory) if name not in ours]:
        more = f" and {len(others) - 1} more" if len(others) > 1 else ""
        raise CacheError(
            f"{directory} must be empty or absent, but contains {others[0]}{more}, which no run has"
            " written; give another directory, or overwrite, which"
            " replaces only files that have the names of files of a run"
        )


def _make_room(lock: DirectoryLock, options: RunOptions, metadata: str, overwrite: bool) -> None:
    """Prepares the directory of a new run: locks, checks and creates it, removes an earlier run,
    and reserves the directory of the pictures.
    """
    directory = lock.directory
    lock.take()
    check_room(directory, overwrite)
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CacheError(
            f"{directory} must be a directory that can be written: {error.strerror}; give another"
        ) from error
    lock.take()  # if the directory is new
    check_room(directory, overwrite)  # another process may have written into it before the lock
    if options.render:
        make_directory(directory / "frames")  # if this fails, the earlier run must still be there
    for name in leftovers(directory):
        path = directory / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    if (directory / "run.vtkhdf").exists():
        _remove_run(directory)
    _remove_continuations(directory)
    if options.render:
        claim(
            directory / "frames",
            options.render,
            metadata,
            again=overwrite,
            advice="give another directory, or overwrite",
        )


def _store_scene(directory: Path, simulation: Any, metadata: str) -> None:
    """Stores the scene of a run that was not made from a scene file."""
    if "scene_file" in json.loads(metadata):
        return
    try:
        write_scene(directory, simulation.scene)
    except OSError as error:
        raise CacheError(
            f"{directory / STORED_SCENE}: could not be written: {error.strerror}; make room, or"
            " give another directory"
        ) from error


def visible_names(directory: Path) -> list[str]:
    """Returns the sorted names of the entries of a directory, except hidden ones."""
    if not directory.is_dir():
        return []
    return sorted(path.name for path in directory.iterdir() if not path.name.startswith("."))


def _check_rate(directory: Path, rate: float) -> None:
    """Raises CacheError if the run has two frames or more, and another rate."""
    begun = Run(directory)
    if len(begun) > 1 and abs(rate / begun.rate - 1.0) > 1e-6:
        raise CacheError(
            f"{directory}: rate must be that of the run, {begun.rate:.9g} frames/s, got"
            f" {rate:g}; resume with it, or give another directory"
        )


def _check_frames(directory: Path, rate: float, following: int, step: float) -> None:
    """Raises CacheError if stored frames before the frame `following` are missing at the end.

    The last step of a run may pass the end of the run, so the frame that is expected last is that
    of the run's duration. If the run was extended, frames within `step` [s] may be missing.
    """
    with Run(directory) as begun:
        duration = begun.metadata.get("duration")
        kept = begun.times[begun.times < (following - 0.5) / rate]
    if duration is not None:
        following = min(following, frame_count(duration, rate))
    last = (following - 1) / rate
    tolerated = step if duration is None or extension(directory) else 0.0
    if len(kept) and kept[-1] < last - 0.5 / rate - tolerated:
        raise CacheError(
            f"{directory}: must have frames up to {last:g} s, from which the run continues, but"
            f" ends at {kept[-1]:g} s; copy run.vtkhdf and bodies.vtkhdf again, or run the scene"
            " again"
        )


def _remove_run(directory: Path) -> None:
    """Removes the files of an earlier run, and its pictures unless their directory is a link."""
    for name in (
        "bodies.vtkhdf",
        *PARTS,
        "steps.csv",
        "unfinished-steps.csv",
        "frames.csv",
        "unfinished-frames.csv",
        "forced.csv",
        "limits.csv",
        "replay.csv",
        "report.json",
        WALL_TIME,
        f"unfinished-{WALL_TIME}",
        f"unfinished-{EXTENSION}",
        "video.mp4",
        STORED_SCENE,
    ):
        (directory / name).unlink(missing_ok=True)
    for path in motion_files(directory):
        path.unlink()
    if (directory / "frames").is_dir() and not (directory / "frames").is_symlink():
        remove_pictures(directory / "frames")
    _remove_continuations(directory)
    (directory / "run.vtkhdf").unlink()  # last, so that a removal that was interrupted is repeated


def _remove_continuations(directory: Path) -> None:
    """Removes checkpoints and extension.json, which a later run in the directory could resume from
    by mistake.
    """
    (directory / EXTENSION).unlink(missing_ok=True)
    for path in checkpoint_files(directory):
        path.unlink()
