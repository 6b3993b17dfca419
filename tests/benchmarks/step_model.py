"""Predicts the time of a whole step on many ranks from runs on few ranks.

    loomstone run scenes/drape.py -p triangles=57800 --duration 0.05 --threads 1 --out out/one
    mpirun -n 2 loomstone run scenes/drape.py -p triangles=57800 --duration 0.05 --threads 1 \
        --out out/two
    python tests/benchmarks/step_model.py out/one out/two [--ranks 1 2 12 64 --first 10]

The model assumes that on n ranks, collision handling and the rest of a step each take the time
a + b / n outside communication. Both pairs of numbers a and b are fitted to the runs, which must
have at least two different numbers of ranks. A collective operation takes one message in each of
log2(n) rounds (rounded up), and every rank receives the bytes that all ranks send. The numbers of
operations and bytes in a step are those of the run with the most ranks. Measured times are means,
not minima, over the steps from --first on, so other programs on the machine would distort them.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from smoke import AS_ROOT, SCENES, mpirun, parsed

NETWORKS = {"1.5 us, 10 GB/s": (1.5e-6, 1e10, 0.2e-6), "12 us, 1 GB/s": (12e-6, 1e9, 0.5e-6)}


@dataclass
class Measured:
    """Times [s] that collision handling and the rest of a step take outside communication, averaged
    over the ranks and steps of a run, and the traffic in a step, averaged over the steps.
    """

    ranks: int
    collision: float
    other: float
    operations: float  # number of collective operations in a step
    bytes: float  # bytes that all ranks send in a step


def measured(directory: Path, first: int) -> Measured:
    ranks = int(json.loads((directory / "report.json").read_text())["ranks"])
    with (directory / "steps.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))[first:]

    def mean(name: str) -> float:
        return sum(float(row[name]) for row in rows) / len(rows)

    collision = mean("ranks.collision_computing")
    return Measured(
        ranks,
        collision,
        mean("ranks.computing") - collision,
        mean("ranks.operations"),
        ranks * mean("ranks.bytes"),
    )


def fitted(runs: list[Measured], part: str) -> tuple[float, float]:
    """Returns a and b [s] such that a + b / n fits the time of `part` on n ranks.

    `part` is "collision" or "other". Neither a nor b is negative.
    """
    shares = np.array([[1.0, 1.0 / run.ranks] for run in runs])
    times = np.array([getattr(run, part) for run in runs])
    a, b = np.linalg.lstsq(shares, times, rcond=None)[0]
    if a < 0.0:
        a, b = 0.0, float(times @ shares[:, 1] / (shares[:, 1] @ shares[:, 1]))
    elif b < 0.0:
        a, b = float(times.mean()), 0.0
    return float(a), float(b)


def predicted(runs: list[Measured], ranks: int, network: tuple[float, float, float]) -> float:
    """Returns the predicted time of a step on `ranks` ranks [s].

    network: latency [s], bandwidth [bytes/s] and processor time at each end of a message [s].
    """
    latency, bandwidth, overhead = network
    seconds = sum(a + b / ranks for a, b in (fitted(runs, "collision"), fitted(runs, "other")))
    if ranks == 1:
        return seconds
    most = max(runs, key=lambda run: run.ranks)
    rounds = math.ceil(math.log2(ranks))
    return seconds + most.operations * rounds * (latency + 2.0 * overhead) + most.bytes / bandwidth


def record(directory: Path) -> list[Path]:
    """Runs a small drape on one rank and on two; returns the directories of both runs."""
    runs = []
    for ranks in (1, 2):
        out = directory / str(ranks)
        launcher = mpirun(ranks) if ranks > 1 else []
        command = [sys.executable, "-m", "loomstone", "run", str(SCENES / "drape.py")]
        options = ["-p", "triangles=450", "--duration", "0.05", "--threads", "1", "--out", str(out)]
        done = subprocess.run(
            [*launcher, *command, *options],
            env={**os.environ, **AS_ROOT},
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise SystemExit(done.stderr)
        runs.append(out)
    return runs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path, nargs="*", help="default: two small runs of its own")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4, 12, 64, 1000])
    parser.add_argument("--first", type=int, default=10)
    given = parsed(parser, first=1)
    with tempfile.TemporaryDirectory() as directory:
        paths = given.runs or record(Path(directory))
        runs = [measured(path, given.first) for path in paths]
    if len({run.ranks for run in runs}) < 2:
        parser.error("the runs must have at least two different numbers of ranks")
    for part in ("collision", "other"):
        a, b = fitted(runs, part)
        print(f"{part}: {1e3 * a:.2f} ms + {1e3 * b:.2f} ms / ranks")
    for name, network in NETWORKS.items():
        alone = predicted(runs, 1, network)
        times = [(n, predicted(runs, n, network)) for n in given.ranks]
        print(
            f"{name}: " + ", ".join(f"{n}: {1e3 * t:.2f} ms ({alone / t:.1f}x)" for n, t in times)
        )


if __name__ == "__main__":
    main()
