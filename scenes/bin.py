"""Twelve towels are thrown into a bin and arrive one after the other.

Each impact shortens the automatic step, and between impacts the step becomes longer again:
`loomstone plot RUN --what step` draws the length of the step over time.
"""

import loomstone as ls
import numpy as np

duration = 2.5
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.34, -0.62, 0.46), target=(0.0, 0.0, 0.08), field_of_view_degrees=33.0
    ),
    pattern="plain",
    hidden="front+right",  # these walls are not drawn, so that the towels are visible
)

SIZE, WALL, HEIGHT = 0.24, 0.01, 0.24
SPEED = 2.0  # speed of the throw [m/s]


def rotation(random: np.random.Generator) -> np.ndarray:
    """Returns a random rotation (3 x 3) that tilts a level towel by 20 to 60 degrees."""
    tilt, turn = np.radians(random.uniform(20.0, 60.0)), random.uniform(0.0, 2.0 * np.pi)
    about_x = np.array(
        [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
    )
    about_z = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    both: np.ndarray = about_z @ about_x
    return both


def scene(triangles: int = 640, towels: int = 12) -> ls.Scene:
    """triangles: approximate number of triangles of each towel."""
    columns = max(1, round(np.sqrt(triangles * 3.0 / 4.0)))
    flat = ls.grid(size=(0.18, 0.12), cells=(columns, max(1, round(columns * 2.0 / 3.0))))
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=60.0,
        density=0.3,
        bending_weft=4e-6,
        bending_warp=4e-6,
    )
    random = np.random.default_rng(5)
    cloths = []
    for i in range(towels):
        x, y = random.uniform(-0.02, 0.02, 2)
        cloths.append(
            ls.Cloth(
                name=f"towel {i + 1}",
                mesh=flat.moved((x, y, 0.2 + 0.24 * i), rotation=rotation(random)),
                material=material,
                velocities=np.tile((0.0, 0.0, -SPEED), (flat.n_vertices, 1)),
            )
        )
    middle, height = 0.5 * (SIZE + WALL), 0.5 * HEIGHT
    parts = {
        "bottom": ((SIZE + 2 * WALL, SIZE + 2 * WALL, WALL), (0.0, 0.0, -0.5 * WALL)),
        "left": ((WALL, SIZE + 2 * WALL, HEIGHT), (-middle, 0.0, height)),
        "right": ((WALL, SIZE + 2 * WALL, HEIGHT), (middle, 0.0, height)),
        "front": ((SIZE, WALL, HEIGHT), (0.0, -middle, height)),
        "back": ((SIZE, WALL, HEIGHT), (0.0, middle, height)),
    }
    walls = [
        ls.obstacles.box(name=name, size=size, centre=place)
        for name, (size, place) in parts.items()
    ]
    return ls.Scene(cloths=cloths, obstacles=walls)


def check(run: ls.Run) -> None:
    last = run[-1]
    assert last.positions[:, 2].min() > 0.0, "no towel falls through the bottom"
    assert np.abs(last.positions[:, :2]).max() < 0.5 * SIZE, "all towels lie in the bin"
    lengths = run.steps["length"][:-1]
    assert lengths.max() > 8.0 * lengths.min(), "the automatic step follows the impacts"
