"""A long ribbon falls on two inclined planes, slides down and piles up in folds.

At first, the ribbon is almost vertical, above the upper plane, as in the scene of figure 4.4 of
[Thomaszewski2010]. It is integrated by asynchronous steps, in which each triangle has its own step
length.
"""

import loomstone as ls
import numpy as np

duration = 5.0
rate = 25.0
integrator = ls.Asynchronous(step=2.5e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.6, -3.2, 0.9), target=(0.35, 0.0, -0.45), field_of_view_degrees=40.0
    )
)

WIDTH, LENGTH = 0.25, 6.0
SLOPE = np.deg2rad(30.0)
FLOOR = -1.4


def plane(name: str, centre: tuple[float, float, float], slope: float) -> ls.Obstacle:
    """Returns a board that slopes down along +x by the angle `slope` [rad]."""
    c, s = np.cos(slope), np.sin(slope)
    frame = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    board = ls.meshes.box(size=(1.2, 1.0, 0.04)).moved(centre, rotation=frame)
    return ls.obstacles.mesh(board, name=name, friction=0.2)


def scene(triangles: int = 8000) -> ls.Scene:
    across = max(1, round(np.sqrt(0.5 * triangles * WIDTH / LENGTH)))
    along = max(2, round(0.5 * triangles / across))
    lean = np.deg2rad(2.0)
    upright = np.array(
        [[0.0, np.sin(lean), np.cos(lean)], [1.0, 0.0, 0.0], [0.0, np.cos(lean), -np.sin(lean)]]
    )
    mesh = ls.grid(size=(WIDTH, LENGTH), cells=(across, along)).moved(
        (0.0, 0.0, 0.5 * LENGTH + 0.1), rotation=upright
    )
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.5,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    return ls.Scene(
        cloths=[ls.Cloth(name="ribbon", mesh=mesh, material=material, friction=0.2)],
        obstacles=[
            plane("upper", (0.1, 0.0, -0.1), SLOPE),
            plane("lower", (0.75, 0.0, -0.85), -SLOPE),
            ls.floor(height=FLOOR, friction=0.2),
        ],
    )


def check(run: ls.Run) -> None:
    energies = [frame.report.account.balance for frame in run]
    assert max(energies) < 0.005, "collisions at events give the ribbon no energy"
    height = run[-1].positions[:, 2]
    assert height.min() > FLOOR, "the ribbon lies above the floor"
    assert height.min() < FLOOR + 0.02, "it has reached the floor"
    assert height.max() < -0.2, "it has slid off the upper plane"
