"""A sphere pushes a square cloth through a narrow funnel onto a floor.

The cloth lines the cone, gathers into many layers in front of the sphere, is squeezed through the
tube and settles on the floor. The scene is based on figure 2.5 of [Thomaszewski2010] (14,476
triangles, 4 s, steps of 1 ms). The dimensions of funnel and sphere are our choice.
"""

import loomstone as ls
import numpy as np

duration = 4.0
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(fit=False, eye=(0.9, -1.15, 0.65), target=(0.0, 0.0, -0.10))
)

TOP, BOTTOM, HEIGHT, TUBE, WALL = 0.26, 0.065, 0.22, 0.10, 0.008
FLOOR = -0.40
BALL = 0.038


def scene(triangles: int = 14476) -> ls.Scene:
    mesh = ls.meshes.irregular(size=(0.5, 0.5), triangles=triangles).moved(
        (0.004, 0.003, HEIGHT + 0.03)
    )
    material = ls.ClothMaterial(density=0.2, bending_weft=5e-6, bending_warp=5e-6)
    # The sphere first sinks slowly above the cloth, then pushes it down through the tube, and stops
    # 2 cm above the floor.
    times = [0.0, 0.6, 2.2, 2.9]
    heights = [HEIGHT + 0.12, HEIGHT + 0.10, -TUBE - 0.07, FLOOR + BALL + 0.02]
    path = np.array([(0.0, 0.0, z) for z in heights])
    return ls.Scene(
        cloths=[ls.Cloth(name="cloth", mesh=mesh, material=material, friction=0.1)],
        obstacles=[
            ls.obstacles.funnel(
                top_radius=TOP,
                bottom_radius=BOTTOM,
                height=HEIGHT,
                tube_length=TUBE,
                wall=WALL,
                friction=0.1,
            ),
            ls.sphere(name="pusher", radius=BALL, times=times, positions=path, friction=0.1),
            ls.floor(height=FLOOR, friction=0.4),
        ],
    )


def check(run: ls.Run) -> None:
    last = run[-1]
    assert last.positions[:, 2].max() < 0.0, "the whole cloth has passed the cone"
    assert last.positions[:, 2].min() > FLOOR, "no vertex is below the floor"
