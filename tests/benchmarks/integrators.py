"""Energy over time of every integrator on the swinging sheet (scene `swing`), as a table and one plot.

    python tests/benchmarks/integrators.py [--columns 22 --rows 28 --duration 4 --out swing-energy.png]

A run that fails (the linearised midpoint needs damping, explicit Euler gains energy) is drawn up to where it failed.
"""

import argparse
import importlib.util
import time
from pathlib import Path

import numpy as np

import loomstone as ls

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "swing.py"


def swing(columns: int, rows: int) -> ls.Scene:
    spec = importlib.util.spec_from_file_location("swing", SCENE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.scene(columns=columns, rows=rows)


def total(report: ls.StepReport) -> float:
    return report.kinetic_energy + report.membrane_energy + report.bending_energy + report.gravity_energy


def run(scene: ls.Scene, integrator: ls.IntegratorOptions, duration: float) -> tuple[np.ndarray, np.ndarray, float, str]:
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    times, energies, failure = [0.0], [total(sim.report)], ""
    start = time.perf_counter()
    every = max(1, round(0.02 / integrator.step))
    try:
        while sim.time < duration - 1e-9:
            for _ in range(every):
                sim.step()
            times.append(sim.time)
            energies.append(total(sim.report))
            if not abs(energies[-1]) < 10.0:
                failure = f"diverged at {sim.time:.2f} s"
                break
    except ls.SolverFailure as error:
        failure = str(error).split(";")[0]
    return np.array(times), np.array(energies), time.perf_counter() - start, failure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--columns", type=int, default=22)
    parser.add_argument("--rows", type=int, default=28)
    parser.add_argument("--duration", type=float, default=4.0)
    parser.add_argument("--out", default="swing-energy.png")
    options = parser.parse_args()
    scene = swing(options.columns, options.rows)
    small = 2.5e-4 * 22 / options.columns
    integrators = {
        f"explicit Euler, {small:.2g} s": ls.ExplicitEuler(step=small),
        f"symplectic Euler, {small:.2g} s": ls.SymplecticEuler(step=small),
        "semi-implicit Euler, 1 ms": ls.SemiImplicitEuler(step=1e-3),
        "semi-implicit Euler, 20 ms": ls.SemiImplicitEuler(step=2e-2),
        "backward Euler, 4 ms": ls.BackwardEuler(step=4e-3),
        "implicit midpoint, linearised, 1 ms": ls.ImplicitMidpoint(step=1e-3),
        "implicit midpoint, nonlinear, 0.5 ms": ls.ImplicitMidpoint(step=5e-4, nonlinear=True, bending="implicit"),
        "BDF-2, 1 ms": ls.BDF2(step=1e-3),
    }
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9, 5))
    for name, integrator in integrators.items():
        times, energies, seconds, failure = run(scene, integrator, options.duration)
        fall = energies[0] - energies
        print(f"{name:38s} {seconds:7.1f} s  energy lost {1e3 * fall[-1]:8.3f} mJ  {failure}", flush=True)
        axes.plot(times, 1e3 * energies, label=name + (" (failed)" if failure else ""))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("total energy [mJ]")
    bottom, top = axes.get_ylim()
    axes.set_ylim(max(bottom, -600.0), min(top, 200.0))
    axes.legend(fontsize=8)
    figure.savefig(options.out, dpi=120, bbox_inches="tight")


if __name__ == "__main__":
    main()
