"""Time of the collision searches of recorded motions, measured and predicted by replay.

    loomstone run scenes/twist.py -p triangles=14450 --record-tasks 100 --out out/twist
    mpirun -n 2 python tests/benchmarks/decomposition.py out/twist
    python tests/benchmarks/decomposition.py out/twist --threads 1 2

On one rank, compares three ways in which threads share the traversal of hierarchies: OpenMP tasks,
loops and the task pool. On several ranks, compares static and dynamic decomposition with their
replays (core/parallel/pool_replay.h). Measured times are minima over the repetitions, so that other
programs hardly affect them. The default latency and overhead of a message in the replays are those
of shared memory.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import loomstone as ls
from loomstone import _core
from loomstone.runs.motions import motion_files, read_motion
from smoke import parsed


def compare_threads(motion: _core.CollisionReplay, impacts: bool, given: argparse.Namespace) -> str:
    ways = [("static", "tasks"), ("static", "loops"), ("dynamic", "tasks")]
    parts = []
    for threads in given.threads:
        times = [
            min(
                motion.perform(
                    impacts=impacts,
                    decomposition=decomposition,
                    traversal=traversal,
                    threads=threads,
                    repetitions=given.repetitions,
                )
            )
            for decomposition, traversal in ways
        ]
        tasks, loops, pool = (f"{1e3 * t:.2f}" for t in times)
        parts.append(f"{threads} threads: tasks {tasks}, loops {loops}, pool {pool} ms")
    return "; ".join(parts)


def compare_replay(
    motion: _core.CollisionReplay,
    impacts: bool,
    ranks: _core.Communicator,
    given: argparse.Namespace,
) -> str:
    search = motion.impacts if impacts else motion.contacts
    parts = []
    for name in ("static", "dynamic"):
        times = motion.perform(
            impacts=impacts,
            decomposition=name,
            communicator=ranks,
            repetitions=given.repetitions,
        )
        ranks.barrier()
        if ranks.rank == 0:
            replayed = search(ranks.size, given.repetitions, decomposition=name).replay(
                name, latency=given.latency, overhead=given.overhead
            )
            parts.append(
                f"{name} {1e3 * min(times):.3f} ms, replayed {1e3 * replayed.seconds:.3f} ms"
                f" ({replayed.seconds / min(times):.2f})"
            )
        ranks.barrier()
    return "; ".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path, nargs="?", help="default: a small run of its own")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repetitions", type=int, default=20)
    parser.add_argument("--latency", type=float, default=0.5e-6, help="[s]")
    parser.add_argument("--overhead", type=float, default=0.2e-6, help="[s]")
    given = parsed(parser, repetitions=1, threads=[1])
    ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
    with tempfile.TemporaryDirectory() as directory:
        if given.run is None:
            record(Path(directory))
        compare(given.run or Path(directory), ranks, given)


def record(directory: Path) -> None:
    """Records the motion of a sheet that falls on a ball."""
    mesh = ls.grid(size=(0.3, 0.3), triangles=450).moved((0, 0, 0.102))
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh)], obstacles=[ls.sphere(radius=0.1)])
    sim = ls.Simulation(scene, threads=1)
    sim.run(out=directory, duration=0.08, record_tasks=4, overwrite=True)


def compare(run: Path, ranks: _core.Communicator, given: argparse.Namespace) -> None:
    for path in motion_files(run):
        motion = _core.CollisionReplay(read_motion(path))
        for impacts in (False, True):
            line = (
                compare_threads(motion, impacts, given)
                if ranks.size == 1
                else compare_replay(motion, impacts, ranks, given)
            )
            if ranks.rank == 0:
                print(f"{path.stem} {'impacts' if impacts else 'contacts'}: {line}", flush=True)


if __name__ == "__main__":
    main()
