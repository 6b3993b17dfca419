"""A simulation as seen from Python."""

import threading

import loomstone as ls
import numpy as np
import pytest
from loomstone.integrators import with_method


def test_a_simulation_knows_its_size_time_and_step(hanging, euler):
    sim = ls.Simulation(hanging, integrator=euler, threads=1)
    assert (sim.time, sim.step_index, sim.step_size, sim.threads, sim.rank, sim.ranks) == (
        0,
        0,
        4e-3,
        1,
        0,
        1,
    )
    sim.step()
    assert sim.time == pytest.approx(4e-3) and sim.step_index == 1
    assert (
        sim.report.step == 1
        and sim.report.solver.linear_iterations > 0
        and set(sim.report.seconds.to_dict()) >= {"loads", "integrate"}
    )
    assert sim.report.to_dict()["energy"]["kinetic"] > 0
    assert sim.report.busy.least == sim.report.busy.mean == sim.report.busy.most  # one thread
    assert 0 < sim.report.busy.most < sum(sim.report.seconds.to_dict().values())
    assert repr(sim) == "Simulation(81 vertices, 128 triangles, time=0.004, step=1)"
    assert sorted(sim.vertex_order) == list(range(81))
    assert sim.body_centres.shape == (0, 3)


def test_a_refused_simulation_can_be_shown():
    class Kept(ls.Simulation):
        def __init__(self, scene):
            shown.append(self)
            super().__init__(scene)

    shown = []
    with pytest.raises(ls.InvalidInput):
        Kept(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)), pins=[99])]))
    assert repr(shown[0]) == "Simulation(not built)"


def test_a_free_cloth_falls_as_semi_implicit_euler_says(euler):
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)))]), integrator=euler)
    for _ in range(10):
        sim.step()
    height = -9.81 * euler.step**2 * 10 * 11 / 2  # sum of h v over the steps
    assert sim.positions[:, 2] == pytest.approx(height, rel=1e-4)  # tolerance of the linear solver
    assert sim.velocities[:, 2] == pytest.approx(-9.81 * 0.04, rel=1e-4)


def test_frames_come_at_their_times_whatever_the_step_is(hanging):
    sim = ls.Simulation(hanging, integrator=ls.SemiImplicitEuler(step=3e-3))
    frames = list(sim.frames(duration=0.1, rate=25))
    assert [frame.time for frame in frames] == pytest.approx([0, 0.04, 0.08])
    assert frames[0].positions == pytest.approx(hanging.cloths[0].mesh.vertices)
    assert frames[0].positions.shape == (81, 3) and frames[0].velocities.shape == (81, 3)
    assert (
        frames[0].strain.shape == (128, 3)
        and frames[0].stretch.shape == (128,)
        and frames[0].contact.shape == (81,)
    )
    assert frames[0].body_vertices.shape == (0, 3)
    assert not frames[0].positions.flags.writeable
    assert frames[2].with_contact([1] * 81).contact.sum() == 81
    later = list(sim.frames(duration=0.16, rate=25))
    assert [frame.time for frame in later] == pytest.approx([0.12, 0.16])
    assert 0 < frames[2].step < later[0].step < later[1].step == sim.step_index


def test_a_report_that_is_kept_remains_that_of_its_step(hanging):
    sim = ls.Simulation(hanging, integrator=ls.SemiImplicitEuler(step=2e-3))
    kept, kinetic = [], []
    for _ in range(3):
        sim.step()
        kept.append(sim.report)
        kinetic.append(sim.report.energy.kinetic)
    assert [report.step for report in kept] == [1, 2, 3]
    assert [report.energy.kinetic for report in kept] == kinetic and 0 < kinetic[0] < kinetic[2]


