"""Rest state of a drape for several time steps, from starts whose coordinates are perturbed by up
to 1e-6 m.

    python tests/benchmarks/at_rest.py [--triangles 3600 --steps 1e-3 4e-3 --runs 10 --jobs 2
    --out at_rest.csv]

The scene `drape` runs with air drag and damped bending until no vertex moves farther than 0.1 mm in
0.2 s, or until 20 s (--longest). Each run appends one row to the table; runs already in the table
are skipped. Folds form by chance, so the summary gives means over the runs with their standard
errors. The heights are those of the centre of mass, the lowest vertex and the middle vertex, above
the centre of the sphere.
"""

import argparse
import csv
import multiprocessing
import os
from pathlib import Path

import loomstone as ls
import numpy as np
from certify import perturbed
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed

CENTRE = np.array([0.03, 0.02, 0.0])  # centre of the sphere [m]
PAUSE, CALM = 0.2, 1e-4  # at rest: in PAUSE [s], no vertex moves farther than CALM [m]
COLUMNS = ("triangles", "step", "seed", "rest", "moved", "centre", "lowest", "middle")


def run(job: tuple[int, float, int, float]) -> dict[str, object]:
    """Runs one job (triangles, step [s], seed, latest end [s]) and returns its row of the table."""
    triangles, step, seed, longest = job
    file = SceneFile.open(SCENES / "drape.py", {"triangles": triangles})
    scene = file.scene()
    cloth = scene.cloths[0]
    cloth = cloth.replace(material=cloth.material.replace(bending_damping=0.02))
    scene = scene.replace(cloths=[cloth], air=ls.Air(normal_drag=1.3))
    sim = ls.Simulation(
        perturbed(scene, seed), integrator=file.integrator.replace(step=step), threads=1
    )
    middle = int(np.linalg.norm(np.asarray(cloth.mesh.vertices)[:, :2], axis=1).argmin())
    before, moved = sim.positions, np.inf
    while moved > CALM and sim.time < longest - 0.5 * PAUSE:
        for _ in range(round(PAUSE / step)):
            sim.step()
        now = sim.positions
        moved = float(np.linalg.norm(now - before, axis=1).max())
        before = now
    x = before - CENTRE
    areas = np.zeros(len(x))  # mass of each vertex up to a constant factor
    corners = np.asarray(cloth.mesh.vertices)[np.asarray(cloth.mesh.triangles)]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    for k in range(3):
        np.add.at(areas, np.asarray(cloth.mesh.triangles)[:, k], area)
    centre = areas @ x / areas.sum()
    row = (triangles, step, seed, round(sim.time, 3), moved, centre[2], x[:, 2].min(), x[middle, 2])
    return dict(zip(COLUMNS, row, strict=True))


def summary(rows: list[dict[str, str]]) -> None:
    for key in sorted({(int(r["triangles"]), float(r["step"])) for r in rows}):
        mine = [r for r in rows if (int(r["triangles"]), float(r["step"])) == key]
        rests = [float(r["rest"]) for r in mine]
        print(
            f"{key[0]} triangles, {1e3 * key[1]:g} ms, {len(mine)} runs, "
            f"at rest after {min(rests):.1f} to {max(rests):.1f} s [mm]:"
        )
        for name in ("centre", "lowest", "middle"):
            values = 1e3 * np.array([float(r[name]) for r in mine])
            error = values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan
            print(f"    {name:7s} {values.mean():8.3f} ± {error:.3f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", nargs="+", type=int, default=[3600])
    parser.add_argument("--steps", nargs="+", type=float, default=[1e-3, 4e-3])
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("at_rest.csv"))
    parser.add_argument("--longest", type=float, default=20.0, help="end of a run [s]")
    given = parsed(parser, triangles=[128], steps=[4e-3], runs=1, jobs=1, longest=0.2)
    os.environ["OMP_WAIT_POLICY"] = "passive"
    rows: list[dict[str, str]] = []
    if given.out.exists():
        with given.out.open() as file:
            rows = list(csv.DictReader(file))
    done = {(int(r["triangles"]), float(r["step"]), int(r["seed"])) for r in rows}
    jobs = [
        (n, h, seed, given.longest)
        for n in given.triangles
        for seed in range(given.runs)
        for h in given.steps
        if (n, h, seed) not in done
    ]
    with (
        given.out.open("a", newline="") as file,
        multiprocessing.get_context("spawn").Pool(given.jobs) as pool,
    ):
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for row in pool.imap_unordered(run, jobs, chunksize=1):
            writer.writerow(row)
            file.flush()
            rows.append({key: str(value) for key, value in row.items()})
    summary(rows)


if __name__ == "__main__":
    main()
