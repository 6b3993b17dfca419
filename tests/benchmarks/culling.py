"""Measures how many of the pairs that the broad phase finds are culled in an asynchronous step.

    python tests/benchmarks/culling.py --intervals 2.5e-3 1e-3

The scene `ribbon` runs once for each interval (length of a step [s]). Each sampled step has a row
with numbers of pairs of features:
- overlap: their 18-DOPs overlap over the next interval. The 18-DOPs enclose the motion that the
  search assumes (at 1.5 times the velocity), enlarged by half of the sum of the thickness and of an
  allowance for velocities that change.
- constant: their 18-DOPs overlap at constant velocity, without the allowance
- reach: their distance is also small enough for a contact within the interval (the candidates of
  core/collision/approach.h)
- registered: those of "reach" that are registered for events

"culled" is the fraction of the overlapping pairs that are not registered. The last row of an
interval has the sums. The exit status is 1, except with --smoke, if the sums of any interval show
that fewer than half of the overlapping pairs are culled. [Thomaszewski2010], figure 4.5, reports
more than half for its ribbon.
"""

from __future__ import annotations

import argparse
import warnings

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed

COLUMNS = ("overlap", "constant", "reach", "registered")
FASTER = 1.5  # assumed speed / speed at the start (core/collision/approach_bounds.h)


def allowance(step: float) -> float:
    """Returns the allowance for velocities that change within a step, as a distance [m]."""
    return min(0.3 * step, 60.0 * step**2)


def edges_of(triangles: np.ndarray) -> np.ndarray:
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)


def overlapping(sim: ls.Simulation, step: float, factor: float, margin: float) -> int:
    """Counts the pairs that involve cloth and whose 18-DOPs overlap over the next step.

    The 18-DOPs enclose motion at `factor` times the velocity, and grow by half of `margin` [m].
    """
    frame, topology = sim.frame(), sim.topology
    x = np.vstack([frame.positions, frame.body_vertices])
    n_cloth = len(frame.positions)
    triangles = np.vstack([topology.triangles, topology.body_triangles + n_cloth])
    v = np.vstack([sim.velocities, np.zeros((len(x) - n_cloth, 3))])  # obstacles are at rest
    vertex_face, edge_edge = ls.collision.candidates(
        x, x + factor * step * v, triangles, 0.5 * margin, threads=1
    )
    of_cloth = (vertex_face[:, 0] < n_cloth) | (triangles[vertex_face[:, 1], 0] < n_cloth)
    edges_of_cloth = (edges_of(triangles)[edge_edge, 0] < n_cloth).any(axis=1)
    return int(of_cloth.sum() + edges_of_cloth.sum())


def measure(scene: ls.Scene, step: float, times: np.ndarray) -> np.ndarray:
    """Prints a row for each of the times [s]. Returns the sums of the columns."""
    mesh = scene.cloths[0].mesh
    sides = np.diff(mesh.vertices[mesh.triangles][:, [0, 1, 2, 0]], axis=1)
    thickness = 0.1 * np.linalg.norm(sides, axis=2).mean()  # the default of Cloth
    sim = ls.Simulation(scene, integrator=ls.Asynchronous(step=step), threads=1)
    rows = []
    for at in times:
        while sim.time < at - 0.5 * step:
            sim.step()
        overlap = overlapping(sim, step, FASTER, thickness + allowance(step))
        constant = overlapping(sim, step, 1.0, thickness)
        sim.step()
        contacts = sim.report.contacts
        rows.append((overlap, constant, contacts.candidates, contacts.registered))
        show(f"{step:<9g} {at:6.2f}", rows[-1])
    return np.sum(rows, axis=0)


def show(name: str, row: tuple[int, ...] | np.ndarray) -> None:
    culled = 1.0 - row[3] / max(row[0], 1)
    print(f"{name:16}" + "".join(f" {n:11}" for n in row) + f" {culled:8.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=8000)
    parser.add_argument("--intervals", type=float, nargs="+", default=[2.5e-3, 1e-3], help="[s]")
    parser.add_argument("--duration", type=float, default=5.0, help="[s]")
    parser.add_argument("--every", type=float, default=0.1, help="time between samples [s]")
    options = parsed(parser, triangles=400, intervals=[2.5e-3], duration=0.6, every=0.1)
    scene = SceneFile.open(SCENES / "ribbon.py", {"triangles": options.triangles}).scene()
    times = np.arange(options.every, options.duration + 1e-9, options.every)
    print("interval  time [s]" + "".join(f" {name:>11}" for name in COLUMNS) + "   culled")
    little = False
    for step in options.intervals:
        total = measure(scene, step, times)
        show(f"{step:<9g}    sum", total)
        little |= 1.0 - total[3] / max(total[0], 1) < 0.5
    raise SystemExit(1 if little and not options.smoke else 0)


if __name__ == "__main__":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        main()
