"""Cost of waiting threads: wall and processor time of a drape for several spin counts, on an idle
machine and with busy processes. A spin count is the number of times that a thread checks for work
before it sleeps.

    python tests/benchmarks/waiting.py [--triangles 3600 --duration 0.4 --busy 0 2 4 --repeats 3
            --counts 0 500 1000 2000 4000 8000 16000 300000 --threads 2 --ranks]

A count of 300000 is the default of libgomp; 0 is OMP_WAIT_POLICY=passive (threads sleep at once).
Every run is a separate process. The run and the busy processes share as many processors as the run
has threads. Counts alternate, so that a change of the machine's load affects all of them. The table
lists medians over the repeats. With --ranks, the program compares numbers of MPI ranks instead of
spin counts: one rank and two ranks of one thread each, on two processors.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator

from smoke import AS_ROOT, SCENES, mpirun, parsed


def drape(triangles: int, duration: float, threads: int, ranks: bool) -> None:
    """Steps the drape, and prints the wall and processor time [s] of all steps but the first."""
    import loomstone as ls
    from loomstone.runs.scene_file import SceneFile

    file = SceneFile.open(SCENES / "drape.py", {"triangles": triangles})
    communicator = ls.ranks.mpi_communicator() if ranks else None
    sim = ls.Simulation(
        file.scene(), integrator=file.integrator, threads=threads, communicator=communicator
    )
    sim.step()
    wall, processor = time.perf_counter(), time.process_time()
    while sim.time < duration:
        sim.step()
    times = (time.perf_counter() - wall, time.process_time() - processor)
    print(json.dumps(times), flush=True)


@contextlib.contextmanager
def busy_processes(count: int) -> Iterator[None]:
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def measured(given: argparse.Namespace, row: int) -> tuple[float, float]:
    """Returns the wall time of the slowest rank and the processor time of all ranks [s].

    `row` is the spin count or, with --ranks, the number of ranks.
    """
    environment = {k: v for k, v in os.environ.items() if k != "OMP_WAIT_POLICY"}
    environment |= AS_ROOT
    if given.ranks or row == 0:
        environment["OMP_WAIT_POLICY"] = "passive"
    else:
        environment["GOMP_SPINCOUNT"] = str(row)
    command = [sys.executable, __file__, "--child", "--triangles", str(given.triangles)]
    command += ["--duration", str(given.duration), "--threads", str(given.threads)]
    if given.ranks:
        command = [*mpirun(row), *command, "--ranks"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    # mpirun may put the outputs of two ranks on one line.
    times = [json.loads(found) for found in re.findall(r"\[[^]]*\]", done.stdout)]
    return max(t[0] for t in times), sum(t[1] for t in times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=3600)
    parser.add_argument("--duration", type=float, default=0.4, help="simulated time [s]")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--busy", nargs="+", type=int, default=[0, 2, 4])
    parser.add_argument(
        "--counts",
        nargs="+",
        type=int,
        default=[0, 500, 1000, 2000, 4000, 8000, 16000, 300000],
    )
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--ranks", action="store_true", help="compare one and two MPI ranks")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    given = parsed(
        parser, triangles=128, duration=0.02, busy=[0, 1], counts=[0, 2000], repeats=1, threads=1
    )
    if given.ranks:
        given.threads = 1
    if given.child:
        drape(given.triangles, given.duration, given.threads, given.ranks)
        return
    allowed = sorted(os.sched_getaffinity(0))[: 2 if given.ranks else given.threads]
    os.sched_setaffinity(0, allowed)
    what = "ranks of 1 thread" if given.ranks else f"{given.threads} threads"
    print(
        f"drape, {given.triangles} triangles, {given.duration} s, {what} on {len(allowed)} "
        f"processors: wall / processor time [s], median of {given.repeats}"
    )
    heading = "ranks" if given.ranks else "spin count"
    print(f"{heading:>10}" + "".join(f"{f'{n} busy':>18}" for n in given.busy))
    rows = [1, 2] if given.ranks else given.counts
    times: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for busy in given.busy:
        with busy_processes(busy):
            for _ in range(given.repeats):
                for row in rows:
                    times.setdefault((row, busy), []).append(measured(given, row))
    for row in rows:
        cells = [
            [statistics.median(t[i] for t in times[row, busy]) for i in range(2)]
            for busy in given.busy
        ]
        print(f"{row:10d}" + "".join(f"{wall:10.2f} /{cpu:6.2f}" for wall, cpu in cells))


if __name__ == "__main__":
    main()
