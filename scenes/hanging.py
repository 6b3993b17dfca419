"""A handkerchief hangs from two corners.

The edge between the pins sags into a curve. The cloth swings to the other side and nearly back.
This is the first scene to read and to copy: it consists of a mesh and pins, with the default
material.
"""

import loomstone as ls

duration = 1.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=2e-3)
render = ls.RenderOptions(camera=ls.Camera(eye=(0.9, -1.0, 0.35)))


def scene(triangles: int = 1600) -> ls.Scene:
    mesh = ls.grid(size=(0.4, 0.4), triangles=triangles)
    corners = ls.meshes.nearest_vertices(mesh, [(-0.2, 0.2, 0.0), (0.2, 0.2, 0.0)])
    return ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=corners)])


def check(run: ls.Run) -> None:
    last, first = run[-1], run[0]
    pinned = abs(first.positions - last.positions).max(axis=1).argsort()[:2]
    assert (first.positions[pinned] == last.positions[pinned]).all(), (
        "pinned vertices stay where they are"
    )
    assert last.positions[:, 2].min() < -0.2, "the cloth hangs down"
    assert last.stretch.max() < 1.2, "a light cloth of 300 N/m stretches little under its weight"
