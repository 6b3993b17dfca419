"""Cost of asynchronous steps and of other integrators on the uneven mesh of scenes/uneven.py.

    python tests/benchmarks/uneven.py [--triangles 2304 --fine 0.003 0.00166 --bending 1e-3
    --damping 1e-5 --duration 4]

In the first tables, one for each value of --fine, the cloth (a hat) hangs from a point of its brim,
without collisions. These tables list updates of triangles and processor time of stepping, both per
second of motion. The columns "fewer" and "less" give the updates and the time of symplectic Euler
divided by those of the row. Asynchronous steps and the step of symplectic Euler are the same share
of their limits of stability. With the default rigidity, bending limits the steps at the tip; with
`--bending 1e-5 --damping 0`, the membrane does. In the last table, for the first value of --fine,
the hat falls on the floor. The table lists the processor time of stepping and of collision handling
per second of motion, and the reason if a run ends early. For asynchronous steps, stepping includes
the contacts at events.
"""

import argparse
import time
from typing import NamedTuple

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed

# Step divided by its limit of stability, for Asynchronous() and for SymplecticEuler(step="auto")
SHARE, SHARE_OF_AUTO = 0.4, 0.5


def opened(options: argparse.Namespace, fine: float) -> ls.Scene:
    names = ("triangles", "bending", "damping")
    values = {name: getattr(options, name) for name in names}
    return SceneFile.open(SCENES / "uneven.py", {**values, "fine": fine}).scene()


def reference_step(scene: ls.Scene) -> float:
    """Returns the step [s] of symplectic Euler that is SHARE times its limit of stability, like the
    steps of Asynchronous.
    """
    sim = ls.Simulation(scene, integrator=ls.SymplecticEuler(step="auto"), threads=1)
    sim.step()
    return SHARE / SHARE_OF_AUTO * sim.report.length


def hung(scene: ls.Scene) -> ls.Scene:
    cloth = scene.cloths[0]
    lowest = int(np.argmin(cloth.mesh.vertices[:, 0]))
    return scene.replace(cloths=[cloth.replace(pins=[lowest])], obstacles=[], collisions=False)


class Cost(NamedTuple):
    """Cost of a run per second of motion; times are processor times [s]."""

    updates: float  # number of updates of triangles
    stepping: float
    collisions: float
    failure: str  # why the run ended early, or ""


def cost(scene: ls.Scene, integrator: ls.Integrator, duration: float) -> Cost:
    """Runs the scene and returns its cost. If a step fails, the run ends before this step.

    Processor time is divided among the stages in proportion to their wall times.
    """
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    updates = stepping = collisions = wall = 0.0
    failure, start = "", time.process_time()
    try:
        while sim.time < duration - 1e-9:
            sim.step()
            updates += sim.report.solver.events or scene.cloths[0].mesh.n_triangles
            seconds = sim.report.seconds
            stepping += seconds.integrate
            collisions += seconds.proximity + seconds.certify
            wall += sum(seconds.to_dict().values())
    except ls.SolverFailure as error:
        failure = f"fails at {sim.time:.2f} s: {str(error).split(';')[0]}"
    share = (time.process_time() - start) / wall / sim.time
    return Cost(updates / sim.time, share * stepping, share * collisions, failure)


def compare(options: argparse.Namespace, fine: float) -> None:
    scene = opened(options, fine)
    ratio = ls.meshes.quality(scene.cloths[0].mesh)["area_ratio"]
    step = reference_step(scene)
    print(
        f"{options.triangles} triangles, areas {ratio:.0f}:1, step of symplectic Euler {step:.3g} s"
    )
    print(f"  {'':28s} {'updates / s':>12s} {'s / s':>8s} {'fewer':>6s} {'less':>6s}")
    reference = None
    for name, integrator in {
        "symplectic Euler": ls.SymplecticEuler(step=step),
        "nested": ls.Asynchronous(),
        "nested, bending with membrane": ls.Asynchronous(bending_multiple=0.0),
        "queue": ls.Asynchronous(schedule="queue"),
        "queue, 10 ms": ls.Asynchronous(schedule="queue", step=1e-2),
    }.items():
        run = cost(hung(scene), integrator, options.hung)
        reference = reference or run
        fewer, less = reference.updates / run.updates, reference.stepping / run.stepping
        print(
            f"  {name:28s} {run.updates:12.3g} {run.stepping:8.3f} {fewer:6.2f} {less:6.2f}",
            flush=True,
        )


def fall(options: argparse.Namespace) -> None:
    scene = opened(options, options.fine[0])
    step = reference_step(scene)
    print(f"{options.duration:g} s of the fall, processor time per second")
    print(f"  {'':28s} {'stepping':>8s} {'collisions':>10s}")
    for name, integrator in {
        "backward Euler, 4 ms": ls.BackwardEuler(step=4e-3, accuracy=None),
        "semi-implicit Euler, 1 ms": ls.SemiImplicitEuler(step=1e-3, accuracy=None),
        "midpoint, linearised, 1 ms": ls.ImplicitMidpoint(step=1e-3, accuracy=None),
        "symplectic Euler": ls.SymplecticEuler(step=step),
        "nested": ls.Asynchronous(),
        "queue, 10 ms": ls.Asynchronous(schedule="queue", step=1e-2),
    }.items():
        run = cost(scene, integrator, options.duration)
        print(f"  {name:28s} {run.stepping:8.2f} {run.collisions:10.2f}  {run.failure}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, default=2304)
    parser.add_argument(
        "--fine", type=float, nargs="+", default=[0.003, 0.00166], help="smallest edges [m]"
    )
    parser.add_argument("--bending", type=float, default=1e-3, help="rigidity [N m]")
    parser.add_argument("--damping", type=float, default=1e-5, help="of bending [s]")
    parser.add_argument("--duration", type=float, default=4.0, help="of the fall [s]")
    parser.add_argument("--hung", type=float, default=0.5, help="duration when hung [s]")
    options = parsed(parser, triangles=200, fine=[0.003], duration=0.02, hung=0.02)
    for fine in options.fine:
        compare(options, fine)
    fall(options)


if __name__ == "__main__":
    main()
