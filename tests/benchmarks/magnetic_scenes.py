"""Table 6.1 of [Thomaszewski2010]: times of the magnetic scenes with dipole cells and with the
accurate engine (core/magnetics/forces/interaction.h), in one run on one thread.

    python tests/benchmarks/magnetic_scenes.py [--steps 400]
            [--scenes toy_magnets lift levitation]

- cells: dipoles that represent all magnets; a soft body counts as one unless its response is
  explicit
- magnetics: one evaluation of all forces and torques, including induced moments
- substeps: evaluations per step
- rigid: remaining time of a step
- frames/s: frames (40 ms of simulated time each) per second
- gain: time of the sum over all pairs of leaves (smallest cells) divided by that of the sum over
  fronts, which have larger cells for distant magnets (equation (6.19) of [Thomaszewski2010]);
  timed only for magnets with cells, if there are at least two. For this, bodies are moved to their
  initial positions but not rotated, and obstacles are not moved to their scripted poses.

Times are processor times in milliseconds. The time of an evaluation is the minimum of repeats,
averaged over about ten instants of the run. The time of a step is the mean over the run.
"""

import argparse
import importlib.util
import time
from types import ModuleType

import loomstone as ls
import numpy as np
from loomstone import magnetics as M
from smoke import SCENES, parsed

# Density of the cells [1/m^3], chosen to give about as many cells as in [Thomaszewski2010].
DENSITY = {"toy_magnets": 7e7, "lift": 2.6e8, "figures": 2e7, "levitation": 3e7, "dragon": 1e7}
# Columns of table 6.1 in [Thomaszewski2010], measured at 2.4 GHz: cells, magnetics [ms], rigid [ms]
# and gain.
THESIS = {
    "toy_magnets": (48, 0.29, 0.09, 1.30),
    "lift": (256, 3.9, 0.25, 3.76),
    "figures": (128, 1.65, 2.39, 1.97),
    "levitation": (142, 0.33, 0.02, 5.97),
    "dragon": (1824, 53.1, 2.76, 6.72),
}
# Scene parameters other than the defaults, with which scenes use cells as in [Thomaszewski2010].
AS_CELLS: dict[str, dict[str, str]] = {"figures": {"response": "explicit"}}


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, SCENES / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def with_cells(scene: ls.Scene, density: float) -> ls.Scene:
    """Returns the scene with dipole cells for hard magnets, and induced dipoles (degree 1) for soft
    spheres.

    The cells have the given density [1/m^3], which also replaces that of bodies with explicit
    response.
    """

    def in_cells(magnet: ls.Magnet) -> ls.Magnet:
        soft = magnet.source
        if magnet.response == "explicit":
            return magnet.replace(density=density)
        if isinstance(soft, M.MagneticBody):
            return magnet.replace(source=M.cells(soft, density=density))
        if "soft_sphere" not in repr(soft):
            return magnet
        radius = np.cbrt(0.75 * soft.volume / np.pi)
        dipole = M.soft_sphere(radius=radius, susceptibility=soft.susceptibility, degree=1)
        return magnet.replace(source=dipole.at(soft.position, soft.orientation))

    return scene.replace(magnets=[in_cells(magnet) for magnet in scene.magnets])


def least(function: object, repeats: int = 5, inner: int = 20) -> float:
    """Processor time of a call [ms]: the smallest of `repeats` means over `inner` calls."""
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(inner):
            function()  # type: ignore[operator]
        best = min(best, (time.process_time() - start) / inner)
    return 1e3 * best


def gain(scene: ls.Scene, density: float) -> tuple[int, float]:
    """Returns the columns "cells" and "gain" of the table (see the top of this file).

    The gain is NaN if fewer than two magnets have cells.
    """
    places = {body.name: np.array(body.position) for body in scene.bodies}
    carriers = {body.name: body.mesh for body in (*scene.bodies, *scene.obstacles)}
    fronts, whole, leaves = [], [], 0
    for magnet in scene.magnets:
        body = magnet.source
        if magnet.response == "explicit":
            body = M.mesh(carriers[magnet.body], polarization=(0, 0, 1))
        elif not isinstance(body, M.MagneticBody):
            leaves += 1
            continue
        for separation, bodies in ((3.0, fronts), (1e6, whole)):
            made = M.cells(body, density=density, separation=separation)
            bodies.append(made.moved(places.get(magnet.body, np.zeros(3))))
        leaves += len(M.cell_level(whole[-1], 99)[0])
    if len(whole) < 2:
        return leaves, float("nan")
    return leaves, least(lambda: M.forces(whole, threads=1)) / least(
        lambda: M.forces(fronts, threads=1)
    )


def measure(scene: ls.Scene, integrator: ls.Integrator, steps: int) -> tuple[float, float, float]:
    """Returns milliseconds per evaluation, evaluations per step and milliseconds per step."""
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    evaluations, spent, substeps = [], 0.0, 0
    for step in range(steps):
        if step % max(1, steps // 10) == 0:
            evaluations.append(least(sim.magnetic_forces))
        start = time.process_time()
        sim.step()
        spent += time.process_time() - start
        substeps += sim.report.magnets.substeps
    return float(np.mean(evaluations)), substeps / steps, 1e3 * spent / steps


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=400)
    parser.add_argument(
        "--scenes", nargs="*", default=[name for name in THESIS if (SCENES / f"{name}.py").exists()]
    )
    arguments = parsed(parser, steps=2, scenes=["toy_magnets"])
    print(
        f"{'scene':14}{'engine':10}{'cells':>7}{'magnetics':>11}{'substeps':>10}"
        f"{'rigid':>9}{'step':>9}{'frames/s':>10}{'gain':>7}"
    )
    for name in arguments.scenes:
        module = load(name)
        scene = module.scene()
        thesis = module.scene(**AS_CELLS.get(name, {}))
        as_cells = with_cells(thesis, DENSITY[name])
        leaves, faster = gain(thesis, DENSITY[name])
        for engine in ("accurate", "cells"):
            chosen = scene if engine == "accurate" else as_cells
            one, substeps, step = measure(chosen, module.integrator, arguments.steps)
            rigid = step - substeps * one
            frames = 1.0 / (step * 1e-3 * 0.04 / module.integrator.step)
            cells = f"{leaves:7}{one:11.4f}" if engine == "cells" else f"{'':7}{one:11.4f}"
            print(
                f"{name:14}{engine:10}{cells}{substeps:10.1f}{rigid:9.3f}{step:9.3f}{frames:10.1f}"
                + (f"{faster:7.2f}" if engine == "cells" and faster == faster else ""),
                flush=True,
            )
        cells, magnetics, rigid, their_gain = THESIS[name]
        total = magnetics + rigid
        print(
            f"{'':14}{'thesis':10}{cells:7}{magnetics:11.2f}{1:10}"
            f"{rigid:9.2f}{total:9.2f}{25 / total:10.1f}{their_gain:7.2f}"
        )


if __name__ == "__main__":
    main()
