"""Random sheets with random velocities, pins and limits, and static obstacles."""

from typing import Any

import loomstone as ls
import numpy as np
from numpy.typing import NDArray
from random_parts.draws import between


def random_mesh(random: np.random.Generator, size: float) -> ls.TriangleMesh:
    cells = int(random.integers(3, 16))
    if random.random() < 0.4:
        triangles, seed = 2 * cells * cells, int(random.integers(100))
        return ls.meshes.irregular(size=(size, size), triangles=triangles, seed=seed)
    return ls.grid(size=(size, size), cells=(cells, cells))


def random_material(random: np.random.Generator) -> ls.ClothMaterial:
    stiffness, bending = between(random, 10.0, 1e5), between(random, 1e-7, 1e-3)
    return ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness * between(random, 0.3, 3.0),
        shear_stiffness=stiffness * between(random, 0.03, 0.6),
        density=between(random, 0.01, 1.0),
        bending_weft=bending,
        bending_warp=bending,
        bending_damping=1e-3 if random.random() < 0.2 else 0.0,
    )


def smooth_velocities(
    random: np.random.Generator, points: NDArray[np.float64], size: float, speed: float
) -> NDArray[np.float64]:
    """Returns velocities that vary over the sheet, at most `speed` along each axis [m/s]."""
    velocities = np.zeros_like(points)
    for _ in range(4):
        waves, phases = random.integers(1, 3, size=2), random.uniform(0.0, 2.0 * np.pi, size=2)
        shape = np.cos(np.pi * waves * points[:, :2] / size + phases).prod(axis=1)
        velocities += np.outer(shape, random.normal(size=3))
    velocities *= speed / np.abs(velocities).max()
    return velocities


def random_sheet(random: np.random.Generator) -> tuple[str, float, ls.Scene]:
    """Returns a description, the side of the sheet [m] and the scene."""
    size = between(random, 0.01, 2.0)
    speed = between(random, 0.1, 50.0) * size**0.5
    mesh, material = random_mesh(random, size), random_material(random)
    options: dict[str, Any] = {}
    if random.random() < 0.3:
        options["strain_limit"] = ls.StrainLimit(0.05, 0.05, 0.1)
    if random.random() < 0.2:
        options["bending"] = "hinge"
    n_pins = int(random.integers(0, 4))
    pins = [int(i) for i in random.choice(len(mesh.vertices), size=n_pins, replace=False)]
    obstacles = []
    if random.random() < 0.5:
        obstacles.append(ls.sphere(radius=0.3 * size, centre=(0.0, 0.0, -0.4 * size)))
    if random.random() < 0.5:
        obstacles.append(ls.floor(height=-0.8 * size))
    words = (
        f"{size:.3g} m, {len(mesh.triangles)} triangles, {speed:.2g} m/s, "
        f"{material.weft_stiffness:.3g} N/m, {material.bending_weft:.1g} N m, "
        f"{material.density:.2g} kg/m^2, {n_pins} pins, {len(obstacles)} obstacles, "
        f"{', '.join(options) or 'no options'}"
    )
    collisions = bool(random.random() < 0.8)
    velocities = smooth_velocities(random, mesh.vertices, size, speed)
    velocities[pins] = 0.0
    cloth = ls.Cloth(mesh=mesh, material=material, pins=pins, velocities=velocities, **options)
    return words, size, ls.Scene(cloths=[cloth], obstacles=obstacles, collisions=collisions)
