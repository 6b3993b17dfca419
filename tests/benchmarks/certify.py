"""Counts intersecting pairs of triangles over all frames of scenes with cloth, for several time
steps and for start positions whose coordinates are perturbed by up to 1e-6 m.

    python tests/benchmarks/certify.py [--scenes drape twist --steps 1e-3 4e-3 --rate 25 --runs 10
    --jobs 2 --out certify.csv]
    python tests/benchmarks/certify.py --scenes obstacle_walk ribbon swing_integrators uneven
    --steps 1e-3 2.5e-3
    python tests/benchmarks/certify.py --scenes ball_corners ball_edges curtains_free curtains_hung
    heap magnets pushed --steps auto --rate 1777

Each run appends one row to the table; runs already in the table are skipped. The exit status is 1
if any run in the table has a frame with an intersecting pair of triangles that involves cloth.
"""

import argparse
import csv
import multiprocessing
import os
import time
from pathlib import Path
from typing import Literal

import loomstone as ls
import numpy as np
from extreme_scenes import caught, clamped, curtains, heap, pushed
from loomstone.runs.scene_file import SceneFile
from loomstone.runs.verification import count_intersections
from smoke import SCENES, parsed

PERTURBATION = 1e-6  # largest offset of a coordinate [m]

# Parameters and duration [s] of each scene.
SIZES = {
    "bending": ({"triangles": 512}, 0.6),
    "bin": ({"triangles": 96, "towels": 6}, 0.8),
    "card": ({"triangles": 800, "boxes": 4}, 0.6),
    "disc": ({"triangles": 800}, 0.6),
    "drape": ({"triangles": 1800}, 1.0),
    "dress": ({"triangles": 1500}, 0.6),
    "flag": ({"triangles": 800}, 0.5),
    "fold": ({"triangles": 1200, "layers": 6}, 0.8),
    "funnel": ({"triangles": 1800}, 1.0),
    "hanging": ({"triangles": 512}, 0.5),
    "incline": ({"triangles": 200}, 0.5),
    "knot": ({"triangles": 800}, 1.0),
    "obstacle_walk": ({"triangles": 1200}, 1.6),
    "ribbon": ({"triangles": 800}, 1.4),
    "sphere_slide": ({"triangles": 1800}, 1.0),
    "stack": ({"triangles": 128, "sheets": 12}, 1.0),
    "swing_integrators": ({"triangles": 400}, 2.0),
    "swing_limits": ({"triangles": 300}, 0.8),
    "table_cloth": ({"triangles": 1200}, 1.0),
    "twist": ({"triangles": 1800}, 1.0),
    "uneven": ({"triangles": 600}, 0.8),
    "wave_bar": ({"triangles": 1800}, 1.0),
}
# Constructor and duration [s] of each scene without a scene file. These scenes run with
# SemiImplicitEuler.
EXTREME = {
    "ball_corners": (lambda: caught(40.0, corners=True), 0.4),
    "ball_edges": (lambda: caught(40.0), 0.4),
    "curtains_free": (lambda: curtains(18, hung=False), 0.3),
    "curtains_hung": (lambda: curtains(18, hung=True), 0.3),
    "heap": (lambda: heap(8), 0.8),
    "magnets": (clamped, 0.3),
    "pushed": (pushed, 0.8),
}
COLUMNS = (
    "scene",
    "step",
    "rate",
    "seed",
    "frames",
    "intersecting",
    "unresolved",
    "withheld",
    "stretch",
    "excess",
    "parts",
    "seconds",
    "failure",
)


def perturbed(scene: ls.Scene, seed: int) -> ls.Scene:
    """Returns the scene with cloth vertices displaced at random; seed 0 leaves them unchanged.

    Pinned vertices are not displaced, because their scripted motion starts at their positions.
    """
    if seed == 0:
        return scene
    random = np.random.default_rng(seed)
    cloths = []
    for cloth in scene.cloths:
        mesh = cloth.mesh
        offsets = random.uniform(-PERTURBATION, PERTURBATION, mesh.vertices.shape)
        offsets[list(cloth.pins)] = 0.0
        moved = ls.TriangleMesh(
            mesh.vertices + offsets, mesh.triangles, uv=mesh.uv, uv_triangles=mesh.uv_triangles
        )
        cloths.append(cloth.replace(mesh=moved))
    return scene.replace(cloths=cloths)


