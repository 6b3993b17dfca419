"""Cloth that is at rest stays at rest, and requires few linear iterations. Slow motion requires as
many as fast motion.
"""

import loomstone as ls
import numpy as np
import pytest


@pytest.mark.parametrize("integrator", [ls.SemiImplicitEuler(), ls.BDF2(step=2e-3)])
def test_a_sheet_at_rest_on_a_floor_needs_hardly_any_linear_iterations(integrator):
    sheet = ls.Cloth(mesh=ls.grid(size=(0.2, 0.2), cells=(12, 12)).moved((0, 0, 0.004)))
    sim = ls.Simulation(
        ls.Scene(cloths=[sheet], obstacles=[ls.floor()]), integrator=integrator, threads=1
    )
    while sim.time < 0.5:
        sim.step()
    before, iterations = sim.positions.copy(), []
    for _ in range(100):
        sim.step()
        iterations.append(sim.report.solver.linear_iterations)
    # A tolerance relative to the vanishing right-hand side would require more iterations.
    assert np.mean(iterations) < 2.0
    # A residual of 1e-4 of the weight would bring a free vertex to 1e-5 m/s in a step of 10 ms.
    assert np.abs(sim.velocities).max() < 5e-6
    assert np.abs(sim.positions - before).max() < 1e-6


def test_a_slow_motion_without_gravity_is_solved_as_accurately_as_a_fast_one():
    """Both motions are small, so forces scale with speed, and both take equally many iterations."""
    counts = []
    for speed in (1.0, 1e-4):
        sheet = ls.Cloth(
            mesh=ls.grid(size=(0.2, 0.2), cells=(12, 12)),
            velocities=np.outer(np.sin(np.arange(169.0)), (speed * 1e-4, 0, 0)),
        )
        sim = ls.Simulation(
            ls.Scene(cloths=[sheet], gravity=(0, 0, 0)),
            integrator=ls.SemiImplicitEuler(step=1e-3, accuracy=None),
            threads=1,
        )
        sim.step()
        counts.append(sim.report.solver.linear_iterations)
    assert counts[0] == counts[1] > 3
