"""Strain limits at several mesh sizes: sweeps and times of each method, as in table 3.1 of
[Thomaszewski2010], and the remaining excess.

    python tests/benchmarks/limits.py --triangles 900 3600 14400 --duration 1.0
    python tests/benchmarks/limits.py --triangles 900 3600 14400 36000 100000 --start 0.32
            --duration 0.04 > table.txt
    python tests/benchmarks/limits.py --read table.txt --plot docs/images/limit_scaling.png

With --start, the default method is used up to that time, and every method continues from the same
state.

For each mesh, the first row has no limits. The next rows are edge-based limiting (ESL), coloured
and random Gauss-Seidel, and Jacobi (one and two threads), each after an implicit step without
limits, as in [Thomaszewski2010]. The last row is the default: coloured Gauss-Seidel after a solve
with limits. Times are processor times of a step. The time of limiting is the time of a step
multiplied by the share of limiting in the wall time.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, package, parsed

SCENE = SCENES / "limit_scaling.py"
METHODS = (
    ("none", "gauss-seidel", False, 1),
    ("edges", "edges", False, 1),
    ("gauss-seidel", "gauss-seidel", False, 1),
    ("gauss-seidel-random", "gauss-seidel-random", False, 1),
    ("jacobi", "jacobi", False, 1),
    ("jacobi, 2 threads", "jacobi", False, 2),
    ("in the solve", "gauss-seidel", True, 1),
)


State = tuple[np.ndarray, np.ndarray]  # positions [m], velocities [m/s]


def simulation(
    triangles: int,
    method: str,
    in_solve: bool,
    threads: int,
    max_sweeps: int,
    state: State | None = None,
) -> ls.Simulation:
    parameters = {
        "triangles": triangles,
        "method": method,
        "in_solve": in_solve,
        "max_sweeps": max_sweeps,
    }
    file = SceneFile.open(SCENE, parameters)
    sim = ls.Simulation(file.scene(), integrator=file.integrator, threads=threads)
    if state:
        sim.positions, sim.velocities = state
    return sim


def state_at(start: float, triangles: int) -> State:
    sim = simulation(triangles, "gauss-seidel", True, 1, 100)
    while sim.time < start - 1e-9:
        sim.step()
    return np.array(sim.positions), np.array(sim.velocities)


def measure(sim: ls.Simulation, limited: bool, duration: float) -> dict[str, float]:
    steps = sweeps = evaluations = limit = iterations = 0.0
    excess: list[float] = []
    start, wall = time.process_time(), time.perf_counter()
    while sim.time < duration - 1e-9:
        sim.step()
        report = sim.report
        steps += 1
        sweeps += report.limits.sweeps
        evaluations += report.limits.evaluations
        limit += report.seconds.limit
        iterations += report.solver.linear_iterations
        excess.append(
            max(report.limits.weft_excess, report.limits.warp_excess, report.limits.shear_excess)
            if limited
            else float("nan")
        )
    excess.sort()
    cpu = 1e3 * (time.process_time() - start) / steps
    return {
        "sweeps": sweeps / steps,
        "evaluations": evaluations / steps,
        "limit": cpu * limit / (time.perf_counter() - wall),
        "cpu": cpu,
        "p90": excess[int(0.9 * len(excess))],
        "worst": excess[-1],
        "iterations": iterations / steps,
    }


def plot(file: Path, tables: list[Path]) -> None:
    """Plots the worst excess and the time of a step per triangle from printed tables."""
    package("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), constrained_layout=True)
    lines = [line for table in tables for line in table.read_text().splitlines()]
    for i, (name, *_) in enumerate(METHODS):
        rows = [
            line.replace(name, "x", 1).split()
            for line in lines
            if line[11:].startswith(f"{name}  ")
        ]
        triangles = [int(row[0]) for row in rows]
        if not rows:
            continue
        if name != "none":
            axes[0].loglog(
                triangles, [max(float(row[7]), 1e-4) for row in rows], "o-", color=f"C{i}"
            )
        times = [1e3 * float(row[5]) / int(row[0]) for row in rows]
        axes[1].loglog(triangles, times, "o-", color=f"C{i}", label=name)
    axes[0].set(xlabel="triangles", ylabel="worst excess of strain (1e-4 or less: none)")
    axes[1].set(xlabel="triangles", ylabel="processor time [µs a step and triangle]")
    axes[1].legend(fontsize=7)
    figure.savefig(file, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, nargs="+", default=[900, 3600, 14400])
    parser.add_argument("--start", type=float, default=0.0, help="when methods take over [s]")
    parser.add_argument("--duration", type=float, default=1.0, help="simulated time from there [s]")
    parser.add_argument("--max-sweeps", type=int, default=100)
    parser.add_argument(
        "--methods", nargs="+", default=[name for name, *_ in METHODS], help="rows of the table"
    )
    parser.add_argument(
        "--read", type=Path, nargs="+", default=[], help="printed tables to plot; nothing runs"
    )
    parser.add_argument("--plot", type=Path)
    options = parsed(parser, triangles=[200], duration=0.02)
    if options.read and options.plot:
        plot(options.plot, options.read)
        return
    print(
        f"{'triangles':>9}  {'method':<20} {'sweeps':>7} {'eval/tri':>8} {'limit ms':>8} "
        f"{'step ms':>8} {'excess p90':>10} {'worst':>8} {'iterations':>10}"
    )
    for triangles in options.triangles:
        state = state_at(options.start, triangles) if options.start > 0.0 else None
        for name, method, in_solve, threads in METHODS:
            if name not in options.methods:
                continue
            limited = name != "none"
            sim = simulation(
                triangles,
                method if limited else "none",
                in_solve,
                threads,
                options.max_sweeps,
                state,
            )
            m = measure(sim, limited, options.duration)
            print(
                f"{triangles:>9}  {name:<20} {m['sweeps']:>7.2f} "
                f"{m['evaluations'] / triangles:>8.2f} {m['limit']:>8.2f} "
                f"{m['cpu']:>8.2f} {m['p90']:>10.4f} {m['worst']:>8.4f} {m['iterations']:>10.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
