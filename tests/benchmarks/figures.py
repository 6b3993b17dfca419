"""Redraws figures of chapter 4 of [Thomaszewski2010], each as one picture in the directory --out.

    python tests/benchmarks/figures.py [--figures 4.2 4.4 4.5 4.7 4.8 4.9 --out out/figures]

4.2: trajectories and events of a chain of three elements; 4.4: the ribbon; 4.5: pairs that remain
after culling, and impacts left to certification at the end of a step; 4.7: the uneven hat; 4.8: the
walk over obstacles; 4.9: three instants of the walk with semi-implicit Euler and with asynchronous
steps. Figure 4.6 is the table of tests/benchmarks/integrators.py, and the table of figure 4.7 is
printed by tests/benchmarks/uneven.py.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from numpy.typing import NDArray
from smoke import SCENES, package, parsed

Pictures = dict[str, NDArray[np.uint8]]


def plotter() -> Any:
    package("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    return plt


def opened(name: str, options: argparse.Namespace) -> SceneFile:
    size = {} if options.triangles is None else {"triangles": options.triangles}
    return SceneFile.open(SCENES / f"{name}.py", size)


def seen(
    name: str,
    options: argparse.Namespace,
    times: tuple[float, ...],
    *,
    integrator: ls.Integrator | None = None,
    look: Callable[[ls.RenderOptions, ls.Frame], ls.RenderOptions] | None = None,
) -> Pictures:
    """Returns pictures of a scene at `times` [s]. Times after --duration are replaced by it."""
    file = opened(name, options)
    sim = ls.Simulation(file.scene(), integrator=integrator or file.integrator)
    wanted = [min(time, options.duration or max(times)) for time in times]
    pictures: Pictures = {}
    for frame in sim.frames(duration=max(wanted), rate=file.rate):
        for time in wanted:
            if abs(frame.time - time) < 0.5 / file.rate:
                shown = file.render.replace(width=options.width, height=options.height)
                shown = look(shown, frame) if look else shown
                renderer = ls.pictures.Renderer(sim.topology, shown)
                pictures[f"{frame.time:g} s"] = np.asarray(renderer.render(frame))
    return pictures


def strip(rows: dict[str, Pictures], path: Path) -> None:
    """Draws pictures side by side, one row for each name."""
    plt = plotter()
    columns = max(len(row) for row in rows.values())
    height, width, _ = next(iter(next(iter(rows.values())).values())).shape
    size = (3.2 * columns, (3.2 * height / width + 0.3) * len(rows))
    figure, axes = plt.subplots(len(rows), columns, figsize=size, squeeze=False)
    for line, (name, row) in zip(axes, rows.items(), strict=True):
        for axis in line:
            axis.set_axis_off()
        for axis, (time, picture) in zip(line, row.items(), strict=False):
            axis.imshow(picture)
            axis.set_title(f"{name}, {time}" if name else time, fontsize=8)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=0.95, wspace=0.02, hspace=0.12)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def chain(
    steps: tuple[float, ...], duration: float
) -> list[tuple[float, int, NDArray[np.float64]]]:
    """Returns the events (time [s], element, depths of the three masses [m]) of a chain.

    The chain of three springs hangs from depth 0 and is released from rest. Each spring is an
    element with its own step [s].
    """
    stiffness, masses = (100.0, 60.0, 40.0), np.array((2.0, 1.5, 1.0))
    shares = np.array([[2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0]])
    x, v, now = np.array((1.0, 2.0, 3.0)), np.zeros(3), 0.0
    due = sorted(
        (k * step, element)
        for element, step in enumerate(steps)
        for k in range(1, 1 + int(duration / step + 1e-9))
    )
    events = []
    for time, element in due:
        x, now = x + v * (time - now), time
        force = 9.81 * shares[element]
        pull = stiffness[element] * (x[element] - (x[element - 1] if element else 0.0) - 1.0)
        force[element] -= pull
        if element:
            force[element - 1] += pull
        v = v + steps[element] * force / masses
        events.append((time, element, x))
    return events


def figure_2(options: argparse.Namespace) -> None:
    plt = plotter()
    figure, axes = plt.subplots(2, 2, figsize=(9, 5), sharex=True, layout="constrained")
    colors = ("tab:blue", "tab:orange", "tab:green")
    for column, (name, steps) in enumerate(
        {"queue": (0.05, 0.08, 0.11), "nested": (0.05, 0.05, 0.1)}.items()
    ):
        events = chain(steps, 1.0)
        for element, color in enumerate(colors):
            times = [0.0] + [time for time, _, _ in events]
            places = [1.0 + element] + [x[element] for _, _, x in events]
            axes[0, column].plot(times, places, ".-", color=color, markersize=3, linewidth=0.8)
            own = [time for time, which, _ in events if which == element]
            axes[1, column].plot(own, [element] * len(own), "|", color=color, markersize=18)
        axes[0, column].set_title(name)
        axes[1, column].set_xlabel("time [s]")
        axes[0, column].invert_yaxis()
        axes[1, column].set_ylim(-0.6, 2.6)
        axes[1, column].set_yticks((0, 1, 2))
    axes[0, 0].set_ylabel("depth [m]")
    axes[1, 0].set_ylabel("element")
    figure.savefig(options.out / "4.2.png", dpi=150)


def figure_4(options: argparse.Namespace) -> None:
    strip({"": seen("ribbon", options, (0.4, 1.0, 1.6, 2.4, 5.0))}, options.out / "4.4.png")


def figure_5(options: argparse.Namespace) -> None:
    """Draws figure 4.5: pairs that remain after culling, and impacts left to certification."""
    plt = plotter()
    file = SceneFile.open(SCENES / "ribbon.py", {"triangles": options.triangles or 2000})
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for name, integrator in {
        "nested, 2.5 ms": ls.Asynchronous(),
        "queue, 10 ms": ls.Asynchronous(schedule="queue", step=1e-2),
    }.items():
        sim = ls.Simulation(file.scene(), integrator=integrator)
        rows = []
        while sim.time < (options.duration or 2.0) - 1e-9:
            sim.step()
            contacts = sim.report.contacts
            rows.append((sim.time, contacts.candidates, contacts.registered, contacts.impacts))
        time, candidates, registered, impacts = np.array(rows, float).T
        if registered.any():
            share = 100.0 * registered / np.maximum(candidates, 1.0)
            left.plot(time, share, linewidth=0.8, label=name)
        right.plot(time, np.cumsum(impacts), linewidth=0.8, label=name)
    left.set_ylabel("pairs left after culling [%]")
    right.set_ylabel("impacts left to certification, sum")
    right.set_yscale("symlog")
    right.legend(fontsize=8)
    for axis in (left, right):
        axis.set_xlabel("time [s]")
        axis.grid(alpha=0.3)
    figure.savefig(options.out / "4.5.png", dpi=150)


def figure_7(options: argparse.Namespace) -> None:
    strip({"": seen("uneven", options, (0.0, 0.28, 0.32, 0.44, 4.0))}, options.out / "4.7.png")


def figure_8(options: argparse.Namespace) -> None:
    times = (0.6, 1.2, 2.0, 3.2, 4.2)
    pictures = seen(
        "obstacle_walk", options, times, look=lambda look, frame: near(look, frame, 4.4)
    )
    strip({"": pictures}, options.out / "4.8.png")


def near(look: ls.RenderOptions, frame: ls.Frame, distance: float = 2.4) -> ls.RenderOptions:
    """Returns options with a camera about `distance` [m] from the middle of the cloth."""
    x, _, z = frame.positions.mean(axis=0)
    eye = np.array((x, 0.0, z)) + distance * np.array((0.4, -0.9, 0.12))
    camera = ls.Camera(fit=False, eye=eye, target=(x, 0.0, z), field_of_view_degrees=34.0)
    return look.replace(camera=camera)


def figure_9(options: argparse.Namespace) -> None:
    rows = {
        name: seen("obstacle_walk", options, (1.2, 2.6, 4.2), integrator=integrator, look=near)
        for name, integrator in {
            "semi-implicit Euler, 1 ms": ls.SemiImplicitEuler(step=1e-3, accuracy=None),
            "asynchronous": None,
        }.items()
    }
    strip(rows, options.out / "4.9.png")


FIGURES = {
    "4.2": figure_2,
    "4.4": figure_4,
    "4.5": figure_5,
    "4.7": figure_7,
    "4.8": figure_8,
    "4.9": figure_9,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--figures", nargs="+", choices=list(FIGURES), default=list(FIGURES))
    parser.add_argument("--out", type=Path, default=Path("out/figures"))
    parser.add_argument("--triangles", type=int, help="(default: those of the scenes)")
    parser.add_argument("--duration", type=float, help="longest [s] (default: of each figure)")
    parser.add_argument("--width", type=int, default=720, help="of one picture [pixels]")
    parser.add_argument("--height", type=int, default=480, help="of one picture [pixels]")
    options = parsed(
        parser, figures=["4.2", "4.5", "4.7"], triangles=200, duration=0.04, width=64, height=48
    )
    options.out.mkdir(parents=True, exist_ok=True)
    for figure in options.figures:
        FIGURES[figure](options)
        print(options.out / f"{figure}.png", flush=True)


if __name__ == "__main__":
    main()
