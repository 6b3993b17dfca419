"""Bodies in bearings: contacts with bodies and obstacles, strong friction, energy balance."""

import loomstone as ls
import numpy as np
import pytest

LENGTH, WIDTH, LEVER = 0.1, 0.01, 0.04  # [m]
BAR = ls.meshes.box(size=(LENGTH, WIDTH, WIDTH))
MASS = 1000 * LENGTH * WIDTH**2
INERTIA = MASS * (LENGTH**2 + WIDTH**2) / 12  # about z [kg m^2]


def bar(restitution=0.0, **fields):
    """The bar lies along x and turns about z."""
    return ls.RigidBody(
        name="bar", mesh=BAR, shape="box", density=1000, restitution=restitution, **fields
    )


def ball(position, velocity, restitution):
    mesh = ls.meshes.sphere(radius=0.005, subdivisions=2)
    return ls.RigidBody(
        name="ball",
        mesh=mesh,
        shape="sphere",
        density=7000,
        friction=0.0,
        position=position,
        velocity=velocity,
        restitution=restitution,
    )


def simulation(bodies, obstacles=(), step=1e-3, gravity=(0, 0, 0), **bearing):
    scene = ls.Scene(
        bodies=bodies,
        obstacles=list(obstacles),
        gravity=gravity,
        bearings=[ls.Bearing(body="bar", axis=(0, 0, 1), **bearing)],
    )
    return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)


def run(sim, until):
    while sim.time < until - 1e-9:
        sim.step()


def angle(sim):
    """Angle by which the bar has turned about z [rad]."""
    w, _, _, z = sim.state.body_orientations[0]
    return 2 * np.arctan2(z, w)


