"""Scenes that test guarantees in extreme cases: pins that jump, bodies much heavier than cloth, and
heaps.

certify.py counts their intersections, and tests/python/simulation/test_extreme_scenes.py checks
their motion.
"""

import loomstone as ls
import numpy as np

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
SOFT = ls.ClothMaterial(
    weft_stiffness=300.0,
    warp_stiffness=300.0,
    shear_stiffness=60.0,
    density=0.15,
    bending_weft=2e-6,
    bending_warp=2e-6,
)


def top(mesh: ls.TriangleMesh) -> np.ndarray:
    heights = mesh.vertices[:, 2]
    return np.flatnonzero(heights > heights.max() - 1e-6)


def curtains(cells: int, hung: bool) -> ls.Scene:
    """Two curtains. At 0.1 s, the pins of the first jump by 0.3 m, past the plane of the second.

    If `hung` is true, the second is pinned along its upper edge. Otherwise it is free, and gravity
    is zero.
    """
    flat = ls.grid(size=(0.4, 0.4), cells=(cells, cells))
    first = flat.moved((0, 0, 0), rotation=UPRIGHT)
    second = flat.moved((0.03, 0.05, 0.01), rotation=UPRIGHT)
    pins = top(first)
    places = first.vertices[pins]
    script = np.concatenate([places, places, places + (0, 0.3, 0)])
    return ls.Scene(
        cloths=[
            ls.Cloth(
                name="driven",
                mesh=first,
                material=SOFT,
                pins=list(pins),
                script_times=[0.0, 0.1, 0.1001],
                script_positions=script,
            ),
            ls.Cloth(
                name="struck", mesh=second, material=SOFT, pins=list(top(second)) if hung else []
            ),
        ],
        gravity=(0, 0, -9.81) if hung else (0, 0, 0),
    )


def caught(mass: float, corners: bool = False, drop: float = 0.05) -> ls.Scene:
    """A ball that falls by `drop` [m] into a cloth of 40 g with strain limits of 2 % (shear: 4 %).

    The cloth is pinned along two edges or, if `corners` is true, at its four corners.
    """
    mesh = ls.grid(size=(0.5, 0.5), cells=(15, 15))
    at_edge = np.abs(mesh.vertices[:, :2]) > 0.25 - 1e-6
    held = np.flatnonzero(at_edge.all(axis=1) if corners else at_edge[:, 0])
    material = ls.ClothMaterial(
        weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=80.0, density=0.16
    )
    radius = 0.06
    density = mass / (4.0 / 3.0 * np.pi * radius**3)
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=mesh,
                material=material,
                pins=list(held),
                strain_limit=ls.StrainLimit(0.02, 0.02, 0.04),
            )
        ],
        bodies=[
            ls.RigidBody(
                name="ball",
                mesh=ls.sphere(radius=radius).mesh,
                shape="sphere",
                density=density,
                position=(0.003, 0.002, radius + drop),
            )
        ],
    )


def heap(towels: int) -> ls.Scene:
    """Towels that fall onto one another."""
    random = np.random.default_rng(0)
    flat = ls.grid(size=(0.18, 0.12), cells=(11, 7))
    material = ls.ClothMaterial(
        weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=150.0, density=0.3
    )
    cloths = []
    for i in range(towels):
        x, y = random.uniform(-0.03, 0.03, 2)
        roll, pitch = random.uniform(-0.2, 0.2, 2)
        turn = random.uniform(0.0, 3.0)
        about_x = np.array(
            [[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]]
        )
        about_y = np.array(
            [[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]
        )
        about_z = np.array(
            [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
        )
        mesh = flat.moved((x, y, 0.08 + 0.08 * i), rotation=about_z @ about_y @ about_x)
        cloths.append(ls.Cloth(name=f"towel {i}", mesh=mesh, material=material))
    return ls.Scene(cloths=cloths, obstacles=[ls.floor(height=0.0)])