def test_two_frames_within_one_step_lie_on_a_line(hanging):
    sim = ls.Simulation(hanging, integrator=ls.SemiImplicitEuler(step=0.01))
    a, b, c = list(sim.frames(duration=0.01, rate=200))
    assert (a.positions + c.positions) / 2 == pytest.approx(b.positions, abs=1e-15)
    assert (a.velocities + c.velocities) / 2 == pytest.approx(b.velocities, abs=1e-15)
    assert np.abs(c.velocities).max() > 0.05


def test_topology_describes_cloths_and_bodies(falling):
    topology = ls.Simulation(falling).topology
    assert topology.triangles.shape == (200, 3) and topology.corner_uv.shape == (600, 2)
    assert topology.cloth_names == ["cloth"] and topology.body_names == ["sphere", "floor"]
    assert set(topology.cloth_of_triangle) == set(topology.cloth_of_vertex) == {0}
    assert list(topology.body_is_floor) == [0, 1]
    assert len(topology.body_of_triangle) == len(topology.body_triangles) == 320 + 128
    assert topology.body_of_vertex.max() == 1


def test_positions_velocities_and_forces_can_be_read_and_written(hanging, euler):
    sim = ls.Simulation(hanging.replace(gravity=(0, 0, 0)), integrator=euler)
    moved = sim.positions + [0.1, 0.2, 0.3]
    sim.positions = moved
    assert np.array_equal(sim.positions, moved)
    sim.velocities = np.full((81, 3), 0.5)
    assert (sim.velocities == 0.5).all()
    forces = np.zeros((81, 3))
    forces[40, 2] = 1e-3
    sim.external_forces = forces
    assert np.array_equal(sim.external_forces, forces)
    with pytest.raises(
        ls.InvalidInput, match=r"positions must have shape \(81, 3\), got \(3, 81\)"
    ):
        sim.positions = moved.T
    with pytest.raises(ls.InvalidInput, match=r"targets must have shape \(81, 3\), got \(2, 3\)"):
        sim.set_pin_targets([[0, 0, 0], [1, 1, 1]])


def test_an_external_force_moves_the_cloth_in_its_direction(hanging, euler):
    sim = ls.Simulation(hanging.replace(gravity=(0, 0, 0)), integrator=euler)
    sim.external_forces = np.tile([0.0, 0.0, 1e-4], (81, 1))
    for _ in range(5):
        sim.step()
    assert sim.positions[9:, 2].min() > 0


def test_pins_move_to_their_targets(hanging, euler):
    sim = ls.Simulation(hanging, integrator=euler)
    start = sim.positions
    for i in range(5):
        targets = np.full((81, 3), np.nan)  # the rows of other vertices are ignored
        targets[[0, 8]] = start[[0, 8]] + [0, 0, 1e-3 * (i + 1)]
        sim.set_pin_targets(targets)
        sim.step()
    assert sim.positions[[0, 8]] == pytest.approx(start[[0, 8]] + [0, 0, 5e-3], abs=1e-12)


def test_obstacles_move_to_their_given_poses(falling, euler):
    sim = ls.Simulation(
        falling.replace(
            cloths=[
                falling.cloths[0].replace(
                    mesh=ls.grid(size=(0.3, 0.3), cells=(10, 10)).moved((0, 0, 0.5))
                )
            ]
        ),
        integrator=euler,
    )
    before = sim.frame().body_vertices[0].copy()
    sim.set_obstacle_pose(0, (0.0, 0.0, 0.01))
    sim.step()
    assert sim.frame().body_vertices[0] - before == pytest.approx((0, 0, 0.01))


def test_the_number_of_threads_changes_no_bit(falling, euler):
    digests = set()
    for threads in (1, 2, 3):
        sim = ls.Simulation(falling, integrator=euler, threads=threads)
        for _ in range(30):
            sim.step()
        digests.add(sim.digest())
    assert len(digests) == 1


def test_rebuilding_the_stages_changes_no_bit(falling, euler):
    sims = [ls.Simulation(falling, integrator=euler) for _ in range(2)]
    for step in range(20):
        for sim in sims:
            sim.step()
        if step == 10:
            sims[0].rebuild_stages()
    assert sims[0].digest() == sims[1].digest()


