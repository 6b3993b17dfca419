"""Random scenes that combine cloths, bodies, attachments, magnets, coils, strain limits, air, and
pins and obstacles that move."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import loomstone as ls
import numpy as np
from numpy.typing import NDArray
from random_parts.draws import between, direction, quaternion, rotation

TIMES = np.linspace(0.0, 1.0, 21)  # times of all scripts [s]


@dataclass
class Mixture:
    """The parts of a scene, and the words that describe it."""

    size: float  # [m] upper bound on the sides of the sheets
    cloths: list[ls.Cloth] = field(default_factory=list)
    obstacles: list[ls.Obstacle] = field(default_factory=list)
    bodies: list[ls.RigidBody] = field(default_factory=list)
    attachments: list[ls.Attachment] = field(default_factory=list)
    magnets: list[ls.Magnet] = field(default_factory=list)
    coils: list[ls.Coil] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def lowest(self) -> float:
        """Returns the height of the lowest vertex of the cloths [m]."""
        return float(min(cloth.mesh.vertices[:, 2].min() for cloth in self.cloths))

    def highest(self) -> float:
        """Returns the height of the highest vertex of the cloths [m]."""
        return float(max(cloth.mesh.vertices[:, 2].max() for cloth in self.cloths))


def material(random: np.random.Generator) -> ls.ClothMaterial:
    stiffness, bending = between(random, 50.0, 2e4), between(random, 1e-7, 3e-4)
    return ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness * between(random, 0.4, 2.5),
        shear_stiffness=stiffness * between(random, 0.05, 0.5),
        density=between(random, 0.03, 0.6),
        bending_weft=bending,
        bending_warp=bending,
    )


def sheet(random: np.random.Generator, size: float) -> ls.TriangleMesh:
    sides = (size * random.uniform(0.5, 1.0), size * random.uniform(0.5, 1.0))
    cells = int(random.integers(4, 13))
    if random.random() < 0.7:
        return ls.grid(size=sides, cells=(cells, int(random.integers(4, 13))))
    seed = int(random.integers(99))
    return ls.meshes.irregular(size=sides, triangles=2 * cells * cells, seed=seed)


def script(
    random: np.random.Generator, points: NDArray[np.float64], size: float
) -> tuple[dict[str, Any], str]:
    """Returns a script of pins that swing together, and the words that describe it."""
    amplitude, frequency = size * random.uniform(0.1, 0.8), random.uniform(0.5, 3.0)
    waves = np.sin(2.0 * np.pi * frequency * TIMES) * np.minimum(1.0, 5.0 * TIMES)
    positions = points + amplitude * waves[:, None, None] * direction(random)
    speed = 2.0 * np.pi * amplitude * frequency
    return {"script_times": TIMES, "script_positions": positions}, f"pins of {speed:.2g} m/s"


def cloth_options(
    random: np.random.Generator, mesh: ls.TriangleMesh, size: float
) -> tuple[dict[str, Any], list[str]]:
    """Returns the options of a cloth except its material, and the words that describe them."""
    n = len(mesh.vertices)
    pins = random.choice(n, size=int(random.choice([0, 0, 1, 2, 4])), replace=False).tolist()
    options: dict[str, Any] = {"pins": pins}
    words = [f"{len(pins)} pins"] if pins else []
    if pins and random.random() < 0.6:
        scripted, word = script(random, mesh.vertices[pins], size)
        options.update(scripted)
        words.append(word)
    if random.random() < 0.35:
        largest = between(random, 0.01, 0.1)
        options["strain_limit"] = ls.StrainLimit(largest, largest, 0.1)
        words.append(f"limits of {100 * largest:.1f} %")
    if random.random() < 0.2:
        options["bending"] = "hinge"
    if random.random() < 0.3:
        options["friction"] = float(random.uniform(0.0, 1.5))
    if random.random() < 0.15:
        options["rest_angles"] = "mesh"
    if random.random() < 0.4:
        velocity = direction(random) * random.uniform(0.0, 8.0) * size**0.5
        options["velocities"] = np.tile(velocity, (n, 1))
        options["velocities"][pins] = 0.0
    return options, words


def add_cloths(random: np.random.Generator, mixture: Mixture) -> None:
    """Adds one to three sheets above one another: all level, or each turned at random."""
    turned = random.random() < 0.35
    size = mixture.size
    for index in range(int(random.integers(1, 4))):
        mesh = sheet(random, size)
        if turned:
            mesh = mesh.moved((0.0, 0.0, 1.6 * size * index), rotation=rotation(random))
        else:
            mesh = mesh.moved((0.0, 0.0, 0.12 * size * index))
        options, words = cloth_options(random, mesh, size)
        mixture.words.extend(words)
        mixture.cloths.append(
            ls.Cloth(name=f"cloth {index}", mesh=mesh, material=material(random), **options)
        )


def add_obstacles(random: np.random.Generator, mixture: Mixture) -> None:
    """May add a floor, and may add one obstacle below the cloths: static, or moving and turning."""
    size, low = mixture.size, mixture.lowest()
    if random.random() < 0.6:
        mixture.obstacles.append(ls.floor(height=low - size * random.uniform(0.9, 1.4)))
    if random.random() < 0.5:
        radius = size * random.uniform(0.08, 0.3)
        mesh = [
            ls.meshes.sphere(radius=radius),
            ls.meshes.box(size=(radius, 2.0 * radius, radius)),
            ls.meshes.capsule(radius=radius / 2.0, length=radius),
        ][int(random.integers(3))]
        moves = random.random() < 0.6
        way = np.abs(direction(random)) * size * random.uniform(0.0, 0.7) * moves
        base = np.array([0.0, 0.0, low - radius - 0.1 * size])
        mixture.obstacles.append(
            ls.Obstacle(
                name="obstacle",
                mesh=mesh,
                times=TIMES,
                positions=base + np.outer(np.sin(3.0 * TIMES), way),
                axis_angles=np.outer(2.0 * TIMES * moves, direction(random)),
            )
        )
        mixture.words.append("moving obstacle" if moves else "obstacle")


def add_bodies(random: np.random.Generator, mixture: Mixture) -> None:
    """Adds up to four balls and boxes above the cloths.

    Some of them carry a magnet, soft iron or a coil.
    """
    size, top = mixture.size, mixture.highest()
    for index in range(int(random.choice([0, 0, 1, 2, 4]))):
        radius, name = size * random.uniform(0.04, 0.12), f"body {index}"
        ball = random.random() < 0.5
        sides = (radius, 1.6 * radius, 0.8 * radius)
        place = (*(size * random.uniform(-0.3, 0.3, size=2)), top + size * (0.2 + 0.3 * index))
        mixture.bodies.append(
            ls.RigidBody(
                name=name,
                mesh=ls.meshes.sphere(radius=radius) if ball else ls.meshes.box(size=sides),
                shape="sphere" if ball else "box",
                density=between(random, 50.0, 8000.0),
                position=place,
                orientation=quaternion(random),
                velocity=direction(random) * random.uniform(0.0, 3.0) * size**0.5,
                angular_velocity=random.normal(size=3) * random.uniform(0.0, 20.0),
                friction=float(random.uniform(0.0, 1.0)),
                restitution=float(random.choice([0.0, 0.0, 0.5])),
            )
        )
        if random.random() < 0.5:
            add_source(random, mixture, name, 0.35 * radius)


def add_source(random: np.random.Generator, mixture: Mixture, name: str, radius: float) -> None:
    """Adds a magnet, soft iron or a coil to the body `name`.

    Its radius, or the longest side of a cuboid, is `radius` [m].
    """
    polarization = tuple(direction(random) * random.uniform(0.2, 1.3))
    kind = str(random.choice(["ball", "cuboid", "iron", "coil"]))
    mixture.words.append(kind)
    if kind == "coil":
        turns = 50
        winding = ls.magnetics.solenoid(radius=radius, length=radius, turns=turns)
        mixture.coils.append(
            ls.Coil(
                body=name,
                source=winding,
                resistance=between(random, 0.1, 10.0),
                inductance=0.5 * ls.magnetics.MU0 * turns**2 * np.pi * radius,
                times=TIMES,
                voltages=random.uniform(-5.0, 5.0) * np.sin(20.0 * TIMES),
            )
        )
    else:
        source = {
            "ball": lambda: ls.magnetics.sphere(radius=radius, polarization=polarization),
            "cuboid": lambda: ls.magnetics.cuboid(
                size=(radius, radius, 0.5 * radius), polarization=polarization
            ),
            "iron": lambda: ls.magnetics.soft_sphere(radius=radius, susceptibility=99.0),
        }[kind]()
        mixture.magnets.append(ls.Magnet(body=name, source=source))


def attach(random: np.random.Generator, mixture: Mixture) -> None:
    """Puts the first body at rest above a free vertex of the last cloth, and attaches the two."""
    cloth, body = mixture.cloths[-1], mixture.bodies[0]
    free = np.setdiff1d(np.arange(len(cloth.mesh.vertices)), cloth.pins)
    vertex = int(random.choice(free))
    place = cloth.mesh.vertices[vertex] + np.array([0.0, 0.0, 0.2 * mixture.size])
    mixture.bodies[0] = body.replace(
        position=tuple(place), velocity=(0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.0)
    )
    mixture.attachments.append(ls.Attachment(cloth=cloth.name, body=body.name, vertices=[vertex]))
    mixture.words.append("attachment")


def random_mixture(random: np.random.Generator) -> tuple[str, float, ls.Scene]:
    """Returns a description, an upper bound on the sheets' sides [m] and the scene."""
    mixture = Mixture(between(random, 0.02, 1.0))
    add_cloths(random, mixture)
    add_obstacles(random, mixture)
    add_bodies(random, mixture)
    if mixture.bodies and random.random() < 0.25:
        attach(random, mixture)
    options: dict[str, Any] = {}
    if random.random() < 0.3:
        options["air"] = ls.Air(
            normal_drag=float(random.uniform(0.2, 1.5)),
            tangential_drag=float(random.uniform(0.0, 0.2)),
            wind=tuple(random.normal(size=3) * random.uniform(0.0, 8.0)),
            gust=float(random.uniform(0.0, 1.0)),
        )
        mixture.words.append("air")
    if random.random() < 0.1:
        options["gravity"] = (0.0, 0.0, 0.0)
        mixture.words.append("no gravity")
    scene = ls.Scene(
        cloths=mixture.cloths,
        obstacles=mixture.obstacles,
        bodies=mixture.bodies,
        attachments=mixture.attachments,
        magnets=mixture.magnets,
        coils=mixture.coils,
        **options,
    )
    counts = f"{len(mixture.cloths)} cloths, {len(mixture.bodies)} bodies"
    return ", ".join([f"{mixture.size:.3g} m", counts, *mixture.words]), mixture.size, scene
