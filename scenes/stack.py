"""Twenty sheets fall into a box, which is then shaken.

The sheets land on one another, form a stack and are pushed against the walls from side to side.
Nineteen layers press on the lowest sheet, and nothing passes through anything.
"""

import loomstone as ls
import numpy as np

duration = 3.0
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.23, -0.48, 0.25), target=(0.0, 0.0, 0.035), field_of_view_degrees=31.0
    ),
    pattern="plain",
    hidden="front+right",  # these walls are not drawn, so that the layers are visible
)

SIZE, BOX, WALL, HEIGHT, SPACING = 0.20, 0.23, 0.01, 0.12, 0.006


def shaking() -> tuple[np.ndarray, np.ndarray]:
    """Returns times (k) [s] and positions (k x 3) [m] of the box. The box is at rest while the
    sheets land, then moves sideways and up and down, and comes to rest again.
    """
    times = np.arange(0.0, duration + 1e-9, 0.005)
    t = np.clip(times - 0.5, 0.0, 1.9)
    reach = np.clip(t / 0.4, 0.0, 1.0) * np.clip((1.9 - t) / 0.4, 0.0, 1.0)
    path = [
        0.05 * np.sin(4.0 * np.pi * t),
        0.03 * np.sin(6.0 * np.pi * t),
        0.03 * np.sin(7.0 * np.pi * t) ** 2,
    ]
    return times, reach[:, None] * np.stack(path, axis=1)


def scene(triangles: int = 800, sheets: int = 20) -> ls.Scene:
    """triangles: approximate number of triangles of each sheet."""
    cells = max(1, round(np.sqrt(triangles / 2)))
    flat = ls.grid(size=(SIZE, SIZE), cells=(cells, cells))
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=60.0,
        density=0.12,
        bending_weft=2e-6,
        bending_warp=2e-6,
    )
    random = np.random.default_rng(7)
    cloths = []
    for i in range(sheets):
        turn = np.radians(random.uniform(-4.0, 4.0))
        rotation = np.array(
            [[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
        )
        place = (*random.uniform(-0.004, 0.004, 2), 0.02 + SPACING * i)
        cloths.append(
            ls.Cloth(
                name=f"sheet {i + 1}", mesh=flat.moved(place, rotation=rotation), material=material
            )
        )
    times, path = shaking()
    middle, height = 0.5 * (BOX + WALL), 0.5 * HEIGHT
    parts = {
        "bottom": ((BOX + 2 * WALL, BOX + 2 * WALL, WALL), (0.0, 0.0, -0.5 * WALL)),
        "left": ((WALL, BOX + 2 * WALL, HEIGHT), (-middle, 0.0, height)),
        "right": ((WALL, BOX + 2 * WALL, HEIGHT), (middle, 0.0, height)),
        "front": ((BOX, WALL, HEIGHT), (0.0, -middle, height)),
        "back": ((BOX, WALL, HEIGHT), (0.0, middle, height)),
    }
    box = [
        ls.obstacles.box(name=name, size=size, times=times, positions=path + centre)
        for name, (size, centre) in parts.items()
    ]
    return ls.Scene(cloths=cloths, obstacles=box)


def check(run: ls.Run) -> None:
    last = run[-1]
    assert last.positions[:, 2].min() > 0.0, "no sheet falls through the bottom"
    offset = last.positions[:, :2] - shaking()[1][-1, :2]
    assert np.abs(offset).max() < 0.5 * BOX, "nor through a wall"
    assert max(frame.stretch.max() for frame in run) < 1.3, "contacts do not tear the sheets"
