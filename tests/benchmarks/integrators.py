"""All integrators on the swinging sheet of scenes/swing_integrators.py: a table of times, energy
over time as a plot, and pictures at one instant side by side, as in figures 4.1 and 4.6 of
[Thomaszewski2010].

    python tests/benchmarks/integrators.py [--triangles 5016 --duration 4 --instant 2.2 --limit 0.1
    --plot integrators.png --pictures sheets.png]
    python tests/benchmarks/integrators.py --survive

With --survive, the program instead finds the least of several viscosities with which a run survives
its whole duration. It does this for symplectic Euler, explicit Euler and the linearised midpoint
rule, each with several lengths of the step. A run has not survived if it fails, or if its energy
rises above its initial value by a tenth of the energy that the fall of the sheet releases. Without
--survive, the plot shows failed runs up to their failure.
"""

import argparse
import time
from typing import NamedTuple

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from numpy.typing import NDArray
from smoke import SCENES, package, parsed

SCENE = SCENES / "swing_integrators.py"
FALL = 0.5 * 2.0**2 * 9.81 * 1.0  # weight of the sheet times half its size [J]
TRIED = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3)  # viscosities [N s/m]


class Swing(NamedTuple):
    """A run: energies [J] at `times` [s], largest stretch, cost, why it ended early ("" if it did
    not), and a picture.
    """

    times: list[float]
    energies: list[float]
    stretch: float  # largest stretch of the run
    seconds: float  # processor time per second of motion
    failure: str
    picture: NDArray[np.uint8] | None

    @property
    def kept(self) -> float:
        """Energy kept: 1 + (E - E0) / FALL, where E is the mean of the last tenth of `energies`,
        and E0 is the first of them.
        """
        late = self.energies[-max(1, len(self.energies) // 10) :]
        return 1.0 + float(np.mean(late) - self.energies[0]) / FALL


def total(report: ls.StepReport) -> float:
    energy = report.energy
    return energy.kinetic + energy.membrane + energy.bending + energy.gravity


def swing(
    file: SceneFile, integrator: ls.Integrator, options: argparse.Namespace, look: bool = False
) -> Swing:
    """Runs until the end, a failure, or a rise of the energy by a tenth of FALL."""
    sim = ls.Simulation(file.scene(), integrator=integrator, threads=1)
    times, energies = [0.0], [total(sim.report)]
    stretch, failure, seconds = 1.0, "", 0.0
    picture = None
    try:
        while sim.time < options.duration - 1e-9 and not failure:
            start = time.process_time()
            sim.step()
            seconds += time.process_time() - start
            stretch = max(stretch, sim.report.strain.stretch)
            if sim.time - times[-1] > 0.01 - 1e-9:
                times.append(sim.time)
                energies.append(total(sim.report))
            if not total(sim.report) - energies[0] < 0.1 * FALL:
                failure = f"gains energy at {sim.time:.2f} s"
            if look and picture is None and sim.time >= options.instant:
                picture = drawn(sim, file)
    except ls.SolverFailure as error:
        failure = f"fails at {sim.time:.2f} s: {str(error).split(';')[0]}"
    motion = max(sim.time, 1e-9)
    return Swing(times, energies, stretch, seconds / motion, failure, picture)


def drawn(sim: ls.Simulation, file: SceneFile) -> NDArray[np.uint8]:
    camera = ls.Camera(eye=(0.6, -1.0, 0.2))  # fitted: only the direction of view counts
    look = file.render.replace(width=480, height=400, camera=camera)
    return np.asarray(ls.pictures.Renderer(sim.topology, look).render(sim.frame()))


def cases() -> dict[str, tuple[ls.Integrator, float]]:
    """Returns the integrator and the viscosity [N s/m] of each case by its name."""
    fixed = {"accuracy": None}
    return {
        "semi-implicit Euler, 33 ms": (ls.SemiImplicitEuler(step=1 / 30, **fixed), 0.0),
        "semi-implicit Euler, 0.75 ms": (ls.SemiImplicitEuler(step=7.5e-4, **fixed), 0.0),
        "backward Euler, 4 ms": (ls.BackwardEuler(step=4e-3, **fixed), 0.0),
        "BDF-2, 1 ms": (ls.BDF2(step=1e-3, **fixed), 0.0),
        "midpoint, linearised, 1 ms": (ls.ImplicitMidpoint(step=1e-3, **fixed), 0.0),
        "midpoint, nonlinear, 2 ms": (ls.NonlinearMidpoint(step=2e-3, **fixed), 0.0),
        "explicit Euler, 0.05 ms": (ls.ExplicitEuler(step=5e-5), 0.03),
        "symplectic Euler, 0.125 ms": (ls.SymplecticEuler(step=1.25e-4), 0.0),
        "asynchronous": (ls.Asynchronous(predicted=0.075, present=0.1), 0.0),
        "asynchronous, queue, 10 ms": (
            ls.Asynchronous(schedule="queue", step=1e-2, predicted=0.075, present=0.1),
            0.0,
        ),
    }


def opened(options: argparse.Namespace, viscosity: float) -> SceneFile:
    values = {"triangles": options.triangles, "viscosity": viscosity, "limit": options.limit}
    return SceneFile.open(SCENE, values)


def compare(options: argparse.Namespace) -> None:
    runs = {}
    print(f"{'':30s} {'s / s':>7s} {'energy kept':>11s} {'stretch':>8s} {'viscosity':>9s}")
    for name, (integrator, viscosity) in cases().items():
        run = runs[name] = swing(opened(options, viscosity), integrator, options, look=True)
        print(
            f"{name:30s} {run.seconds:7.2f} {run.kept:11.4f} {run.stretch:8.3f} {viscosity:9.3g}"
            f"  {run.failure}",
            flush=True,
        )
    draw_energies(runs, options.plot)
    draw_sheets(runs, options.pictures, options.instant)


def survive(options: argparse.Namespace) -> None:
    for name, integrator, steps in (
        ("symplectic Euler", ls.SymplecticEuler(), (1e-3, 5e-4, 2.5e-4)),
        ("midpoint, linearised", ls.ImplicitMidpoint(accuracy=None), (3e-2, 1e-2, 1e-3)),
        ("explicit Euler", ls.ExplicitEuler(), (8e-4, 4e-4, 2e-4, 1e-4, 5e-5)),
    ):
        for step in steps:
            runs = (
                (
                    viscosity,
                    swing(opened(options, viscosity), integrator.replace(step=step), options),
                )
                for viscosity in TRIED
            )
            least = next((viscosity for viscosity, run in runs if not run.failure), None)
            found = "no viscosity survives" if least is None else f"viscosity {least:g} N s/m"
            print(f"{name:22s} {1e3 * step:g} ms: {found}", flush=True)


def draw_energies(runs: dict[str, Swing], path: str) -> None:
    package("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9, 5))
    for name, run in runs.items():
        label = name + (" (failed)" if run.failure else "")
        axes.plot(run.times, np.array(run.energies) - run.energies[0], label=label, linewidth=1.4)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("kinetic + elastic + gravity energy above the start [J]")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5))
    figure.savefig(path, dpi=110, bbox_inches="tight")


def draw_sheets(runs: dict[str, Swing], path: str, instant: float) -> None:
    """Draws the pictures of all runs that reached the instant."""
    package("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    shown = {name: run.picture for name, run in runs.items() if run.picture is not None}
    if not shown:
        return
    rows = min(2, len(shown))
    columns = -(-len(shown) // rows)
    figure, axes = plt.subplots(
        rows, columns, figsize=(3.2 * columns, 3.4 * rows), squeeze=False, layout="constrained"
    )
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, (name, picture) in zip(axes.flat, shown.items(), strict=False):
        axis.imshow(picture)
        axis.set_title(name, fontsize=9)
    figure.suptitle(f"{instant:g} s", fontsize=9)
    figure.savefig(path, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, default=5016)
    parser.add_argument("--duration", type=float, default=4.0, help="[s]")
    parser.add_argument("--instant", type=float, default=2.2, help="of the pictures [s]")
    parser.add_argument("--limit", type=float, default=0.1, help="of strain, 0 for none [1]")
    parser.add_argument("--plot", default="integrators.png")
    parser.add_argument("--pictures", default="sheets.png")
    parser.add_argument("--survive", action="store_true")
    options = parsed(parser, triangles=60, duration=0.04, instant=0.02)
    if options.survive:
        survive(options)
    else:
        compare(options)


if __name__ == "__main__":
    main()
