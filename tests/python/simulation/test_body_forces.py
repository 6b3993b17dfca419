"""Tests of forces and torques that users apply to rigid bodies."""

import loomstone as ls
import numpy as np
import pytest

MASS = 0.5
FORCE = np.array([0.3, -0.2, 0.1])
TORQUE = np.array([1e-3, 2e-3, -1e-3])
CUBE = ls.meshes.box(size=(0.1, 0.1, 0.1))
CLOTH = ls.Cloth(
    name="cloth",
    mesh=ls.grid(size=(0.2, 0.2), cells=(3, 3)),
    material=ls.ClothMaterial(density=0.1),
)


def cube(position=(0.0, 0.0, 0.5)):
    return ls.RigidBody(name="cube", mesh=CUBE, density=MASS / 1e-3, position=position)


def magnet():
    source = ls.magnetics.cuboid(size=(0.1, 0.1, 0.1), polarization=(0.0, 0.0, 1.0))
    return ls.Magnet(body="cube", source=source)


SCENES = {
    "alone": (ls.Scene(bodies=[cube()], gravity=(0, 0, 0)), None),
    "magnet": (ls.Scene(bodies=[cube()], magnets=[magnet()], gravity=(0, 0, 0)), None),
    "beside cloth": (ls.Scene(bodies=[cube()], cloths=[CLOTH], gravity=(0, 0, 0)), None),
    "asynchronous": (
        ls.Scene(bodies=[cube()], cloths=[CLOTH], gravity=(0, 0, 0)),
        ls.Asynchronous(),
    ),
}


def pushed(scene, integrator, force=FORCE, torque=TORQUE):
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    sim.external_body_forces = [force]
    sim.external_body_torques = [torque]
    return sim


@pytest.mark.parametrize("name", SCENES)
def test_a_force_changes_momentum_by_force_times_time(name):
    sim = pushed(*SCENES[name])
    for _ in range(20):
        sim.step()
    velocity = np.array(sim.state.body_velocities)[0]
    # The tolerance covers rounding in a sum of 20 increments.
    assert np.allclose(MASS * velocity, FORCE * sim.time, rtol=1e-12)
    inertia = MASS * 0.1**2 / 6.0  # of a cube, the same about every axis
    turning = np.array(sim.state.body_angular_velocities)[0]
    assert np.allclose(inertia * turning, TORQUE * sim.time, rtol=1e-6)


@pytest.mark.parametrize("name", SCENES)
def test_forces_act_until_they_are_changed(name):
    sim = pushed(*SCENES[name])
    sim.step()
    sim.state.external_body_forces[0] = 0.0
    sim.external_body_torques = [(0.0, 0.0, 0.0)]
    velocity = np.array(sim.state.body_velocities)
    sim.step()
    assert np.allclose(sim.state.body_velocities, velocity, rtol=1e-12)


def test_the_account_has_the_work_of_the_forces():
    sim = pushed(SCENES["alone"][0], None)
    for _ in range(50):
        sim.step()
    account = sim.report.account
    # The displacement of a step is h v(t + h), so the work is larger than the kinetic energy. After
    # 50 steps from rest, the difference is 1/50 of this energy.
    assert account.loads == pytest.approx(sim.report.energy.body_kinetic, rel=0.03)


def test_a_force_on_an_attached_body_pulls_the_cloth_along():
    place = CLOTH.mesh.vertices[0] - (0.0, 0.0, 0.06)  # the cube's top is 1 cm below the vertex
    scene = ls.Scene(
        cloths=[CLOTH],
        bodies=[cube(position=place)],
        attachments=[ls.Attachment(cloth="cloth", vertices=[0], body="cube")],
        gravity=(0, 0, 0),
    )
    sim = pushed(scene, None, torque=(0, 0, 0))
    for _ in range(20):
        sim.step()
    of_cloth = 0.1 * 0.2 * 0.2
    mean = sim.velocities.mean(0)
    momentum = MASS * np.array(sim.state.body_velocities)[0] + of_cloth * mean
    # `mean` is the unweighted mean over vertices, although their masses differ. The cloth has 1/125
    # of the mass of the body, so the error of the total momentum is less than 1 %.
    assert np.allclose(momentum, FORCE * sim.time, rtol=0.01, atol=1e-4)
    assert np.linalg.norm(mean) > 0.01 * np.linalg.norm(sim.state.body_velocities)


def test_a_checkpoint_contains_the_forces():
    sim = pushed(SCENES["alone"][0], None)
    saved = sim.checkpoint()
    other = ls.Simulation(SCENES["alone"][0], threads=1)
    other.restore(saved)
    assert np.array_equal(other.external_body_forces, [FORCE])
    assert np.array_equal(other.external_body_torques, [TORQUE])
    free = ls.Simulation(SCENES["alone"][0], threads=1)
    other.restore(free.checkpoint())
    assert not np.any(other.external_body_forces)


def test_wrong_forces_are_refused():
    sim = ls.Simulation(SCENES["alone"][0], threads=1)
    with pytest.raises(
        ls.InvalidInput, match="external_body_forces must be finite, but row 0 is not"
    ):
        sim.external_body_forces = [(np.nan, 0, 0)]
    with pytest.raises(ls.InvalidInput, match=r"external_body_torques must have shape \(1, 3\)"):
        sim.external_body_torques = [(0, 0, 0), (0, 0, 0)]
    sim.state.external_body_forces[0] = np.inf
    with pytest.raises(ls.InvalidInput, match="external_body_forces of body 0 must be finite"):
        sim.step()
