"""Work of friction in the account of energy."""

import loomstone as ls
import numpy as np
import pytest

INTEGRATORS = [
    ls.SemiImplicitEuler(),
    ls.SemiImplicitEuler(step=4e-3),
    ls.BackwardEuler(),
    ls.BDF2(),
    ls.Asynchronous(),
]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_turntable_works_on_a_disc_only_until_the_disc_turns_with_it(integrator):
    times = np.linspace(0.0, 1.5, 151)
    angles = np.zeros((151, 3))
    angles[:, 2] = 2.0 * times  # 2 rad/s
    table = ls.obstacles.box(
        size=(0.4, 0.4, 0.02),
        times=times,
        positions=np.tile([0.0, 0.0, -0.01], (151, 1)),
        axis_angles=angles,
        friction=1.0,
    )
    mesh = ls.meshes.disc(radius=0.08, triangles=100).moved((0, 0, 0.003))
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh, friction=1.0)], obstacles=[table])
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    while sim.time < 0.5:
        sim.step()
    early = sim.report
    while sim.time < 1.45:
        sim.step()
    late = sim.report
    # Sliding dissipates as much energy as the disc gains, so the work of the table is twice this
    # energy. Afterwards, contacts creep, and the table does a little work on them.
    gained = late.energy.kinetic
    assert gained == pytest.approx(early.energy.kinetic, rel=0.01)
    assert early.account.scripts == pytest.approx(2 * gained, rel=0.1)
    assert late.account.scripts == pytest.approx(early.account.scripts, abs=0.25 * gained)
    assert late.account.balance < 0


@pytest.mark.parametrize("slope", [1.06, 1.4])
def test_a_sheet_slides_down_an_incline_by_coulombs_law(slope):
    friction = 0.5
    angle = np.arctan(slope * friction)
    along = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    turn = np.column_stack([along, [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    box = ls.meshes.box(size=(4, 1, 0.1)).moved((0, 0, -0.05)).moved(rotation=turn)
    plane = ls.obstacles.mesh(box, friction=friction, thickness=1e-3)
    mesh = ls.meshes.irregular(size=(0.2, 0.2), triangles=150)
    mesh = mesh.moved((0, 0, 0.95e-3)).moved(rotation=turn)
    cloth = ls.Cloth(mesh=mesh, material=ls.fabrics["cotton"], friction=friction, thickness=1e-3)
    sim = ls.Simulation(ls.Scene(cloths=[cloth], obstacles=[plane]), threads=1)
    start = sim.positions.mean(axis=0)
    while sim.time < 1.0:
        sim.step()
    way = (sim.positions.mean(axis=0) - start) @ along
    # The friction coefficient for which Coulomb's law predicts this distance.
    measured = np.tan(angle) - 2.0 * way / (9.81 * np.cos(angle) * sim.time**2)
    assert measured == pytest.approx(friction, rel=0.02)


@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_a_tray_that_the_user_moves_carries_cloth_like_one_with_keyframes(step):
    times = np.linspace(0.0, 1.0, 1001)

    def place(t):
        return np.array([0.5 * 0.6 * 0.3 * 9.81 * t**2, 0.0, 0.0])  # 0.6 of the largest friction

    def slip(by_user):
        motion = (
            {} if by_user else {"times": times, "positions": np.array([place(t) for t in times])}
        )
        box = ls.meshes.box(size=(1, 1, 0.1)).moved((0, 0, -0.05))
        tray = ls.obstacles.mesh(box, friction=0.3, thickness=1e-3, **motion)
        mesh = ls.meshes.disc(radius=0.05, triangles=80).moved((0, 0, 0.0009))
        cloth = ls.Cloth(mesh=mesh, friction=0.3, thickness=1e-3)
        sim = ls.Simulation(
            ls.Scene(cloths=[cloth], obstacles=[tray]),
            integrator=ls.SemiImplicitEuler(step=step, accuracy=None),
            threads=1,
        )
        x0 = sim.positions[:, 0].mean()
        while sim.time < 0.8:
            if by_user:
                sim.set_obstacle_pose(0, position=place(sim.time + step))
            sim.step()
        return sim.positions[:, 0].mean() - x0 - place(sim.time)[0]

    assert slip(by_user=True) == pytest.approx(slip(by_user=False), abs=1e-5)
    assert abs(slip(by_user=True)) < 0.5e-3


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_friction_stops_a_sliding_sheet_and_takes_its_kinetic_energy(integrator):
    mesh = ls.grid(size=(0.2, 0.2), cells=(8, 8)).moved((0, 0, 0.0031))
    cloth = ls.Cloth(mesh=mesh, friction=0.3, velocities=np.tile([1.0, 0, 0], (81, 1)))
    floor = ls.floor(height=0.0, friction=0.3)
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], obstacles=[floor]), integrator=integrator, threads=1
    )
    while sim.time < 0.5:
        sim.step()
    kinetic = 0.5 * 0.04 * cloth.material.density * 1.0**2
    assert sim.report.energy.kinetic < 1e-3 * kinetic
    # The sheet also falls by 0.3 mm, and implicit Euler removes a few per cent of the energy.
    assert sim.report.account.friction == pytest.approx(kinetic, rel=0.04)