@pytest.mark.parametrize("restitution", [0.0, 1.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_ball_turns_a_bar(restitution, turned):
    # The turned bar lies along y at the start.
    start, velocity, fields = (LEVER, -0.02, 0), (0, 1, 0), {}
    if turned:
        start, velocity = (0.02, LEVER, 0), (-1, 0, 0)
        fields = {"orientation": (np.sqrt(0.5), 0, 0, np.sqrt(0.5))}
    sim = simulation([bar(restitution, **fields), ball(start, velocity, restitution)])
    mass = ls.meshes.mass_properties(sim.scene.bodies[1].mesh, 7000).mass
    run(sim, 0.0125)  # the impact is at 10 ms
    spin = sim.state.body_angular_velocities[0]
    # Impulse of a frictionless impact of the ball on the lever.
    mobility = 1 / mass + LEVER**2 / INERTIA
    impulse = (1 + restitution) / mobility
    assert spin[2] == pytest.approx(LEVER * impulse / INERTIA, rel=0.02)
    speed = np.linalg.norm(sim.state.body_velocities[1])
    assert speed == pytest.approx(abs(1 - impulse / mass), abs=0.02)
    kinetic = 0.5 * mass - 0.5 * (1 - restitution**2) / mobility
    assert sim.report.energy.body_kinetic == pytest.approx(kinetic, rel=0.03)
    assert np.abs(spin[:2]).max() < 1e-9
    assert np.all(sim.state.body_velocities[0] == 0.0)
    assert np.abs(sim.body_centres[0]).max() < 1e-15


def test_a_fixed_stop_holds_a_driven_bar():
    stop = ls.obstacles.mesh(ls.meshes.sphere(radius=0.005), name="stop", centre=(LEVER, 0.02, 0))
    sim = simulation([bar()], [stop], torque=1e-3, gravity=(0, -9.81, 0))
    run(sim, 0.2)
    # The surfaces touch when the centre line of the bar is 1 cm from the sphere's centre.
    met = np.arctan2(0.02, LEVER) - np.arcsin(0.01 / np.hypot(0.02, LEVER))
    assert angle(sim) == pytest.approx(met, abs=0.01)
    assert np.abs(sim.state.body_angular_velocities[0]).max() < 1e-9
    # The kick before the impact counts the work up to the end of its step. The tolerance is the
    # work of one step at 7.5 rad/s.
    done = -sim.report.circuits.bearing_work
    assert done == pytest.approx(1e-3 * angle(sim), abs=1e-3 * 7.5 * 1e-3)


@pytest.mark.parametrize("step", [1e-4, 1e-3, 4e-3])
def test_a_driven_bar_bounces_off_a_stop_with_its_restitution(step):
    # The bar approaches the stop at 0.33 m/s. It returns from its rebound at less than 0.2 m/s,
    # below which bodies do not bounce. Restitution acts on the approach speed without the speed
    # that the torque adds within the step (0.02 m/s in 4 ms).
    ball = ls.meshes.sphere(radius=0.005, subdivisions=3)
    stop = ls.obstacles.mesh(ball, name="stop", centre=(LEVER, 0.02, 0))
    sim = simulation([bar(restitution=0.6)], [stop], step=step, torque=1e-3)
    spins, gain = [], 0.0
    while sim.time < 0.6 - 1e-9:
        sim.step()
        spins.append(sim.state.body_angular_velocities[0, 2])
        gain = max(gain, sim.report.account.balance)
    # The bar bounces within a step. The tolerance is the spin that the torque adds in this step.
    assert -min(spins) == pytest.approx(0.6 * max(spins), abs=1e-3 / INERTIA * step)
    assert gain < 1e-9
    assert abs(spins[-1]) < 1e-9, "the torque holds the bar at the stop"


def test_a_scripted_obstacle_turns_a_bar():
    push = ls.obstacles.mesh(
        ls.meshes.sphere(radius=0.005),
        name="push",
        times=[0, 0.1],
        positions=[(LEVER, -0.012, 0), (LEVER, 0.02, 0)],
    )
    friction, step = 1e-3, 1e-4  # without friction, the bar would swing ahead of the obstacle
    sim = simulation([bar()], [push], step=step, friction=friction)
    dissipated = 0.0
    while sim.time < 0.1 - 1e-9:
        sim.step()
        dissipated += friction * sim.state.body_angular_velocities[0, 2] ** 2 * step
    met = np.arctan2(0.02, LEVER) + np.arcsin(0.01 / np.hypot(0.02, LEVER))
    assert angle(sim) == pytest.approx(met, abs=0.01)
    assert sim.report.circuits.bearing_work == pytest.approx(dissipated, rel=0.02)
    assert sim.report.account.scripts > dissipated


@pytest.mark.parametrize("strength", [0.1, 1.9, 2.1, 4.1, 30.0, 1e6])
def test_friction_never_reverses_a_bar(strength):
    step, start = 1e-3, 10.0
    moving = bar(angular_velocity=(0, 0, start))
    sim = simulation([moving], step=step, friction=strength * INERTIA / step)
    last = start
    for _ in range(20):
        sim.step()
        spin = sim.state.body_angular_velocities[0, 2]
        assert 0 <= spin < last or spin == last == 0
        last = spin
        total = sim.report.energy.body_kinetic + sim.report.circuits.bearing_work
        assert total == pytest.approx(0.5 * INERTIA * start**2, rel=1e-9)


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ({"velocity": (0, 0, 1e-3)}, r"bodies\[0\].velocity must be 0"),
        ({"angular_velocity": (0, 1, 5)}, r"bodies\[0\].angular_velocity must be parallel"),
    ],
)
def test_initial_motion_against_a_bearing_is_refused(motion, message):
    with pytest.raises(ls.InvalidInput, match=message):
        simulation([bar(**motion)])


def test_initial_rotation_about_an_inclined_bearing_is_accepted():
    axis = np.array([0.0, 0.6, 0.8])
    orientation = (np.cos(0.5 * np.arctan2(0.6, 0.8)), -np.sin(0.5 * np.arctan2(0.6, 0.8)), 0, 0)
    turned = bar(orientation=orientation, angular_velocity=5 * axis)
    scene = ls.Scene(
        bodies=[turned], gravity=(0, 0, 0), bearings=[ls.Bearing(body="bar", axis=3 * axis)]
    )
    sim = ls.Simulation(scene, threads=1)
    run(sim, 0.01)
    assert sim.state.body_angular_velocities[0] == pytest.approx(5 * axis, rel=1e-9)
