"""State between steps: views of the internal tables, and copies in the user's order."""

import gc

import loomstone as ls
import numpy as np
import pytest

INTEGRATORS = [
    ls.ExplicitEuler(step=1e-4),
    ls.SymplecticEuler(step=1e-4),
    ls.SemiImplicitEuler(step=4e-3),
    ls.BackwardEuler(step=4e-3),
    ls.ImplicitMidpoint(step=1e-3),
    ls.NonlinearMidpoint(step=1e-3),
    ls.BDF2(step=1e-3),
    ls.Asynchronous(),
]


@pytest.fixture
def sim(falling, euler):
    return ls.Simulation(falling, integrator=euler, threads=1)


def advance(sim, steps):
    for _ in range(steps):
        sim.step()


def address(array):
    return array.__array_interface__["data"][0]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda options: options.method)
def test_views_show_the_present_without_a_copy_whatever_the_integrator_does(hanging, integrator):
    sim = ls.Simulation(hanging, integrator=integrator, threads=1)
    x, v, order = sim.state.positions, sim.state.velocities, sim.vertex_order
    for _ in range(3):
        sim.step()
        assert np.array_equal(x[order], sim.positions) and np.array_equal(v[order], sim.velocities)
    assert v.any() and address(x) == address(sim.state.positions)


def test_views_stay_good_over_restore_failure_and_assignment(hanging):
    sim = ls.Simulation(hanging, integrator=ls.ExplicitEuler(step=0.05))
    x = sim.state.positions
    start = sim.checkpoint()
    with pytest.raises(ls.SolverFailure):
        advance(sim, 2000)
    assert np.array_equal(x[sim.vertex_order], sim.positions)
    sim.restore(start)
    assert np.array_equal(x[sim.vertex_order], hanging.cloths[0].mesh.vertices)
    sim.positions = sim.positions + 1.0
    sim.state.positions += 1.0  # `+=` also assigns the attribute
    assert np.array_equal(x[sim.vertex_order], hanging.cloths[0].mesh.vertices + 2.0)


def test_a_view_keeps_its_simulation_alive(falling, euler):
    sim = ls.Simulation(falling, integrator=euler)
    view, kept = sim.state.positions, sim.positions
    order = np.array(sim.vertex_order)
    del sim
    gc.collect()
    assert np.array_equal(view[order], kept)


def test_positions_are_a_copy_in_the_users_order_and_state_the_internal_table(sim, falling):
    copied = sim.positions
    copied[:] = 0
    assert np.array_equal(sim.positions, falling.cloths[0].mesh.vertices)
    assert not np.array_equal(sim.state.positions, sim.positions)  # the internal order differs
    assert np.array_equal(sim.state.positions[sim.vertex_order], sim.positions)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda options: options.method)
def test_writing_a_view_and_assigning_a_copy_have_the_same_effect(falling, integrator):
    sims = [ls.Simulation(falling, integrator=integrator, threads=1) for _ in range(2)]
    for sim in sims:
        advance(sim, 3)
    lift = np.linspace(0, 1e-3, 121)
    one, other = sims
    one.positions = one.positions + np.outer(lift, [0, 0, 1])
    one.velocities = one.velocities * 0.5
    other.state.positions[other.vertex_order, 2] += lift
    other.state.velocities[:] *= 0.5
    for sim in sims:
        advance(sim, 3)
    assert one.digest() == other.digest()


def test_a_checkpoint_taken_after_writing_continues_as_the_simulation_does(falling):
    sim = ls.Simulation(falling, integrator=ls.BDF2(step=2e-3), threads=1)
    advance(sim, 3)
    sim.state.velocities[:, 0] += 0.1
    kept = sim.checkpoint()
    advance(sim, 3)
    other = ls.Simulation(falling, integrator=ls.BDF2(step=2e-3), threads=1)
    other.restore(kept)
    advance(other, 3)
    assert other.digest() == sim.digest()


def test_reading_the_state_changes_no_bit(falling, euler):
    sims = [ls.Simulation(falling, integrator=euler, threads=1) for _ in range(2)]
    for _ in range(10):
        for sim in sims:
            sim.step()
        sims[0].state.positions.sum()
        sims[0].gather()
    assert sims[0].digest() == sims[1].digest()


def test_forces_pins_and_poses_are_tables_as_well(falling, euler):
    pinned = falling.replace(
        cloths=[falling.cloths[0].replace(pins=[0, 10])],
        obstacles=[ls.floor(height=-1), ls.floor(name="b", height=-2)],
    )
    by_calls, by_tables = (ls.Simulation(pinned, integrator=euler, threads=1) for _ in range(2))
    force, goal = np.zeros((121, 3)), by_calls.positions + [0, 0, 1e-3]
    force[60, 2] = 1e-3
    by_calls.external_forces = force
    by_calls.set_pin_targets(goal)
    by_calls.set_obstacle_pose(1, (0, 0, -0.01), (0, 0, 0, 1))
    state, order = by_tables.state, by_tables.vertex_order
    state.external_forces[order] = force
    state.pin_targets[order] = goal
    state.pin_flags[order[[0, 10]]] = 1
    state.obstacle_positions[1], state.obstacle_orientations[1], state.obstacle_flags[1] = (
        (0, 0, -0.01),
        (0, 0, 0, 1),
        1,
    )
    for sim in (by_calls, by_tables):
        advance(sim, 2)
    assert np.array_equal(by_calls.positions, by_tables.positions)
    assert by_calls.positions[[0, 10]] == pytest.approx(goal[[0, 10]], abs=1e-12)
    assert np.array_equal(by_calls.state.obstacle_vertices, state.obstacle_vertices)
    assert state.obstacle_vertices[81:, 2] == pytest.approx(-2.01)


