"""Sources of fields, magnetisable bodies, frames, topologies, checkpoints and runs can be pickled
and copied. Copies give bitwise identical results.
"""

import copy
import pickle

import loomstone as ls
import numpy as np
import pytest

M = ls.magnetics
BALL = ls.meshes.sphere(radius=0.01, subdivisions=1)
POINTS = np.array([[0.02, 0.01, 0.03], [0.0, 0.0, 0.05]])
SOURCES = {
    "cuboid": lambda: M.cuboid(size=(0.01, 0.02, 0.01), polarization=[0, 0, 1.2]),
    "cylinder": lambda: M.cylinder(radius=0.01, height=0.01, polarization=(0, 1, 0)),
    "sphere": lambda: M.sphere(radius=0.01, polarization=(0, 0, 1)),
    "mesh": lambda: M.mesh(BALL.moved((0.001, 0, 0)), polarization=(0, 0, 1)),
    "dipoles": lambda: M.dipoles(POINTS - 0.1, [[0, 0, 1], [0, 1, 0]]),
    "loop": lambda: M.loop(radius=0.01, current=2.0),
    "solenoid": lambda: M.solenoid(radius=0.01, length=0.02, turns=50, current=1.0),
    "polyline": lambda: M.polyline([[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0]], current=2.0),
    "cells": lambda: M.cells(M.sphere(radius=0.01, polarization=(0, 0, 1)), density=1e7),
}
SOFT = {
    "sphere": lambda: M.soft_sphere(radius=0.01, susceptibility=100.0, saturation=2.0),
    "cuboid": lambda: M.soft_cuboid(size=(0.01, 0.01, 0.01), susceptibility=100.0, cells=8),
    "cylinder": lambda: M.soft_cylinder(radius=0.005, height=0.01, susceptibility=100.0),
    "mesh": lambda: M.soft_mesh(BALL, susceptibility=100.0, panels=100),
    "other": lambda: M.soft_sphere(radius=0.01, susceptibility=1.0).with_susceptibility(50.0),
}


def twice(value):
    return pickle.loads(pickle.dumps(value)), copy.deepcopy(value)


@pytest.mark.parametrize("kind", SOURCES)
def test_a_source_has_the_same_field_again_wherever_it_is(kind):
    made = SOURCES[kind]().moved((0.001, 0, 0.002)).rotated((0.3, 0.1, -0.2))
    for again in twice(made):
        assert np.array_equal(again.position, made.position)
        assert np.array_equal(again.orientation, made.orientation)
        assert np.array_equal(M.field(again, POINTS), M.field(made, POINTS))


@pytest.mark.parametrize("kind", SOFT)
def test_a_soft_body_magnetises_again_as_it_did(kind):
    made = SOFT[kind]().moved((0.0, 0.0, 0.002)).rotated((0.1, 0.0, 0.0))
    magnet = M.sphere(radius=0.005, polarization=(0, 0, 1)).moved((0, 0, 0.03))
    for again in twice(made):
        assert again.susceptibility == made.susceptibility and again.saturation == made.saturation
        old, new = (M.induce(body, by=magnet).bodies[0] for body in (made, again))
        assert np.array_equal(M.field(new, POINTS), M.field(old, POINTS))


def test_inputs_can_be_changed_afterwards():
    size = np.array([0.01, 0.01, 0.01])
    made = M.cuboid(size=size, polarization=(0, 0, 1))
    before = M.field(made, POINTS)
    size[:] = 1.0
    assert np.array_equal(M.field(pickle.loads(pickle.dumps(made)), POINTS), before)


def test_bodies_not_made_by_a_function_refuse_pickling_with_the_reason():
    magnet = M.sphere(radius=0.005, polarization=(0, 0, 1)).moved((0, 0, 0.03))
    (induced,) = M.induce(SOFT["sphere"](), by=magnet).bodies
    with pytest.raises(ls.Unsupported, match="pickle its SoftBody and induce"):
        pickle.dumps(induced)


def test_a_frame_and_its_topology_are_the_same_again(falling, euler):
    sim = ls.Simulation(falling, integrator=euler, threads=1)
    for _ in range(5):
        sim.step()
    frame, topology = sim.frame(), sim.topology
    for again in twice(frame):
        for name in ("positions", "velocities", "strain", "stretch", "contact", "body_vertices"):
            assert np.array_equal(getattr(again, name), getattr(frame, name)), name
        assert again.time == frame.time and again.step == frame.step == 5
        assert again.report.to_dict() == frame.report.to_dict()
    for again in twice(topology):
        assert np.array_equal(again.triangles, topology.triangles)
        assert np.array_equal(again.body_of_vertex, topology.body_of_vertex)
        assert again.cloth_names == topology.cloth_names
        assert again.body_names == topology.body_names


def test_a_checkpoint_that_has_been_pickled_is_continued_bit_for_bit(falling, euler):
    sims = [ls.Simulation(falling, integrator=euler, threads=1) for _ in range(3)]
    sims[0].step()
    kept = sims[0].checkpoint()
    for sim, again in zip(sims[1:], twice(kept), strict=True):
        sim.restore(again)
    for sim in sims:
        sim.step()
    assert len({sim.digest() for sim in sims}) == 1


def test_a_run_is_pickled_as_its_path(hanging, euler, tmp_path):
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=tmp_path / "run", duration=0.08)
    run = ls.Run(tmp_path / "run")
    for again in twice(run):
        assert again.directory == run.directory and len(again) == 3
        assert np.array_equal(again[-1].positions, run[-1].positions)
