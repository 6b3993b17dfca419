"""Boxes are thrown onto a cloth that is pinned at its corners.

The cloth yields under each box, waves run through it, and it carries the growing pile. The boxes
tumble, collide and gather in the sag. Cloth and boxes act on each other.
"""

import loomstone as ls
import numpy as np

duration = 2.0
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.50, -0.78, 0.52), target=(0.0, 0.0, 0.0), field_of_view_degrees=33.0
    )
)

SIZE = 0.5


def scene(triangles: int = 5000, boxes: int = 5, speed: float = 1.0) -> ls.Scene:
    cells = max(2, round(np.sqrt(triangles / 2)))
    mesh = ls.grid(size=(SIZE, SIZE), cells=(cells, cells))
    corners = ls.meshes.nearest_vertices(
        mesh, [(x, y, 0.0) for x in (-0.25, 0.25) for y in (-0.25, 0.25)]
    )
    material = ls.ClothMaterial(
        weft_stiffness=2000.0,
        warp_stiffness=2000.0,
        shear_stiffness=500.0,
        density=0.3,
        bending_weft=2e-5,
        bending_warp=2e-5,
    )
    random = np.random.default_rng(3)
    bodies = []
    for i in range(boxes):
        axis = random.normal(size=3)
        half = random.uniform(0.3, 1.2)
        turn = np.concatenate([[np.cos(half)], np.sin(half) * axis / np.linalg.norm(axis)])
        place = np.array([*random.uniform(-0.07, 0.07, 2), 0.10 + 0.12 * i])
        bodies.append(
            ls.RigidBody(
                name=f"box {i + 1}",
                mesh=ls.meshes.box(size=(0.07, 0.05, 0.03), cells_per_side=4),
                shape="box",
                density=300.0,
                position=place,
                orientation=turn,
                velocity=(-2.0 * place[0], -2.0 * place[1], -speed),
                angular_velocity=random.uniform(-4.0, 4.0, 3),
                friction=0.4,
            )
        )
    return ls.Scene(
        cloths=[ls.Cloth(name="cloth", mesh=mesh, material=material, pins=corners, friction=0.4)],
        bodies=bodies,
    )


def check(run: ls.Run) -> None:
    last, body = run[-1], run.topology.body_of_vertex
    for i, name in enumerate(run.topology.body_names):
        centre = last.body_vertices[body == i].mean(axis=0)
        assert np.abs(centre[:2]).max() < 0.25 and -0.3 < centre[2] < 0.25, (
            f"{name} lies in the cloth"
        )
    assert max(frame.stretch.max() for frame in run) < 1.6, "the boxes do not tear the cloth"
