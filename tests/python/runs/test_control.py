"""Functions that control a run."""

import loomstone as ls
import pytest


def test_control_acts_before_every_step(hanging, euler, tmp_path):
    times = []
    ls.Simulation(hanging, integrator=euler).run(
        out=tmp_path / "r", duration=0.04, control=lambda sim: times.append(sim.time)
    )
    assert len(times) == 10 and times[0] == 0


def test_a_control_that_is_no_function_or_moves_the_simulation_in_time_is_refused(
    hanging, euler, tmp_path
):
    sim = ls.Simulation(hanging, integrator=euler)
    start = sim.checkpoint()
    with pytest.raises(ls.InvalidInput, match="control must be a function, got 3"):
        sim.run(out=tmp_path / "r", duration=0.04, control=3)
    assert not (tmp_path / "r").exists()
    for control in (lambda sim: sim.step(), lambda sim: sim.time and sim.restore(start)):
        with pytest.raises(ls.InvalidInput, match="must not step or restore"):
            sim.run(out=tmp_path / "r", duration=0.04, control=control, overwrite=True)
        sim.restore(start)
