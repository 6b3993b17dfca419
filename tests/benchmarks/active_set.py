"""Measures the time that the active set saves in the scene sphere_slide if coloured Gauss-Seidel
alone enforces the strain limits. [Thomaszewski2010] reports 2.92 s per frame without the active set
and 1.53 s with it.

    python tests/benchmarks/active_set.py --limits 0.04 0.03 0.028 0.025

The scene's own limits need about one sweep per step, so --limits replaces them along weft and warp.
Each run takes 21 steps from a state at 0.15 s. The time of limiting in a step is the least wall
time over several runs. The last column shows whether the end states with and without the active set
are bitwise identical.
"""

from __future__ import annotations

import argparse

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed

SCENE = SCENES / "sphere_slide.py"


def simulation(triangles: int, limit: float, active: bool) -> ls.Simulation:
    file = SceneFile.open(SCENE, {"triangles": triangles})
    scene = file.scene()
    cloth = scene.cloths[0].replace(strain_limit=ls.StrainLimit(limit, limit, 0.4))
    options = ls.LimitOptions(in_solve=False, active_set=active)
    return ls.Simulation(
        scene.replace(cloths=[cloth], limits=options), integrator=file.integrator, threads=1
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--limits", type=float, nargs="+", default=[0.04, 0.03, 0.028, 0.025])
    parser.add_argument("--triangles", type=int, default=14476)
    parser.add_argument("--steps", type=int, default=21)
    parser.add_argument("--runs", type=int, default=3)
    options = parsed(parser, triangles=400, steps=2, runs=1, limits=[0.03])
    file = SceneFile.open(SCENE, {"triangles": options.triangles})
    start = ls.Simulation(file.scene(), integrator=file.integrator, threads=1)
    while start.time < 0.15:
        start.step()
    state = np.array(start.positions), np.array(start.velocities)
    print(
        "limit  sweeps a step  evaluations, in sweeps: active full  "
        "ms a step: active full  ratio  same bits"
    )
    for limit in options.limits:
        sweeps, evaluations, times, digests = [], [], [], []
        for active in (True, False):
            least = np.full(options.steps, np.inf)
            for _ in range(options.runs):
                sim = simulation(options.triangles, limit, active)
                sim.positions, sim.velocities = state
                done = looked = 0
                for step in range(options.steps):
                    sim.step()
                    done, looked = (
                        done + sim.report.limits.sweeps,
                        looked + sim.report.limits.evaluations,
                    )
                    least[step] = min(least[step], sim.report.seconds.limit)
            sweeps.append(done / options.steps)
            evaluations.append(looked / options.steps / options.triangles)
            times.append(1e3 * least.mean())
            digests.append(sim.digest())
        assert sweeps[0] == sweeps[1]
        print(
            f"{limit:5.3f} {sweeps[0]:8.2f}        {evaluations[0]:8.2f} "
            f"{evaluations[1]:8.2f}        {times[0]:8.3f} {times[1]:8.3f} "
            f"{times[0] / times[1]:8.2f}  {digests[0] == digests[1]}",
            flush=True,
        )


if __name__ == "__main__":
    main()