Step = float | Literal["auto"]  # [s]


def opened(name: str) -> tuple[ls.Scene, ls.Integrator, float]:
    """Returns the scene `name`, with collisions, and its integrator and duration [s]."""
    if name in EXTREME:
        make, duration = EXTREME[name]
        return make(), ls.SemiImplicitEuler(), duration
    parameters, duration = SIZES[name]
    file = SceneFile.open(SCENES / f"{name}.py", parameters)
    return file.scene().replace(collisions=True), file.integrator, duration


def run(job: tuple[str, Step, float, int, float | None]) -> dict[str, object]:
    """Runs one job (scene, step [s], rate [1/s], seed, duration [s]); returns its row of the table.

    If the duration is None, that of the scene is used.
    """
    name, step, rate, seed, given = job
    scene, integrator, duration = opened(name)
    duration = given or duration
    sim = ls.Simulation(perturbed(scene, seed), integrator=integrator.replace(step=step), threads=1)
    frames = intersecting = unresolved = 0
    withheld, stretch, excess, parts, failure = 0.0, 1.0, 0.0, 1, ""
    start = time.perf_counter()
    try:
        for frame in sim.frames(duration=duration, rate=rate):
            frames += 1
            intersecting += count_intersections(sim.topology, frame).cloth
            unresolved += frame.report.contacts.unresolved
            withheld = max(withheld, frame.report.withheld.share)
            stretch = max(stretch, float(frame.stretch.max()))
            excess = max(excess, frame.report.limits.excess)
            parts = max(parts, frame.report.parts)
    except ls.SolverFailure as error:
        failure = str(error)
    seconds = time.perf_counter() - start
    values = (
        name,
        step,
        rate,
        seed,
        frames,
        intersecting,
        unresolved,
        withheld,
        stretch,
        excess,
        parts,
        round(seconds, 2),
        failure,
    )
    return dict(zip(COLUMNS, values, strict=True))


def step_of(text: str) -> Step:
    return "auto" if text == "auto" else float(text)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--scenes", nargs="+", choices=sorted({**SIZES, **EXTREME}), default=sorted(SIZES)
    )
    parser.add_argument(
        "--steps", nargs="+", type=step_of, default=[1e-3, 4e-3], help="[s], or auto"
    )
    parser.add_argument("--rate", type=float, default=25.0, help="frames per second")
    parser.add_argument(
        "--runs",
        type=int,
        default=10,
        help="starts of each scene and step; the first one is not perturbed",
    )
    parser.add_argument("--duration", type=float, help="[s] (default: that of each scene)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=Path, default=Path("certify.csv"))
    options = parsed(parser, scenes=["stack"], steps=[4e-3], runs=1, jobs=1, duration=0.04)
    done, rows = set(), []
    if options.out.exists():
        with options.out.open(newline="") as file:
            rows = list(csv.DictReader(file))
        done = {
            (row["scene"], step_of(row["step"]), float(row["rate"]), int(row["seed"]))
            for row in rows
        }
    else:
        options.out.write_text(",".join(COLUMNS) + "\n")
    jobs = [
        (name, step, options.rate, seed, options.duration)
        for seed in range(options.runs)
        for name in options.scenes
        for step in options.steps
    ]
    jobs = [job for job in jobs if job[:4] not in done]
    # Each run has its own process, so that no state carries over between runs.
    with multiprocessing.get_context("spawn").Pool(options.jobs, maxtasksperchild=1) as pool:
        for row in pool.imap_unordered(run, jobs):
            with options.out.open("a", newline="") as file:
                csv.DictWriter(file, COLUMNS).writerow(row)
            rows.append(row)
            print(
                *(f"{column} {row[column]}" for column in COLUMNS if row[column] != ""),
                sep="  ",
                flush=True,
            )
    bad = [row for row in rows if int(row["intersecting"]) > 0]
    failed = [row for row in rows if row["failure"]]
    print(
        f"{len(rows)} runs, {sum(int(row['frames']) for row in rows)} frames; "
        f"{len(bad)} runs with intersecting pairs, {len(failed)} that ended early"
    )
    raise SystemExit(1 if bad else 0)


if __name__ == "__main__":
    main()
