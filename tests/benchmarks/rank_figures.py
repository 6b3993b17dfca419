"""Redraws figures of chapter 5 of [Thomaszewski2010], each as one picture in the directory --out.

    python tests/benchmarks/rank_figures.py [--figures 5.1 5.4 5.5 5.6 --out out/figures]

Here, a partition is the part of the mesh that one of 12 ranks owns; neighbouring partitions have
different colours. 5.1: layers of cloth that lie on one another; 5.4: a dress decomposed into 12
partitions; 5.5 and 5.6: the scenes table_cloth and wave_bar (above), and their partitions (below).
"""

import argparse
from itertools import count
from pathlib import Path

import loomstone as ls
import numpy as np
from figures import Pictures, opened, seen, strip
from numpy.typing import NDArray
from smoke import parsed

RANKS = 12
ROWS_PER_BLOCK = 128  # ranks own whole blocks of rows (core/parallel/row_layout.cpp)
TIMES = {"table_cloth": (0.2, 0.4, 1.0), "wave_bar": (0.2, 0.4, 1.0)}  # times of the pictures [s]


def owners(sim: ls.Simulation) -> NDArray[np.int64]:
    """Returns the rank that owns each triangle: the lowest rank that owns one of its vertices."""
    rows = len(sim.vertex_order)
    blocks = -(-rows // ROWS_PER_BLOCK)
    starts = np.minimum(rows, np.arange(RANKS + 1) * blocks // RANKS * ROWS_PER_BLOCK)
    of_vertex = np.searchsorted(starts, sim.vertex_order, side="right") - 1
    return of_vertex[sim.topology.triangles].min(axis=1)


def colors(triangles: NDArray[np.int32], parts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Returns a colour index for each triangle. Parts that share a vertex differ in colour.

    `parts` contains the part of each triangle, a number below RANKS.
    """
    touching = np.zeros((triangles.max() + 1, RANKS), bool)
    for corner in triangles.T:
        touching[corner, parts] = True
    adjacent = touching.T.astype(int) @ touching > 0
    chosen: list[int] = []
    for part in range(RANKS):
        taken = {chosen[other] for other in range(part) if adjacent[part, other]}
        chosen.append(next(color for color in count() if color not in taken))
    return np.array(chosen)[parts]


def painted(sim: ls.Simulation, scene: ls.Scene, positions: NDArray[np.float64]) -> ls.Simulation:
    """Returns a simulation that shows the partitions of the only cloth of a scene.

    The simulation has one cloth for each colour of the partitions.
    """
    cloth = scene.cloths[0]
    mesh, triangles = cloth.mesh, sim.topology.triangles
    uv = mesh.vertices[:, :2] if mesh.uv is None else mesh.uv
    uv_triangles = mesh.triangles if mesh.uv_triangles is None else mesh.uv_triangles
    color = colors(triangles, owners(sim))
    cloths = []
    for each in range(color.max() + 1):
        used, corners = np.unique(triangles[color == each], return_inverse=True)
        rest, rest_corners = np.unique(uv_triangles[color == each], return_inverse=True)
        part = ls.TriangleMesh(
            positions[used],
            corners.reshape(-1, 3),
            uv=uv[rest],
            uv_triangles=rest_corners.reshape(-1, 3),
        )
        cloths.append(ls.Cloth(name=f"colour {each}", mesh=part))
    return ls.Simulation(ls.Scene(cloths=cloths, obstacles=scene.obstacles, collisions=False))


def partitions(name: str, options: argparse.Namespace, times: tuple[float, ...]) -> Pictures:
    """Returns pictures of the partitions of a scene at `times` [s].

    Times after --duration are replaced by it.
    """
    file = opened(name, options)
    scene = file.scene()
    sim = ls.Simulation(scene, integrator=file.integrator)
    wanted = [min(time, options.duration or max(times)) for time in times]
    pictures: Pictures = {}
    look = file.render.replace(width=options.width, height=options.height, pattern="plain")
    for frame in sim.frames(duration=max(wanted), rate=file.rate):
        if min(abs(frame.time - time) for time in wanted) < 0.5 / file.rate:
            shown = painted(sim, scene, frame.positions)
            renderer = ls.pictures.Renderer(shown.topology, look)
            pictures[f"{frame.time:g} s"] = np.asarray(renderer.render(shown.frame()))
    return pictures


def figure_1(options: argparse.Namespace) -> None:
    """Draws figure 5.1: close views of the folding sheet at three instants."""
    camera = ls.Camera(fit=False, eye=(0.26, -0.22, 0.12), target=(0.0, 0.0, 0.03))
    pictures = seen(
        "fold", options, (0.4, 0.6, 1.6), look=lambda look, frame: look.replace(camera=camera)
    )
    strip({"": pictures}, options.out / "5.1.png")


def figure_4(options: argparse.Namespace) -> None:
    strip({"": partitions("dress", options, (0.0,))}, options.out / "5.4.png")


def of_scene(name: str, number: str, options: argparse.Namespace) -> None:
    rows = {
        "": seen(name, options, TIMES[name]),
        f"{RANKS} partitions": partitions(name, options, TIMES[name]),
    }
    strip(rows, options.out / f"{number}.png")


FIGURES = {
    "5.1": figure_1,
    "5.4": figure_4,
    "5.5": lambda options: of_scene("table_cloth", "5.5", options),
    "5.6": lambda options: of_scene("wave_bar", "5.6", options),
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
        parser, figures=["5.1", "5.6"], triangles=300, duration=0.04, width=64, height=48
    )
    options.out.mkdir(parents=True, exist_ok=True)
    for figure in options.figures:
        FIGURES[figure](options)
        print(options.out / f"{figure}.png", flush=True)


if __name__ == "__main__":
    main()
