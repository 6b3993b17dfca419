"""Features of a scene have the same effect in asynchronous steps as with the midpoint rule."""

from collections.abc import Callable
from dataclasses import dataclass

import loomstone as ls
import numpy as np
import pytest

SCHEDULES = ("nested", "queue", "refill")
DURATION = 0.1  # [s]


def still(sim: ls.Simulation) -> None:
    """Leaves a simulation as it is."""


def push(sim: ls.Simulation) -> None:
    forces = np.zeros_like(sim.positions)
    forces[:, 1] = 2e-3
    sim.external_forces = forces


def pull_pins(sim: ls.Simulation) -> None:
    sim.set_pin_targets(sim.positions + [0.0, 0.2 * sim.step_size, 0.0])


@dataclass(frozen=True)
class Feature:
    """A feature: how it changes the plain scene, and what a program does before each step."""

    scene: Callable[[ls.Scene], ls.Scene]
    before_step: Callable[[ls.Simulation], None] = still


MATERIAL = ls.ClothMaterial(
    weft_stiffness=300,
    warp_stiffness=200,
    shear_stiffness=80,
    density=0.2,
    bending_weft=1e-5,
    bending_warp=1e-5,
)

STIFF = MATERIAL.replace(bending_weft=1e-4, bending_warp=2e-4)


def plain() -> ls.Scene:
    """A curved sheet of 128 triangles that hangs from two corners, without collisions."""
    flat = ls.grid(size=(0.2, 0.2), cells=(8, 8))
    x = flat.vertices.copy()
    x[:, 2] = 0.03 * np.cos(12.0 * x[:, 0])
    mesh = ls.TriangleMesh(x, flat.triangles, uv=flat.vertices[:, :2])
    cloth = ls.Cloth(name="cloth", mesh=mesh, pins=[0, 8], material=MATERIAL, rest="mesh")
    return ls.Scene(cloths=[cloth], collisions=False)


def with_cloth(**fields: object) -> Feature:
    return Feature(lambda s: s.replace(cloths=[s.cloths[0].replace(**fields)]))


def with_material(**fields: object) -> Feature:
    return with_cloth(material=MATERIAL.replace(**fields))


def body(scene: ls.Scene, **fields: object) -> ls.Scene:
    box = ls.meshes.box(size=(0.2, 0.02, 0.02))
    weight = ls.RigidBody(
        name="weight", mesh=box, shape="box", density=250, position=(0, 0.111, 0.0), **fields
    )
    return scene.replace(bodies=[weight])


def attached(scene: ls.Scene) -> ls.Scene:
    tied = ls.Attachment(cloth="cloth", body="weight", vertices=list(range(72, 81)))
    return body(scene).replace(attachments=[tied])


def magnet(scene: ls.Scene) -> ls.Scene:
    source = ls.magnetics.cuboid(size=(0.05, 0.02, 0.02), polarization=(0, 0, 0.1))
    held = ls.magnetics.cuboid(size=(0.05, 0.05, 0.02), polarization=(0, 0, 0.1))
    floor = ls.floor(height=-0.1)
    return attached(scene).replace(
        obstacles=[floor],
        magnets=[
            ls.Magnet(body="weight", source=source),
            ls.Magnet(body=floor.name, source=held.at((0, 0.1, -0.1), (1, 0, 0, 0))),
        ],
    )


def script(scene: ls.Scene) -> ls.Scene:
    start = scene.cloths[0].mesh.vertices[[0, 8]]
    moved = np.concatenate([start, start + [0.0, 0.05, 0.02]])
    cloth = scene.cloths[0].replace(script_times=[0.0, DURATION], script_positions=moved)
    return scene.replace(cloths=[cloth])


def ball(scene: ls.Scene) -> ls.Scene:
    sphere = ls.sphere(radius=0.08, centre=(0, 0.02, -0.085))
    return scene.replace(obstacles=[sphere], collisions=True)


