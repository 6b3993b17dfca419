"""In free motion, stiff, light cloth gains at most about 2 % of its largest kinetic energy with the
default tolerance of linear solves, also with a heavy body, and while an obstacle moves far away. In
schemes without damping, a pendulum keeps its period with this tolerance.
"""

import loomstone as ls
import numpy as np
import pytest


def material(stiffness, density):
    return ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness,
        shear_stiffness=stiffness / 3,
        density=density,
    )


def largest_balance(sim, until):
    balance = 0.0
    while sim.time < until:
        sim.step()
        balance = max(balance, sim.report.account.balance)
    return balance


@pytest.mark.parametrize("step", [None, 1e-2])
def test_a_spinning_strip_gains_nothing(step):
    mesh = ls.meshes.strip(length=0.4, width=0.06, triangles=250)
    x = mesh.vertices
    cloth = ls.Cloth(
        mesh=mesh,
        material=material(1e5, 0.03),
        velocities=np.cross(np.array([5.0, 0.0, 2.5]), x - x.mean(0)),
    )
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], gravity=(0, 0, 0)),
        integrator=ls.SemiImplicitEuler() if step is None else ls.SemiImplicitEuler(step=step),
        threads=1,
    )
    # Solves become more accurate while energy is gained (tolerance_factor() in
    # core/sim/step/integrate.cpp). Otherwise, the balance would be larger by 0.057 (automatic
    # steps) or 0.164 (10 ms).
    assert largest_balance(sim, 2.0) < 0.0205


def pendulum():
    """A ball on a very stiff strip that hangs at 10 degrees to the vertical."""
    length, width, radius, tilt = 0.3, 0.02, 0.02, np.radians(10)
    mesh = ls.meshes.strip(length=length, width=width, triangles=120)
    mesh = mesh.moved((-mesh.vertices[:, 0].min(), 0, 0))
    from_end = mesh.vertices[:, 0]
    down, across = np.array([np.sin(tilt), 0, -np.cos(tilt)]), np.array([0.0, 1.0, 0.0])
    hung = mesh.moved((0, 0, 0), rotation=np.c_[down, across, np.cross(down, across)])
    strip = ls.Cloth(
        name="strip",
        mesh=hung,
        material=material(1e5, 0.03),
        pins=np.flatnonzero(from_end < 1e-9),
    )
    ball = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=radius, subdivisions=2),
        shape="sphere",
        mass=10 * 0.03 * length * width,
        position=(length + radius) * down,
    )
    low = np.flatnonzero(from_end > length - 1e-9)
    return ls.Scene(
        cloths=[strip],
        bodies=[ball],
        attachments=[ls.Attachment(cloth="strip", vertices=low, body="ball")],
        collisions=False,
    )


def test_a_pendulum_on_a_stiff_strip_gains_nothing():
    sim = ls.Simulation(pendulum(), threads=1)
    # If all solves had the default tolerance, the balance would be larger by 0.17.
    assert largest_balance(sim, 1.2) < 0.0205


@pytest.mark.parametrize("step", [4e-3, 1e-2])
def test_a_far_moving_obstacle_does_not_add_energy(step):
    mesh = ls.grid(size=(0.3, 0.3), cells=(10, 10))
    corners = np.flatnonzero(np.all(np.abs(mesh.vertices[:, :2] - [-0.15, 0]) > [-1, 0.149], 1))
    pins = corners[mesh.vertices[corners, 0] < -0.149]
    cloth = ls.Cloth(mesh=mesh, material=material(1e5, 0.03), pins=pins)
    far = ls.sphere(radius=0.05, times=[0, 1], positions=[(2, 0, 0), (2, 0, 1)])
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], obstacles=[far]),
        integrator=ls.SemiImplicitEuler(step=step),
        threads=1,
    )
    # While an obstacle moves and cloth has contacts, a gain of energy shortens no part of a given
    # step below a quarter of the step. If this also held for an obstacle that the cloth does not
    # touch, the balance would be 0.12 (4 ms) or 0.14 (10 ms).
    assert largest_balance(sim, 0.4) < 0.0205


@pytest.mark.parametrize("scheme", [ls.ImplicitMidpoint, ls.BDF2])
def test_the_default_tolerance_keeps_the_period_of_schemes_that_do_not_damp(scheme):
    def second_passage(**options):
        sim = ls.Simulation(pendulum(), integrator=scheme(**options), threads=1)
        passages, before = [], (0.0, sim.state.body_centres[0, 0])
        while len(passages) < 2:
            sim.step()
            now = sim.time, sim.state.body_centres[0, 0]
            if before[1] * now[1] <= 0.0:
                share = before[1] / (before[1] - now[1])
                passages.append(before[0] + share * (now[0] - before[0]))
            before = now
        return passages[1]

    assert second_passage() == pytest.approx(second_passage(tolerance=1e-7), rel=0.005)
