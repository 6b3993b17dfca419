"""Measures how long it takes until two sheets that cross from edge to edge are separated.

    python tests/benchmarks/crossed.py --triangles 450 1800 --starts 10 [--kinds falling floor]

The sheets fall freely (falling), fall onto a floor (floor), float without gravity (weightless), or
fall while one edge of the first is pinned (pinned). For each kind, size and start, the table lists
the number of intersecting pairs at the start, the time from which no step ends with an
intersection, the number of intersecting pairs in frames after that time (333 and 1,777 per second,
interpolated between steps), the largest stretch and the processor time. The exit status is 1 if
sheets part later than 0.5 s or not at all, or if any of these frames has an intersecting pair.
"""

from __future__ import annotations

import argparse
import time

import loomstone as ls
import numpy as np
from extreme_scenes import SOFT
from loomstone.runs.verification import count_intersections
from smoke import parsed

SIZE = 0.2
KINDS = ("falling", "floor", "weightless", "pinned")
RATES = (333.0, 1777.0)


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def crossed(triangles: int, start: int, kind: str) -> ls.Scene:
    """Returns a scene of two equal square sheets that intersect in a line from edge to edge."""
    random = np.random.default_rng(start)
    cells = max(1, round(np.sqrt(triangles / 2)))
    flat = ls.grid(size=(SIZE, SIZE), cells=(cells, cells))
    tilt = rotation(random.normal(size=3), np.radians(random.uniform(0.0, 3.0)))
    turn = rotation(np.array([0.0, 1.0, 0.0]), np.radians(random.uniform(30.0, 150.0)))
    x, y, z = random.uniform((-0.05, -0.001, -0.03), (0.05, 0.001, 0.03))
    edge = np.flatnonzero(flat.vertices[:, 0] < 1e-6 - 0.5 * SIZE) if kind == "pinned" else []
    first = ls.Cloth(
        name="first", mesh=flat.moved((0, 0, 0), rotation=tilt), material=SOFT, pins=list(edge)
    )
    second = ls.Cloth(name="second", mesh=flat.moved((x, y, z), rotation=turn), material=SOFT)
    return ls.Scene(
        cloths=[first, second],
        obstacles=[ls.floor(height=-0.15)] if kind == "floor" else [],
        gravity=(0, 0, 0) if kind == "weightless" else (0, 0, -9.81),
        allow_initial_intersections=True,
    )


def parting(scene: ls.Scene, duration: float) -> tuple[float, float, int]:
    """Returns the time [s] at the end of the step that separates the sheets, the largest stretch
    and the number of intersecting pairs in frames after that time. The time is infinite if the
    sheets stay crossed.
    """
    sim = ls.Simulation(scene, threads=1)
    parted, stretch, pairs = np.inf, 1.0, 0
    times = np.sort(np.concatenate([np.arange(1, rate * duration) / rate for rate in RATES]))
    for at in times:
        while sim.time < at:
            sim.step()
            stretch = max(stretch, sim.report.strain.stretch)
            if sim.report.contacts.intersections > 0:
                parted, pairs = np.inf, 0
            elif parted == np.inf:
                parted = sim.time
        if parted < at:
            pairs += count_intersections(sim.topology, sim.frame_at(at)).cloth
    return parted, stretch, pairs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, nargs="+", default=[450, 1800])
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--duration", type=float, default=0.6, help="[s]")
    options = parsed(parser, triangles=[98], starts=1, kinds=["falling"], duration=0.6)
    print(f"{'kind':10} triangles start  pairs  parted [s]  pairs after  stretch  time [s]")
    late = 0
    for kind in options.kinds:
        for triangles in options.triangles:
            for start in range(options.starts):
                scene = crossed(triangles, start, kind)
                pairs = len(ls.Simulation(scene, threads=1).intersecting_pairs())
                begin = time.process_time()
                parted, stretch, after = parting(scene, options.duration)
                seconds = time.process_time() - begin
                late += parted > 0.5 or after > 0
                print(
                    f"{kind:10} {triangles:9} {start:5} {pairs:6} {parted:11.3f} {after:12}"
                    f" {stretch:8.3f} {seconds:9.1f}",
                    flush=True,
                )
    raise SystemExit(late > 0)


if __name__ == "__main__":
    main()