def test_a_checkpoint_continues_bit_for_bit(falling, euler, tmp_path):
    sim = ls.Simulation(falling, integrator=euler)
    for _ in range(12):
        sim.step()
    from loomstone import _core

    assert sim.may_checkpoint
    _core.write_checkpoint(str(tmp_path / "a.h5"), sim.checkpoint())
    other = ls.Simulation(falling, integrator=euler, threads=1)
    other.restore(_core.read_checkpoint(str(tmp_path / "a.h5")))
    assert other.digest() == sim.digest() and other.time == sim.time
    for _ in range(12):
        sim.step()
        other.step()
    assert other.digest() == sim.digest()


def test_a_checkpoint_of_another_scene_is_refused(falling, hanging, euler):
    with pytest.raises(ls.CacheError):
        ls.Simulation(hanging, integrator=euler).restore(
            ls.Simulation(falling, integrator=euler).checkpoint()
        )


def test_no_triangles_intersect_after_a_fall_on_a_sphere(falling, euler):
    sim = ls.Simulation(falling, integrator=euler)
    for frame in sim.frames(duration=0.4):  # noqa: B007
        assert sim.intersecting_pairs() == []
    assert frame.contact.any() and sim.report.contacts.near > 0


def test_a_step_lets_other_python_threads_run(hanging, euler):
    sim, seen = ls.Simulation(hanging, integrator=euler), []
    worker = threading.Thread(target=lambda: [sim.step() for _ in range(50)])
    worker.start()
    while worker.is_alive():
        seen.append(1)
    assert seen and sim.step_index == 50


def test_steps_of_one_simulation_from_two_threads_are_refused_not_mixed(hanging, euler):
    sim, reference = (ls.Simulation(hanging, integrator=euler, threads=1) for _ in range(2))
    taken, refused = [], []

    def walk():
        for _ in range(200):
            try:
                sim.step()
                taken.append(1)
            except ls.Unsupported as error:
                refused.append(str(error))

    walkers = [threading.Thread(target=walk) for _ in range(3)]
    for walker in walkers:
        walker.start()
    for walker in walkers:
        walker.join()
    assert len(taken) == sim.step_index and len(taken) + len(refused) == 600
    assert all("one thread at a time" in message for message in refused)
    for _ in taken:
        reference.step()
    assert (sim.positions == reference.positions).all()


def test_a_body_falls_as_fast_as_gravity_says():
    body = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.05, subdivisions=2),
        shape="sphere",
        position=(0, 0, 1),
    )
    cloth = ls.Cloth(mesh=ls.grid(cells=(2, 2)).moved((3, 0, 0)), pins=[0, 1, 2])
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], bodies=[body]), integrator=ls.SemiImplicitEuler(step=2e-3)
    )
    for _ in range(100):
        sim.step()
    # The tolerance is twice the first-order error g t h / 2 of the position.
    assert sim.body_centres[0, 2] == pytest.approx(1 - 9.81 / 2 * 0.04, abs=9.81 * 0.2 * 2e-3)


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda s: s.replace(cloths=[s.cloths[0].replace(pins=[999])]), "999"),
        (lambda s: s.replace(cloths=[s.cloths[0].replace(mesh=None)]), "mesh"),
        (lambda s: s.replace(cloths=[s.cloths[0].replace(bending="rubber")]), "bending"),
        (
            lambda s: s.replace(cloths=[s.cloths[0].replace(velocities=np.zeros((3, 3)))]),
            "velocities",
        ),
        (lambda s: s.replace(response="magic"), "response"),
        (
            lambda s: s.replace(
                attachments=[ls.Attachment(cloth="cloth", body="nobody", vertices=[1])]
            ),
            "nobody",
        ),
    ],
)
def test_what_cannot_be_simulated_is_refused_before_time_passes(hanging, change, message):
    with pytest.raises(ls.InvalidInput, match=message):
        ls.Simulation(change(hanging))


