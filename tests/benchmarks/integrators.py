"""Energy over time of every integrator on the swinging sheet (scene `swing`), as a table and a
plot.

    python tests/benchmarks/integrators.py [--columns 22 --rows 28 --duration 4
    --out docs/images/integrator_energy.png]

Explicit Euler gains energy and fails; a failed run is drawn up to its failure. The full size takes
ten minutes.
"""

import argparse
import importlib.util
import time

import loomstone as ls
import numpy as np
from smoke import SCENES, package, parsed

SCENE = SCENES / "swing.py"


def swing(columns: int, rows: int) -> ls.Scene:
    spec = importlib.util.spec_from_file_location("swing", SCENE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.scene(columns=columns, rows=rows)


def total(report: ls.StepReport) -> float:
    return (
        report.energy.kinetic
        + report.energy.membrane
        + report.energy.bending
        + report.energy.gravity
    )


def run(
    scene: ls.Scene, integrator: ls.Integrator, duration: float
) -> tuple[np.ndarray, np.ndarray, float, str]:
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
        if np.isfinite(total(sim.report)):
            times.append(sim.time)
            energies.append(total(sim.report))
    return np.array(times), np.array(energies), time.perf_counter() - start, failure


def integrators(columns: int) -> dict[str, ls.Integrator]:
    small = 2.5e-4 * 22 / columns  # [s], less than the travel time of a wave along an edge
    return {
        f"explicit Euler, {1e3 * small:.3g} ms": ls.ExplicitEuler(step=small),
        f"symplectic Euler, {1e3 * small:.3g} ms": ls.SymplecticEuler(step=small),
        "implicit midpoint, nonlinear, 2 ms": ls.NonlinearMidpoint(step=2e-3, bending="implicit"),
        "implicit midpoint, linearised, 1 ms": ls.ImplicitMidpoint(step=1e-3),
        "BDF-2, 1 ms": ls.BDF2(step=1e-3),
        "semi-implicit Euler, 1 ms": ls.SemiImplicitEuler(step=1e-3),
        "backward Euler, 4 ms": ls.BackwardEuler(step=4e-3),
        "semi-implicit Euler, 20 ms": ls.SemiImplicitEuler(step=2e-2),
    }


def draw(runs: dict[str, tuple[np.ndarray, np.ndarray, float, str]], path: str) -> None:
    """Plots `runs`: name -> (times [s], total energies [J], seconds taken, reason of failure)."""
    package("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9, 5))
    held = [energies for _, energies, _, failure in runs.values() if not failure]
    low, high = min(map(np.min, held)), max(map(np.max, held))
    margin = 0.1 * (high - low)
    for name, (times, energies, _, failure) in runs.items():
        # Energies of a failed run can lie outside the range of the plot.
        shown = (energies > low - margin) & (energies < high + margin)
        (line,) = axes.plot(
            times[shown],
            1e3 * energies[shown],
            label=name + (" (failed)" if failure else ""),
            linewidth=1.4,
        )
        if failure:
            axes.plot(
                times[shown][-1],
                1e3 * energies[shown][-1],
                "x",
                color=line.get_color(),
                markersize=9,
                markeredgewidth=2,
            )
    axes.set_xlabel("time [s]")
    axes.set_ylabel("kinetic + elastic + gravity energy [mJ]")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5))
    figure.savefig(path, dpi=110, bbox_inches="tight")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--columns", type=int, default=44)
    parser.add_argument("--rows", type=int, default=57)
    parser.add_argument("--duration", type=float, default=4.0)
    parser.add_argument("--out", default="swing-energy.png")
    options = parsed(parser, columns=6, rows=8, duration=0.04)
    scene = swing(options.columns, options.rows)
    runs = {}
    for name, integrator in integrators(options.columns).items():
        runs[name] = run(scene, integrator, options.duration)
        _, energies, seconds, failure = runs[name]
        lost = 1e3 * (energies[0] - energies[-1])
        print(
            f"{name:38s} {seconds:7.1f} s  energy lost {lost:8.3f} mJ  {failure}",
            flush=True,
        )
    draw(runs, options.out)


if __name__ == "__main__":
    main()
