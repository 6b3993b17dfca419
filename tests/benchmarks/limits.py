"""Strain limits over mesh sizes (table 3.1 of the thesis): sweeps, times and what each method leaves.

    python tests/benchmarks/limits.py --triangles 900 3600 14400 --duration 1.0

Rows: edges (ESL), coloured and random Gauss-Seidel, Jacobi (one thread, and two), each after an implicit step that knows nothing of
limits, as in the thesis; then coloured Gauss-Seidel behind limits inside the solve, the default. Times are CPU seconds of
the stage a second of motion; ratios within a row block are what counts.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import loomstone as ls
from loomstone.scene_file import SceneFile

SCENE = Path(__file__).parents[2] / "scenes" / "limit_scaling.py"
METHODS = (
    ("none", "gauss-seidel", False, 1),
    ("edges", "edges", False, 1),
    ("gauss-seidel", "gauss-seidel", False, 1),
    ("gauss-seidel-random", "gauss-seidel-random", False, 1),
    ("jacobi", "jacobi", False, 1),
    ("jacobi, 2 threads", "jacobi", False, 2),
    ("in the solve", "gauss-seidel", True, 1),
)


def measure(triangles: int, method: str, in_solve: bool, threads: int, duration: float, max_sweeps: int) -> dict[str, float]:
    parameters = {"triangles": triangles, "method": method, "in_solve": in_solve, "max_sweeps": max_sweeps}
    file = SceneFile.open(SCENE, parameters)
    sim = ls.Simulation(file.scene(), integrator=file.integrator, threads=threads)
    steps = sweeps = evaluations = limit = integrate = 0.0
    excess: list[float] = []
    start = time.process_time()
    while sim.time < duration - 1e-9:
        sim.step()
        report = sim.report
        steps += 1
        sweeps += report.limit_sweeps
        evaluations += report.limit_evaluations
        limit += report.seconds["limit"]
        integrate += report.seconds["integrate"]
        excess.append(max(report.weft_excess, report.warp_excess, report.shear_excess) if method != "none" else float("nan"))
    excess.sort()
    return {
        "sweeps": sweeps / steps,
        "evaluations": evaluations / steps,
        "limit": limit,
        "integrate": integrate,
        "cpu": time.process_time() - start,
        "p90": excess[int(0.9 * len(excess))],
        "worst": excess[-1],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, nargs="+", default=[900, 3600, 14400])
    parser.add_argument("--duration", type=float, default=1.0, help="simulated time [s]")
    parser.add_argument("--max-sweeps", type=int, default=100)
    options = parser.parse_args()
    print(f"{'triangles':>9}  {'method':<20} {'sweeps':>7} {'eval/tri':>8} {'limit s':>8} {'integr s':>8} {'excess p90':>10} {'worst':>8}")
    for triangles in options.triangles:
        for name, method, in_solve, threads in METHODS:
            method = "none" if name == "none" else method
            m = measure(triangles, method, in_solve, threads, options.duration, options.max_sweeps)
            print(
                f"{triangles:>9}  {name:<20} {m['sweeps']:>7.2f} {m['evaluations'] / triangles:>8.2f} {m['limit']:>8.2f} "
                f"{m['integrate']:>8.2f} {m['p90']:>10.4f} {m['worst']:>8.4f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
