"""Four cloths fall onto four small spheres.

From left to right, the bending stiffness increases eightfold from each cloth to the next. The folds
become fewer and wider, until the stiffest cloth sticks out like cardboard. The scene is based on
figure 2.4 of [Thomaszewski2010], in which the stiffness doubles from each cloth to the next.
"""

import loomstone as ls
import numpy as np

duration = 1.5
rate = 25.0
render = ls.RenderOptions(camera=ls.Camera(eye=(0.0, -1.0, 0.62)), width=1600, height=560)

SPACING, SIZE, RADIUS = 0.42, 0.36, 0.07


def scene(triangles: int = 3600, bending: float = 2e-6, factor: float = 8.0) -> ls.Scene:
    cells = max(1, round(np.sqrt(triangles / 2)))
    flat = ls.grid(size=(SIZE, SIZE), cells=(cells, cells))
    cloths, obstacles = [], [ls.floor(height=-0.30)]
    for i in range(4):
        x = (i - 1.5) * SPACING
        rigidity = bending * factor**i
        material = ls.ClothMaterial(density=0.2, bending_weft=rigidity, bending_warp=rigidity)
        mesh = flat.moved((x, 0.0, RADIUS + 0.004))
        cloths.append(ls.Cloth(name=f"B = {rigidity:.2g} N m", mesh=mesh, material=material))
        obstacles.append(
            ls.sphere(name=f"body {i + 1}", radius=RADIUS, centre=(x, 0.0, 0.0), subdivisions=3)
        )
    return ls.Scene(cloths=cloths, obstacles=obstacles)


def check(run: ls.Run) -> None:
    last, cloth = run[-1], run.topology.cloth_of_vertex
    spread = []
    for i in range(4):
        x, y, _ = (last.positions[cloth == i] - [(i - 1.5) * SPACING, 0.0, 0.0]).T
        spread.append(float(np.hypot(x, y).max()))
    assert spread[0] < spread[3], "the stiffer cloth stands out further"
    assert last.stretch.max() < 1.55, "contacts do not tear the cloth"
