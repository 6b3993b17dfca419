"""Runs a simulation, and writes its results to a directory.

A run that was killed can be resumed; its frames are then bit-identical to those of an uninterrupted
run. Frames are flushed as they are written, and every checkpoint is written after the frames up to
its time. Resuming discards everything after the newest readable checkpoint and computes it again.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any
from uuid import uuid4

from .._core import CacheError, Communicator, InvalidInput
from ..ranks import check_same, together
from .cache import Run
from .checkpoints import readable_checkpoints
from .frame_times import frame_count, frames_due, time_of_frame
from .last_words import last_words
from .lock import DirectoryLock
from .magnet_record import magnets_to_record
from .observer import Observer, Silence
from .options import RunOptions
from .signals import LONGEST_WAIT, Interrupted, Received, noted_signals
from .stored_scene import digest_of
from .writer import NoWriter, open_writer

__all__ = ["execute"]


def execute(
    simulation: Any,
    options: RunOptions,
    out: str | os.PathLike[str],
    *,
    metadata: dict[str, Any] | None = None,
    overwrite: bool = False,
    resume: bool = False,
    control: Callable[[Any], None] | None = None,
    observer: Observer | None = None,
    farewell: str = "",
) -> dict[str, Any]:
    """Advances a Simulation to the end of its run and returns the report.

    All ranks must call this function. Only rank 0 writes files, and only its report contains values
    computed from the files. Raises Interrupted if a signal ends the run, and CacheError if the
    directory cannot be used, for example while another process writes a run into it.

    control : function called with the simulation before every step
    farewell : sentence that rank 0 prints if the run ends early, as last_words.py describes
    """
    directory, watch, ranks = Path(out), observer or Silence(), simulation.communicator
    _check_same(ranks, options, overwrite=overwrite, resume=resume, control=control is not None)
    n_frames = frame_count(options.duration, options.rate)
    with DirectoryLock(directory) as lock:
        if resume:
            _restore(simulation, lock, options)
        following = frames_due(simulation.time, options.rate) if simulation.step_index else 0
        with together(ranks):
            if resume and simulation.rank == 0 and control is None and following < n_frames:
                _check_control(directory)
            writer = open_writer(
                simulation,
                options,
                lock,
                None if resume else _metadata_text(simulation, options, metadata or {}, control),
                overwrite=overwrite,
                following=following,
                controlled=control is not None,
            )
        began, first_step = time.perf_counter(), simulation.step_index
        watch.start(n_frames, following)
        speech = last_words(farewell if simulation.rank == 0 else "")
        with noted_signals() as received, speech, writer:
            course = _Course(simulation, options, writer, watch, received)
            try:
                course.follow(following, control)
            finally:
                watch.end()
            with together(ranks):
                drawn = writer.draw_rest(lambda: received.number != 0)
            if number := simulation.agree(0 if drawn else received.number):
                raise Interrupted(number)
            report = {
                **_end_of(simulation, simulation.agree(writer.n_frames)),
                **_of_this_process(time.perf_counter() - began, simulation.step_index - first_step),
            }
            with together(ranks):
                report = writer.finish(report)
            return report


def _check_same(ranks: Communicator, options: RunOptions, **given: bool) -> None:
    """Raises InvalidInput on all ranks unless `options` and `given` are the same on all ranks."""
    given |= {field.name: getattr(options, field.name) for field in fields(options)}
    check_same(ranks, "run", **given)


def _restore(simulation: Any, lock: DirectoryLock, options: RunOptions) -> None:
    """Takes the lock of an existing run, and restores a readable checkpoint, if there is one.

    This is the newest checkpoint before which the run has all frames. The last step of a run may
    pass its end, so a longer run has frames within this step. It then repeats the step from the
    checkpoint before. If no checkpoint meets the condition, the newest one is restored.
    """
    stored = 0
    with together(simulation.communicator):
        if simulation.rank == 0:
            lock.take()
            with Run(lock.directory) as begun:
                stored = len(begun)
    stored = simulation.agree(stored)
    n_frames = frame_count(options.duration, options.rate)
    newest = None
    with together(simulation.communicator):
        for checkpoint in readable_checkpoints(lock.directory):
            newest = newest or checkpoint
            simulation.restore(checkpoint)
            if min(n_frames, frames_due(simulation.time, options.rate)) <= stored:
                return
        if newest:
            simulation.restore(newest)


def _check_control(directory: Path) -> None:
    """Raises CacheError if a run that continues without a control function has used one before."""
    if (directory / "run.vtkhdf").exists() and Run(directory).metadata.get("control", False):
        raise CacheError(
            f"{directory}: was run with a control function; give the same one, or one that does"
            " nothing"
        )


def _of_this_process(seconds: float, steps: int) -> dict[str, Any]:
    """Returns the part of the report about this process. Writer.finish() adds the wall time of the
    run's earlier processes to `wall_seconds`.
    """
    return {
        "wall_seconds": seconds,
        "wall_seconds_of_this_process": seconds,
        "steps_of_this_process": steps,
    }


def _end_of(simulation: Any, n_frames: int) -> dict[str, Any]:
    """Returns what report.json says about the simulation at the end of a run."""
    return {
        "frames": n_frames,
        "steps": simulation.step_index,
        "time": simulation.time,
        "preparation_seconds": simulation.preparation_seconds,
        "threads": simulation.threads,
        "ranks": simulation.ranks,
        "decomposition": simulation.decomposition,
        "hierarchy_bytes": simulation.hierarchy_bytes,
        "memory_bytes": simulation.memory_bytes,
        "digest": simulation.digest(),
    }


def _metadata_text(
    simulation: Any,
    options: RunOptions,
    metadata: dict[str, Any],
    control: Callable[[Any], None] | None,
) -> str:
    """Returns the metadata of a new run as JSON: `metadata` and further entries.

    The further entries are options of the run, whether it has a control function, the magnets and
    coils of the scene, from which field lines are drawn, and a digest of scene and integrator, by
    which pictures of another run are recognised. With a control function, a random number takes the
    place of the digest, because the function may do anything.
    """
    described = digest_of(simulation.scene, simulation.integrator)
    kept = {
        "record_tasks": options.record_tasks,
        "decomposition": simulation.decomposition,
        "control": control is not None,
        "identity": described if control is None else uuid4().hex,
    }
    magnets = magnets_to_record(simulation.scene)
    return json.dumps(metadata | kept | ({"magnetic_scene": magnets} if magnets else {}))


def _call(control: Callable[[Any], None], simulation: Any) -> None:
    """Calls a control function. Raises InvalidInput if it steps or restores the simulation."""
    before = simulation.step_index, simulation.time
    control(simulation)
    if (simulation.step_index, simulation.time) != before:
        raise InvalidInput(
            "control must not step or restore the simulation, got time"
            f" {simulation.time:g} s instead of {before[1]:g} s; the run makes the steps"
        )


class _Course:
    """The time loop of a run. It ends after the last frame or on a signal."""

    def __init__(
        self,
        simulation: Any,
        options: RunOptions,
        writer: NoWriter,
        watch: Observer,
        received: Received,
    ) -> None:
        self._simulation, self._writer, self._watch = simulation, writer, watch
        self._rate, self._received = options.rate, received
        self._record_tasks = options.record_tasks
        self._n_frames = frame_count(options.duration, options.rate)
        self._following, self._unsaved = 0, False

    def follow(self, following: int, control: Callable[[Any], None] | None) -> None:
        """Steps to the end of the run and writes the frames from index `following` on.

        Raises Interrupted if a signal ends the run.
        """
        simulation, stepped = self._simulation, False
        self._following = following
        while True:
            with together(simulation.communicator):
                if stepped:
                    self._note_step()
                self._write_frames()
            finished = self._following >= self._n_frames
            number, due = self._asked()
            self._unsaved = self._unsaved or due
            if (self._unsaved or number) and simulation.may_checkpoint:
                self._save()
            if finished:
                return
            if number:
                self._stop_where_saved(number)
            if control:
                with together(simulation.communicator):
                    _call(control, simulation)
            simulation.keep_collision_motion(self._record_tasks > 0 and simulation.rank == 0)
            simulation.step()
            stepped = True

    def _asked(self) -> tuple[int, bool]:
        """Returns the signal that ends the run (0: none), and whether a checkpoint is due.

        All ranks get the same values.
        """
        mine = 2 * self._received.number + self._received.due
        self._received.due = False
        number, due = divmod(self._simulation.agree(mine), 2)
        return number, due == 1

    def _records(self, step: int) -> bool:
        return self._record_tasks > 0 and step % self._record_tasks == 0

    def _note_step(self) -> None:
        done = self._simulation
        if self._records(done.step_index):
            self._writer.motion(done.step_index)
        self._writer.step(done.report, done.forced_pairs, done.broken_limits)
        self._watch.step(done.report)

    def _write_frames(self) -> None:
        """Writes the frames that are due at the current time."""
        due = min(self._n_frames, frames_due(self._simulation.time, self._rate))
        while self._following < due:
            at = time_of_frame(self._following, self._rate, self._simulation.time)
            frame = self._simulation.frame_at(at)
            self._writer.frame(self._following, frame)
            self._watch.frame(self._following, frame)
            self._following, self._unsaved = self._following + 1, True

    def _save(self) -> None:
        state = self._simulation.checkpoint()
        with together(self._simulation.communicator):
            self._writer.checkpoint(self._simulation.step_index, state)
        self._unsaved = False

    def _stop_where_saved(self, number: int) -> None:
        """Raises Interrupted if the state is saved, or LONGEST_WAIT [s] after the signal.

        In the second case, resuming repeats the steps after the last checkpoint.
        """
        if not self._unsaved and self._simulation.may_checkpoint:
            raise Interrupted(number)
        if self._simulation.agree(self._received.waited() >= LONGEST_WAIT):
            raise Interrupted(number)
