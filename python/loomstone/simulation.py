"""A scene that advances."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from . import _core
from ._core import (
    Checkpoint,
    Communicator,
    Frame,
    InvalidInput,
    RenderOptions,
    Scene,
)
from .base.arguments import takes
from .integrators import Integrator, SemiImplicitEuler
from .pictures.directory import drawn_with
from .ranks import end_all_on_failure
from .runs.execution import execute
from .runs.frame_times import frame_count, frames_due
from .runs.options import RunOptions

__all__ = ["Simulation"]


class Simulation(_core.Simulation):
    """A built scene that advances. Arrays are in the user's vertex order, all cloths end to end.

    scene : Scene
    integrator : Integrator: SemiImplicitEuler(...) or another; None: SemiImplicitEuler()
    threads : 0 means all processors
    communicator : ranks that share the work: a Communicator, an mpi4py communicator, or None for
        this process alone. Every rank then makes the same calls; after every step all hold all
        positions and velocities. What is written into arrays between steps counts on the rank that
        owns the row, what is said about obstacles counts on rank 0.

    Raises InvalidInput for everything in the scene that cannot be simulated. `positions`,
    `velocities` and `external_forces` are copies that can be assigned; `state` holds views of the
    internal tables.

    >>> import loomstone as ls
    >>> scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)), pins=[0, 4])])
    >>> sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=5e-3))
    >>> sim.step()
    >>> round(sim.time, 6)
    0.005
    """

    __slots__ = ("communicator",)  # so that assigning to a misspelt name is an error
    communicator: Communicator

    def __init__(
        self,
        scene: Scene,
        *,
        integrator: Integrator | None = None,
        threads: int = 0,
        communicator: Any = None,
    ) -> None:
        integrator = SemiImplicitEuler() if integrator is None else integrator
        _check_type("scene", scene, Scene)
        _check_type(
            "integrator",
            integrator,
            Integrator,
            ", for instance SemiImplicitEuler(step=1e-3)",
        )
        _check_type("threads", threads, (int, np.integer))
        ranks = _communicator(communicator)
        end_all_on_failure(ranks)
        super().__init__(scene, integrator, threads=threads, communicator=ranks)
        self.communicator = ranks

    @takes(duration="s", rate="1/s")
    def frames(self, *, duration: float, rate: float = 25.0) -> Iterator[Frame]:
        """Advances and yields a Frame every 1/rate, from 0 to `duration` [s] of simulated time.

        Between frames and steps positions, velocities, external forces, pins and obstacle poses may
        be written. Frames between two steps are interpolated. The generator continues from the
        present time.
        """
        last = frame_count(duration, rate) - 1
        following = frames_due(self.time, rate) if self.step_index else 0
        while following <= last:
            while frames_due(self.time, rate) <= following:
                self.step()
            yield self.frame_at(following / rate)
            following += 1

    @takes(duration="s", rate="1/s")
    def run(
        self,
        *,
        out: str | os.PathLike[str],
        duration: float,
        rate: float = 25.0,
        render: bool | RenderOptions = False,
        verify: bool = False,
        overwrite: bool = False,
        resume: bool = False,
        control: Callable[[Simulation], None] | None = None,
    ) -> dict[str, Any]:
        """Advances to `duration` [s] and writes frames, checkpoints, a table of steps and, where
        asked, pictures.

        out : directory; overwrite : replace what is there; resume : continue what is there, bit for
            bit, with the same scene, integrator and rate (else CacheError); a longer duration
            prolongs it
        render : pictures and a video, with these RenderOptions; drawn while it runs, but at the end
            where their colours span the values of all frames. True: those of pictures that a
            resumed run has, else the default. Others than those are refused
        verify : count intersecting triangles of every frame exactly, into frames.csv and the report
        control : called before every step; may write forces, pins and obstacle poses, as a function
            of time and state

        Returns the report that is also in report.json.
        """
        look = render or None
        if look is True:
            look = (drawn_with(Path(out) / "frames") if resume else None) or RenderOptions()
        if look is not None:
            _check_type("render", look, RenderOptions, ", True or False")
        options = RunOptions(duration=duration, rate=rate, render=look, verify=verify)
        return execute(self, options, out, overwrite=overwrite, resume=resume, control=control)

    def restore(self, checkpoint: Checkpoint) -> None:
        """Continues from a checkpoint of the same scene and integrator; CacheError tells which
        fields are others.

        Checkpoints of earlier versions do not know what they are of: only their counts of vertices,
        bodies ... are compared.
        """
        _check_type("checkpoint", checkpoint, Checkpoint)
        super().restore(checkpoint)

    def digest(self) -> str:
        """Hash of the state: equal where, and only where, all bits are equal.

        Where the step allows no checkpoint (see `may_checkpoint`) of what can be seen: positions,
        velocities, bodies.
        """
        content = hashlib.sha256()
        if not self.may_checkpoint:
            seen = self.state
            for table in (
                seen.positions,
                seen.velocities,
                seen.body_centres,
                seen.body_orientations,
                seen.body_velocities,
            ):
                content.update(np.ascontiguousarray(table).tobytes())
            return content.hexdigest()
        state = self.checkpoint()
        for name, array in sorted(state.arrays.items()):
            content.update(
                name.encode() + repr(array.shape).encode() + np.ascontiguousarray(array).tobytes()
            )
        for name, values in sorted(state.integers.items()):
            content.update(name.encode() + np.asarray(values, np.int64).tobytes())
        for name, values in sorted(state.bytes.items()):
            content.update(name.encode() + values)
        return content.hexdigest()

    def __repr__(self) -> str:
        if not hasattr(
            self, "communicator"
        ):  # a debugger or test runner shows one whose scene was refused
            return "Simulation(not built)"
        vertices, triangles = len(self.topology.cloth_of_vertex), len(self.topology.triangles)
        return (
            f"Simulation({vertices} vertices, {triangles} triangles, time={self.time:g},"
            f" step={self.step_index})"
        )


def _check_type(name: str, value: object, wanted: type | tuple[type, ...], hint: str = "") -> None:
    if not isinstance(value, wanted):
        called = (wanted[0] if isinstance(wanted, tuple) else wanted).__name__
        got = (
            f"the class {value.__name__}"
            if isinstance(value, type)
            else f"a {type(value).__name__}"
        )
        raise InvalidInput(f"{name} must be {called}{hint}, got {got}")


def _communicator(given: Any) -> Communicator:
    if given is None:
        return _core.single_communicator()
    if isinstance(given, Communicator):
        return given
    if not hasattr(given, "py2f"):
        raise InvalidInput(
            "communicator must be a Communicator or an mpi4py communicator, got a"
            f" {type(given).__name__}; pass MPI.COMM_WORLD or None"
        )
    return _core.mpi_communicator(given.py2f())
