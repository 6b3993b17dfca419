"""Bodies of all shapes bounce with their restitution, in short and in long steps. Forces that press
bodies together do not make them bounce.
"""

import loomstone as ls
import numpy as np
import pytest

FAR_MAGNET = {  # in a scene with a magnet, bodies move by kick-drift-kick
    "obstacles": [ls.obstacles.box(name="far", size=(0.01, 0.01, 0.01), centre=(5, 0, 0))],
    "magnets": [
        ls.Magnet(
            body="far",
            source=ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1.0)).moved(
                (5, 0, 0)
            ),
        )
    ],
}


def ball(restitution, height, radius=0.01, **fields):
    return ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=radius, subdivisions=2),
        shape="sphere",
        density=1000,
        restitution=restitution,
        position=(0, 0, height),
        **fields,
    )


def simulation(bodies, step, magnets=False, obstacles=(), **scene):
    more = FAR_MAGNET if magnets else {"obstacles": [], "magnets": []}
    made = ls.Scene(
        bodies=bodies,
        obstacles=[*obstacles, *more["obstacles"]],
        magnets=more["magnets"],
        **scene,
    )
    return ls.Simulation(made, integrator=ls.SemiImplicitEuler(step=step), threads=1)


@pytest.mark.parametrize("magnets", [False, True])
@pytest.mark.parametrize("radius", [0.001, 0.005])
def test_small_fast_balls_keep_their_restitution(radius, magnets):
    # Just before the impact, the ball with a radius of 1 mm moves by four radii in a step.
    for offset in np.arange(8) * 0.0011:
        height = 0.8 + offset
        sim = simulation([ball(0.9, radius + height, radius)], 1e-3, magnets, [ls.floor()])
        speed = np.sqrt(2 * 9.81 * height)
        while sim.time < speed / 9.81 + 0.05:
            sim.step()
        # The ball is on its way up. The height of its apex follows from its energy.
        z, v = sim.body_centres[0, 2] - radius, sim.state.body_velocities[0, 2]
        assert v > 0
        assert z + v * v / (2 * 9.81) == pytest.approx(0.81 * height, rel=0.01)


@pytest.mark.parametrize("step", [1e-4, 1e-3, 4e-3])
@pytest.mark.parametrize("other", ["box", "convex", "cylinder"])
def test_a_ball_bounces_off_a_free_body_of_any_shape(other, step):
    mesh = ls.meshes.box(size=(0.1, 0.1, 0.1))
    if other == "cylinder":
        mesh = ls.meshes.cylinder(radius=0.05, length=0.1, segments=32)
    shape = "box" if other == "box" else "convex"
    target = ls.RigidBody(name="target", mesh=mesh, shape=shape, density=1e3, restitution=1.0)
    moving = ball(1.0, 0.08, velocity=(0, 0, -1.0))
    sim = simulation([moving, target], step, gravity=(0, 0, 0))
    light, heavy = (ls.meshes.mass_properties(b.mesh, 1e3).mass for b in sim.scene.bodies)
    while sim.time < 0.05:
        sim.step()
    expected = (light - heavy) / (light + heavy)
    assert -sim.state.body_velocities[0, 2] == pytest.approx(expected, abs=1e-3)
    assert sim.report.energy.body_kinetic == pytest.approx(0.5 * light, rel=1e-3)


@pytest.mark.parametrize("magnets", [False, True])
def test_an_elastic_ball_keeps_its_height(magnets):
    sim = simulation([ball(1.0, 0.31)], 1e-3, magnets, [ls.floor()])
    apex = 0.0
    while sim.time < 4.0:
        sim.step()
        apex = max(apex, sim.body_centres[0, 2] - 0.01)
    assert apex == pytest.approx(0.3, rel=0.02)  # after eight bounces


@pytest.mark.parametrize("magnets", [False, True])
def test_a_pressed_box_rests(magnets):
    box = ls.RigidBody(
        name="box",
        mesh=ls.meshes.box(size=(0.1, 0.1, 0.1)),
        shape="box",
        density=1000,
        restitution=0.9,
        position=(0, 0, 0.0501),
    )
    sim = simulation([box], 1e-3, magnets, [ls.floor()])
    highest = 0.0
    while sim.time < 0.5:
        sim.external_body_forces = np.array([[0, 0, -150.0]])
        sim.step()
        highest = max(highest, sim.body_centres[0, 2] - 0.05)
    assert highest < 1e-3
    assert np.abs(sim.state.body_velocities).max() < 1e-3
    assert sim.report.account.balance < 1e-3


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
def test_magnets_that_bounce_come_to_rest_on_each_other(restitution):
    size = (0.01, 0.01, 0.01)
    source = ls.magnetics.cuboid(size=size, polarization=(0, 0, 1.0))
    bodies = [
        ls.RigidBody(
            name=name,
            mesh=ls.meshes.box(size=size),
            shape="box",
            density=7500,
            restitution=restitution,
            position=(0, 0, height),
        )
        for name, height in (("lower", 0), ("upper", 0.012))
    ]
    magnets = [ls.Magnet(body=body.name, source=source) for body in bodies]
    scene = ls.Scene(bodies=bodies, magnets=magnets, gravity=(0, 0, 0))
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=1e-3), threads=1)
    farthest, gain = 0.0, 0.0
    for _ in range(100):
        sim.step()
        gain = max(gain, sim.report.account.balance)
        if sim.time > 0.08:
            gap = sim.body_centres[1, 2] - sim.body_centres[0, 2] - 0.01
            farthest = max(farthest, abs(gap))
    assert farthest < 1e-6, "they touch; a restitution of the attraction would keep 20 um and more"
    assert gain < 0.02, "the account never rises"