def moving_ball(scene: ls.Scene) -> ls.Scene:
    sphere = ls.sphere(radius=0.08, centre=(0, 0.02, -0.085)).replace(
        times=[0.0, DURATION], positions=[(0, 0, 0), (0, 0, 0.06)]
    )
    return scene.replace(obstacles=[sphere], collisions=True)


def thrown_box(scene: ls.Scene) -> ls.Scene:
    cube = ls.RigidBody(
        name="cube",
        mesh=ls.meshes.box(size=(0.05, 0.05, 0.05), cells_per_side=3),
        shape="box",
        density=100,
        position=(0, 0.02, 0.07),
        velocity=(0, 0, -1.0),
    )
    return scene.replace(bodies=[cube], collisions=True)


def two_cloths(scene: ls.Scene) -> ls.Scene:
    first = scene.cloths[0]
    other = first.replace(name="other", mesh=first.mesh.moved((0, 0, 0.02)), pins=[])
    other = other.replace(velocities=np.tile([0.0, 0.0, -1.5], (81, 1)))
    return scene.replace(cloths=[first, other], collisions=True)


FEATURES = {
    "drag": Feature(lambda s: s.replace(air=ls.Air(normal_drag=2.0, tangential_drag=0.1))),
    "wind": Feature(lambda s: s.replace(air=ls.Air(normal_drag=1.0, wind=(0, 3, 4)))),
    "no gravity": Feature(lambda s: s.replace(gravity=(0, 0, 0))),
    "forces": Feature(lambda s: s, push),
    "targets of pins": Feature(lambda s: s, pull_pins),
    "script": Feature(script),
    "velocities": with_cloth(velocities=np.tile([0.0, 0.5, 0.0], (81, 1))),
    "rest angles": with_cloth(rest_angles="mesh", material=STIFF),
    "rest lengths": with_cloth(rest="uv"),
    "hinges": with_cloth(rest_angles="mesh", material=STIFF, bending="hinge"),
    "bending": with_cloth(material=STIFF),
    "viscosity": with_material(viscosity_shear=0.5, viscosity_dilation=0.5),
    "damped bending": with_material(bending_weft=1e-4, bending_warp=2e-4, bending_damping=0.02),
    "density": with_material(density=0.6),
    "attachment": Feature(attached),
    "magnets on attached bodies": Feature(magnet),
    "obstacle": Feature(ball),
    "moving obstacle": Feature(moving_ball),
    "body": Feature(thrown_box),
    "two cloths": Feature(two_cloths),
}


# These features cause many contacts, or fast vibrations that the midpoint rule does not resolve.
DIFFICULT = {"velocities", "rest lengths", "two cloths"}


def end(feature: Feature, integrator: ls.Integrator) -> np.ndarray:
    """Returns the positions of the first cloth after 0.1 s.

    Raises AssertionError if surfaces then intersect in a scene with collisions.
    """
    scene = feature.scene(plain())
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    while sim.time < DURATION - 1e-9:
        feature.before_step(sim)
        sim.step()
    assert not scene.collisions or not sim.intersecting_pairs()
    return sim.positions[:81]


@pytest.mark.parametrize("name", FEATURES)
def test_a_feature_has_the_same_effect_in_every_schedule_as_with_the_midpoint_rule(name):
    midpoint = ls.ImplicitMidpoint(step=5e-4, tolerance=1e-8)
    expected = end(FEATURES[name], midpoint)
    effect = np.linalg.norm(expected - end(Feature(lambda s: s), midpoint))
    for schedule in SCHEDULES:
        steps = ls.Asynchronous(schedule=schedule, safety=0.2)
        error = np.linalg.norm(end(FEATURES[name], steps) - expected)
        # If the feature did not act, the error would be as large as its effect.
        assert error < (0.5 if name in DIFFICULT else 0.3) * effect, schedule


@pytest.mark.parametrize("schedule", SCHEDULES)
def test_bending_has_no_shorter_steps_than_the_membrane(schedule):
    integrator = ls.Asynchronous(schedule=schedule, bending_multiple=1e-9)
    with pytest.raises(ls.InvalidInput, match="bending_multiple must be 0 or at least 1"):
        ls.Simulation(plain(), integrator=integrator, threads=1)