def test_a_pose_set_before_the_first_step_moves_bodies_in_the_same_way_after_a_restore(euler):
    """In one step, the obstacle moves from its first pose to the one given, and pushes the box."""
    box = ls.RigidBody(mesh=ls.meshes.box(size=(0.1,) * 3), shape="box", position=(0, 0, 0.05))
    slab = ls.obstacles.mesh(ls.meshes.box(size=(1, 1, 0.1)).moved((0, 0, -0.05)))
    scene = ls.Scene(bodies=[box], obstacles=[slab])
    digests = []
    for restored in (False, True):
        sim = ls.Simulation(scene, integrator=euler, threads=1)
        sim.set_obstacle_pose(0, (0.01, 0, 0.005))
        if restored:
            checkpoint = sim.checkpoint()
            sim = ls.Simulation(scene, integrator=euler, threads=1)
            sim.restore(checkpoint)
        advance(sim, 5)
        digests.append(sim.digest())
    assert digests[0] == digests[1]


def test_bodies_can_be_seen_but_only_bullet_moves_them(euler):
    body = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.05, subdivisions=2),
        shape="sphere",
        position=(0, 0, 1),
    )
    sim = ls.Simulation(ls.Scene(bodies=[body]), integrator=euler)
    advance(sim, 5)
    state = sim.state
    assert state.body_centres.shape == (1, 3) and state.body_orientations.shape == (1, 4)
    assert (
        state.body_velocities[0, 2] == pytest.approx(-9.81 * sim.time)
        and not state.body_angular_velocities.any()
    )
    for name in (
        "body_centres",
        "body_orientations",
        "body_velocities",
        "body_angular_velocities",
        "obstacle_vertices",
    ):
        assert not getattr(state, name).flags.writeable
    assert repr(state) == "State(step 5, 0 cloth rows, 1 bodies, 0 obstacles)"


@pytest.mark.parametrize("table", ["positions", "velocities", "external_forces"])
def test_nan_in_a_table_is_one_error_at_the_next_step_and_can_be_taken_back(sim, table):
    before = sim.digest()
    view = getattr(sim.state, table)
    vertex = 17
    row = sim.vertex_order[vertex]
    kept = view[row].copy()
    view[row, 1] = np.nan
    for _ in range(2):
        with pytest.raises(
            ls.InvalidInput,
            match=rf"{table} of vertex 17 \(row {row}\) must be finite, got \(.*nan",
        ):
            sim.step()
    view[row] = kept
    assert sim.digest() == before and sim.step_index == 0
    sim.step()


def test_nan_in_pins_and_poses_counts_where_they_are_flagged(falling, euler):
    sim = ls.Simulation(
        falling.replace(cloths=[falling.cloths[0].replace(pins=[3])]), integrator=euler
    )
    row = sim.vertex_order[3]
    sim.state.pin_targets[row] = np.nan
    sim.state.obstacle_positions[0] = np.nan
    sim.step()
    sim.state.pin_flags[row] = 1
    with pytest.raises(ls.InvalidInput, match="pin_targets of vertex 3"):
        sim.step()
    sim.state.pin_targets[row] = sim.positions[3]
    sim.state.obstacle_flags[0] = 1
    with pytest.raises(ls.InvalidInput, match="obstacle_positions of obstacle 0"):
        sim.step()
    sim.state.obstacle_positions[0] = 0, 0, 0
    sim.state.obstacle_orientations[0] = 2, 0, 0, 0
    with pytest.raises(
        ls.InvalidInput, match="obstacle_orientations of obstacle 0 must be a unit quaternion"
    ):
        sim.step()
    sim.state.obstacle_orientations[0] = 1, 0, 0, 0
    sim.step()


def test_energies_follow_what_is_written(sim):
    sim.step()
    before = sim.report.energy.kinetic
    sim.state.velocities[:] *= 2
    assert sim.report.energy.kinetic == pytest.approx(4 * before)


def test_tables_of_the_wrong_shape_are_refused(sim):
    with pytest.raises(
        ls.InvalidInput, match=r"positions must have shape \(121, 3\), got \(3, 121\)"
    ):
        sim.state.positions = sim.positions.T
    with pytest.raises(AttributeError):
        sim.state.position = 0
    with pytest.raises(AttributeError):
        sim.position = sim.positions  # a misspelt name creates no attribute


def test_one_rank_owns_all_rows_and_counts_its_loops(sim):
    assert sim.owned_rows == (0, 121) and sim.loop_iterations == 0
    sim.step()
    one = sim.loop_iterations
    sim.step()
    assert one > 0 and sim.loop_iterations > one
    assert sim.communicator.size == 1
