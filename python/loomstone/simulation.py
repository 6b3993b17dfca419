"""The Simulation class, which advances a scene in time."""

from __future__ import annotations

import hashlib
import os
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal, SupportsFloat, SupportsIndex

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
from .base.cautions import SceneWarning
from .integrators import Integrator, SemiImplicitEuler, to_record
from .pictures.directory import drawn_with
from .pictures.notebook import remember
from .plausibility import implausible
from .ranks import check_same, end_all_on_failure
from .runs.execution import execute
from .runs.frame_times import frame_count, frames_due, time_of_frame, warn_of_part_frame
from .runs.options import RunOptions

__all__ = ["Simulation"]


@takes()
class Simulation(_core.Simulation):
    """A scene prepared for time stepping.

    Arrays of cloth contain all cloths one after another, with the vertices of each in the user's
    order. In `state`, rows are permuted: row vertex_order[i] belongs to vertex i.

    scene : Scene
    integrator : Integrator, for instance SemiImplicitEuler(...); None: SemiImplicitEuler()
    threads : largest number of threads; 0: the number in the environment variable OMP_NUM_THREADS
        or, without it, one for each processor. While other programs keep the processors busy, a
        single rank uses one thread, unless OMP_WAIT_POLICY is passive. Results do not depend on the
        number of threads.
    communicator : MPI ranks that share the work: a Communicator, an mpi4py communicator, or None
        for this process alone. Every rank must make the same calls. After every step, every rank
        has the positions and velocities of all vertices. If an array of the cloth is assigned
        between steps, each row takes the value assigned on the rank that owns it. For bodies and
        obstacles, only values assigned on rank 0 take effect.
    decomposition : how the search for collisions is divided among ranks and threads. "predicted":
        every rank keeps a part of the neighbour lists over several steps and tests their pairs. The
        costs of the lists in earlier steps determine the parts. "static" and "dynamic": every step
        traverses the bounding-volume hierarchies of the partitions of all ranks. "static"
        distributes the pairs of partitions evenly. With "dynamic", idle ranks take work from busy
        ones. Results do not depend on the decomposition.

    Raises InvalidInput if the scene cannot be simulated. Warns with SceneWarning if the scene can
    be simulated but looks like a mistake, for example if bodies overlap at the start. `positions`,
    `velocities` and `external_forces` are copies that can be assigned. `state` provides views of
    the internal tables. `scene` and `integrator` are those in use and cannot be replaced.
    `preparation_seconds` is the wall time of building the simulation, without the search for likely
    mistakes [s].

    >>> import loomstone as ls
    >>> scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)), pins=[0, 4])])
    >>> sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=5e-3))
    >>> sim.step()
    >>> round(sim.time, 6)
    0.005
    """

    # With slots, assignment to a misspelt attribute raises an error.
    __slots__ = ("_communicator", "_integrator", "_preparation_seconds", "_scene")
    _communicator: Communicator
    _preparation_seconds: float
    _integrator: Integrator
    _scene: Scene

    def __init__(
        self,
        scene: Scene,
        *,
        integrator: Integrator | None = None,
        threads: int = 0,
        communicator: Any = None,
        decomposition: Literal["predicted", "static", "dynamic"] = "predicted",
    ) -> None:
        began = time.perf_counter()
        integrator = SemiImplicitEuler() if integrator is None else integrator
        _check_type("scene", scene, Scene)
        _check_type(
            "integrator",
            integrator,
            Integrator,
            ", for instance SemiImplicitEuler(step=1e-3)",
        )
        _check_type("threads", threads, (int, np.integer))
        _check_type("decomposition", decomposition, str)
        ranks = _communicator(communicator)
        end_all_on_failure(ranks)
        check_same(ranks, "Simulation", decomposition=decomposition)
        super().__init__(
            scene,
            integrator,
            threads=threads,
            communicator=ranks,
            decomposition=decomposition,
        )
        self._communicator, self._integrator, self._scene = ranks, integrator, scene
        self._preparation_seconds = time.perf_counter() - began
        found = implausible(self)
        for sentence in found if ranks.rank == 0 else []:
            warnings.warn(sentence, SceneWarning, stacklevel=3)

    @property
    def communicator(self) -> Communicator:
        """The MPI ranks that share the work."""
        return self._communicator

    @property
    def integrator(self) -> Integrator:
        """The integrator of the simulation."""
        return self._integrator

    @property
    def preparation_seconds(self) -> float:
        """Wall time of building the simulation, without the search for likely mistakes [s]."""
        return self._preparation_seconds

    @property
    def scene(self) -> Scene:
        """The scene that is simulated."""
        return self._scene

    @takes(duration="s", rate="1/s")
    def frames(self, *, duration: float, rate: float = 25.0) -> Iterator[Frame]:
        """Advances the simulation and yields a Frame every 1/rate [s], from 0 to `duration` [s].

        Positions, velocities, external forces, pins and obstacle poses may be assigned between two
        frames. A frame at a time between two steps is interpolated. If the simulation has already
        advanced, frames up to the current time are left out.
        """
        check_same(self.communicator, "frames", duration=duration, rate=rate)
        last = frame_count(duration, rate) - 1
        if self.communicator.rank == 0:
            warn_of_part_frame(duration, rate, stacklevel=2)
        following = frames_due(self.time, rate) if self.step_index else 0
        while following <= last:
            while frames_due(self.time, rate) <= following:
                self.step()
            yield self.frame_at(time_of_frame(following, rate, self.time))
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
        compression: int = 0,
        overwrite: bool = False,
        resume: bool = False,
        record_tasks: int = 0,
        control: Callable[[Simulation], None] | None = None,
    ) -> dict[str, Any]:
        """Advances to `duration` [s] and writes frames, checkpoints, a table of steps and, on
        request, pictures.

        out : directory
        rate : frames per second of simulated time [1/s]
        overwrite : replace an existing run
        resume : continue an existing run; the result is bit-identical to that of an uninterrupted
            run. A longer duration extends the run. Raises CacheError unless scene, integrator and
            rate are the same.
        render : draw pictures and a video with these RenderOptions. True: the options of the
            pictures of a resumed run, or else the defaults. Pictures are drawn during the run, or
            at its end if their colours or a fitted camera depend on all frames. Options that differ
            from those of existing pictures are refused, unless `overwrite` replaces the run.
        verify : count the intersecting triangle pairs of every frame exactly, and write the counts
            to frames.csv and a summary of them to the report
        record_tasks : n, to record the motion of surfaces in every n-th step for `loomstone
            replay`; 0, to record none. A recorded step takes up to 432 bytes a vertex, on disk and
            in the memory of rank 0.
        compression : level of the deflate compression of frames, 0 (none) to 9; a resumed run keeps
            its level. Compressed files are smaller by about a fifth; docs/cache.md gives the cost.
        control : function called before every step. It may write forces, pins and obstacle poses,
            which must depend on time and state alone. It must not step or restore the simulation.

        Returns the report that is also written to report.json. The scene is stored in scene.npz, so
        that `loomstone resume` can continue the run if it has no `control`. Raises CacheError if
        the directory cannot be used, for example while another process writes a run into it.
        After Ctrl-C, SIGTERM or SIGUSR1 in the main thread, raises KeyboardInterrupt once a
        checkpoint is written or after 10 s. The attribute `signal` of this exception is the number
        of the signal. A further Ctrl-C raises KeyboardInterrupt at once, without this attribute.
        """
        look = _look(render, Path(out) if resume else None)
        _check_run(compression, record_tasks, control)
        options = RunOptions(
            duration=duration,
            rate=rate,
            render=look,
            verify=verify,
            record_tasks=int(record_tasks),
            compression=int(compression),
        )
        if self.communicator.rank == 0:
            warn_of_part_frame(duration, rate, stacklevel=3)
        kept = self._metadata(options)
        return execute(
            self, options, out, metadata=kept, overwrite=overwrite, resume=resume, control=control
        )

    def _metadata(self, options: RunOptions) -> dict[str, Any]:
        """Returns the metadata of a run, with which `loomstone resume` can continue it."""
        return {
            "loomstone": _core.__version__,
            "duration": options.duration,
            "rate": options.rate,
            "integrator": to_record(self.integrator),
            "render": (options.render or RenderOptions()).to_dict(),
        }

    def restore(self, checkpoint: Checkpoint) -> None:
        """Continues from a checkpoint of the same scene and integrator.

        If the scene or the integrator differs, raises a CacheError that names the fields that
        differ. Older checkpoints, which contain no hashes of fields, are compared by their numbers
        of vertices, bodies and so on.
        """
        _check_type("checkpoint", checkpoint, Checkpoint)
        super().restore(checkpoint)

    def digest(self) -> str:
        """Returns a hash of the state. States with equal hashes are equal bit by bit.

        All ranks must call this method, and get the same hash.

        If the current step allows no checkpoint (see `may_checkpoint`), the hash covers only the
        positions and velocities of cloth vertices, and the poses and linear velocities of bodies.
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

    def frame(self) -> Frame:
        """Returns the Frame of the current state."""
        return remember(super().frame(), self.topology)

    @takes(time="s")
    def frame_at(self, time: SupportsFloat | SupportsIndex) -> Frame:
        """Returns the Frame at a time [s] within the step that ended last, by interpolation.

        The time may be the start or the end of this step. Raises InvalidInput for other times.
        """
        return remember(super().frame_at(time), self.topology)

    def __repr__(self) -> str:
        # A debugger or test runner may print a simulation whose constructor has raised an error.
        if not hasattr(self, "communicator"):
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


def _check_run(compression: object, record_tasks: Any, control: object) -> None:
    """Raises InvalidInput for invalid arguments of Simulation.run()."""
    _check_type("compression", compression, (int, np.integer))
    _check_type("record_tasks", record_tasks, (int, np.integer))
    if record_tasks < 0:
        raise InvalidInput(f"record_tasks must be at least 0, got {record_tasks}")
    if control is not None and not callable(control):
        raise InvalidInput(f"control must be a function, got {control!r}")


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


def _look(given: bool | RenderOptions, resumed: Path | None) -> RenderOptions | None:
    """Returns the options of the pictures of a run, or None if none are drawn."""
    if not given:
        return None
    if given is True:
        return (drawn_with(resumed / "frames") if resumed else None) or RenderOptions()
    _check_type("render", given, RenderOptions, ", True or False")
    return given