def test_an_unknown_integrator_is_refused_by_name(hanging):
    with pytest.raises(ls.InvalidInput, match="rk4"):
        ls.Simulation(hanging, integrator=with_method(ls.SemiImplicitEuler(), "rk4"))


def test_a_communicator_must_be_one(hanging):
    with pytest.raises(ls.InvalidInput, match="communicator must be"):
        ls.Simulation(hanging, communicator="world")
    alone = ls.ranks.single_communicator()
    assert (alone.rank, alone.size, alone.maximum(3)) == (0, 1, 3) and repr(
        alone
    ) == "Communicator(rank 0 of 1)"
    alone.barrier()
    assert ls.Simulation(hanging, communicator=alone).ranks == 1 and not ls.ranks.launched_by_mpi()


@pytest.mark.parametrize(
    "duration, rate", [(-1, 25), (float("nan"), 25), (1, 0), (1, float("inf"))]
)
def test_durations_and_rates_must_make_sense(hanging, duration, rate):
    with pytest.raises(ls.InvalidInput, match="must be"):
        next(ls.Simulation(hanging).frames(duration=duration, rate=rate))


def test_a_failed_step_says_where_and_keeps_the_last_good_state(hanging):
    sim = ls.Simulation(hanging, integrator=ls.ExplicitEuler(step=0.05))
    with pytest.raises(ls.SolverFailure, match="step"):
        for _ in range(2000):
            sim.step()
    assert np.isfinite(sim.positions).all()


@pytest.mark.parametrize("solver", ["pcg", "direct"])
@pytest.mark.parametrize("scheme", [ls.SemiImplicitEuler, ls.ImplicitMidpoint])
def test_a_step_whose_matrix_is_indefinite_is_taken_in_parts(scheme, solver):
    # The exact Jacobian of compressed cloth is indefinite. In short parts, the mass outweighs it.
    mesh = ls.grid(size=(0.3, 0.3), cells=(10, 10))
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh)], gravity=(0, 0, 0), collisions=False)
    steps = scheme(step=0.02, accuracy=None, jacobian="exact", linear_solver=solver)
    sim = ls.Simulation(scene, integrator=steps)
    noise = np.random.default_rng(1).normal(size=mesh.vertices.shape)
    sim.positions = 0.7 * mesh.vertices + 1e-4 * noise
    sim.step()
    assert sim.time == 0.02 and sim.report.parts > 4


@pytest.mark.parametrize("scheme", [ls.ImplicitMidpoint, ls.BDF2, ls.NonlinearMidpoint])
def test_schemes_without_damping_do_not_amplify_stiff_bending(scheme):
    # Explicit bending would increase the energy of this sheet by 7 % or more. With step=1e-3 and
    # accuracy=None, it would multiply the energy by more than 1,000.
    mesh = ls.grid(size=(0.1, 0.1), cells=(6, 6))
    material = ls.ClothMaterial(bending_weft=1e-3, bending_warp=1e-3)
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh, material=material)], gravity=(0, 0, 0))
    sim = ls.Simulation(scene, integrator=scheme())
    sim.velocities = np.outer(np.random.default_rng(7).normal(size=49), [0, 0, 0.02])
    energies = []
    while sim.time < 0.1:
        sim.step()
        energy = sim.report.energy
        energies.append(energy.kinetic + energy.membrane + energy.bending)
    # The tolerances cover those of the linear solver and of Newton's method.
    assert max(energies) < 1.001 * energies[0]
    assert scheme is ls.BDF2 or energies[-1] > 0.99 * energies[0]


@pytest.mark.parametrize("scheme", [ls.ImplicitMidpoint, ls.BDF2, ls.NonlinearMidpoint])
def test_schemes_without_damping_gain_little_energy_where_steps_are_long(scheme):
    # Waves cross this stiff sheet in a fraction of a step. With step=1e-3 and accuracy=None, the
    # nonlinear midpoint rule would gain 2.7 times the largest kinetic energy.
    mesh = ls.grid(size=(0.03, 0.03), cells=(8, 8))
    material = ls.ClothMaterial(weft_stiffness=6e4, warp_stiffness=6e4, shear_stiffness=2e4)
    pins = [0, 8, 40]
    cloth = ls.Cloth(mesh=mesh, material=material, pins=pins)
    sim = ls.Simulation(ls.Scene(cloths=[cloth], collisions=False), integrator=scheme())
    velocities = np.zeros_like(mesh.vertices)
    velocities[:, 2] = 0.03 * np.cos(np.pi * mesh.vertices[:, 0] / 0.03)
    velocities[pins] = 0.0
    sim.velocities = velocities
    while sim.time < 0.05:
        sim.step()
        # Steps that begin with a balance above 0.02 are taken by backward Euler, which damps. The
        # step in which the balance rises above this bound is not, and may add as much again.
        assert sim.report.account.balance < 0.04


@pytest.mark.parametrize("element", ["mid-edge", "hinge"])
def test_damped_bending_takes_energy_at_any_step(element):
    # Explicit bending would be stable at this step without damping. With damping, explicit bending
    # of hinges would gain energy in some steps.
    material = ls.ClothMaterial(bending_weft=1e-5, bending_warp=1e-5, bending_damping=0.1)
    mesh = ls.grid(size=(0.2, 0.2), cells=(8, 8))
    scene = ls.Scene(
        cloths=[ls.Cloth(mesh=mesh, material=material, bending=element)], gravity=(0, 0, 0)
    )
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3))
    sim.velocities = np.outer(np.random.default_rng(7).normal(size=81), [0, 0, 0.05])
    energies = []
    for _ in range(50):
        sim.step()
        energies.append(
            sim.report.energy.kinetic + sim.report.energy.membrane + sim.report.energy.bending
        )
    assert np.all(np.diff(energies) <= 1e-5 * energies[0])  # tolerance of the linear solver
    assert energies[-1] < 0.5 * energies[0]


@pytest.mark.parametrize("shape", ["sphere", "capsule"])
def test_a_turning_obstacle_turns_the_cloth_on_it(shape):
    keys = dict(
        times=[0, 0.1, 0.4],
        positions=[(0, 0, 0)] * 3,
        axis_angles=[(0, 0, 0), (0, 0, 0), (0, 0, 0.9)],
        friction=0.5,
    )
    if shape == "sphere":
        ball = ls.obstacles.sphere(radius=0.1, **keys)
    else:
        ball = ls.obstacles.capsule(radius=0.1, length=0.02, **keys)
    mesh = ls.grid(size=(0.2, 0.2), triangles=200)
    cloth = ls.Cloth(mesh=mesh.moved((0, 0, ball.mesh.vertices[:, 2].max() + 2e-3)), friction=0.5)
    sim = ls.Simulation(ls.Scene(cloths=[cloth], obstacles=[ball]), threads=1)
    *_, frame = sim.frames(duration=0.4, rate=10)
    turned = frame.positions @ (1, 1j, 0) / ((mesh.vertices @ (1, 1j, 0)) + 1e-9)
    # Without friction, the cloth would turn by 0.15 to 0.21 rad. The obstacle turns by 0.9 rad;
    # slip at the start makes the cloth turn less.
    assert 0.45 < np.median(np.angle(turned)) < 0.95


@pytest.mark.parametrize("name", ["scene", "integrator", "communicator", "preparation_seconds"])
def test_what_a_simulation_was_made_of_cannot_be_replaced(name):
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)))]), threads=1)
    with pytest.raises(AttributeError):
        setattr(sim, name, getattr(sim, name))
