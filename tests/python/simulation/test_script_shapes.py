"""Positions over time may be given per time and vertex, or as rows; other shapes are refused."""

import re

import loomstone as ls
import numpy as np
import pytest

GRID = ls.grid(size=(0.2, 0.2), cells=(2, 2))
START = np.asarray(GRID.vertices)
TIMES = [0.0, 0.1, 0.2]
SHIFTS = np.array([0.0, 0.01, 0.03])[:, None, None] * (0.0, 0.0, 1.0)  # (times x 1 x 3)
PINNED = START[:2] + SHIFTS  # (times x pins x 3)
MOVED = START + SHIFTS  # (times x n x 3)


def cloth(positions, **fields):
    return ls.Cloth(
        **({"mesh": GRID, "pins": [0, 1], "script_times": TIMES} | fields),
        script_positions=positions,
    )


def obstacle(positions):
    return ls.Obstacle(mesh=GRID, times=TIMES, vertex_positions=positions)


def test_positions_of_pins_may_have_one_row_per_time_and_pin():
    rows = PINNED.reshape(-1, 3)
    assert np.array_equal(cloth(rows).script_positions, rows)
    for positions in (
        PINNED,
        PINNED.tolist(),
        list(PINNED),
        100.0 * PINNED * ls.units["cm"],
        np.asfortranarray(PINNED),
    ):
        assert cloth(positions).script_positions == pytest.approx(rows, abs=1e-15)
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth(PINNED)], collisions=False),
        integrator=ls.SemiImplicitEuler(step=0.05),
        threads=1,
    )
    for _ in range(4):
        sim.step()
    assert sim.positions[:2] == pytest.approx(PINNED[-1], abs=1e-12)


def test_positions_may_be_replaced_in_both_shapes():
    changed = cloth(PINNED).replace(script_positions=2.0 * PINNED)
    assert np.array_equal(changed.script_positions, 2.0 * PINNED.reshape(-1, 3))
    fewer = cloth(PINNED).replace(script_positions=PINNED[:2], script_times=[0.0, 1.0])
    assert fewer.script_positions.shape == (4, 3)


def test_vertex_positions_of_an_obstacle_may_have_one_row_per_time_and_vertex():
    assert obstacle(MOVED) == obstacle(MOVED.reshape(-1, 3))
    changed = obstacle(MOVED).replace(vertex_positions=3.0 * MOVED)
    assert np.array_equal(changed.vertex_positions, 3.0 * MOVED.reshape(-1, 3))


@pytest.mark.parametrize(
    "mistake, sentence",
    [
        (
            lambda: cloth(PINNED.swapaxes(0, 1)),
            "Cloth.script_positions must have shape (times, pins, 3) = (3, 2, 3), or (times * pins,"
            " 3) = (6, 3), got (2, 3, 3)",
        ),
        (
            lambda: cloth(PINNED[:, :, :2]),
            "(times, pins, 3) = (3, 2, 3), or (times * pins, 3) = (6, 3), got (3, 2, 2)",
        ),
        (lambda: cloth(PINNED.ravel()), "= (3, 2, 3), or (times * pins, 3) = (6, 3), got (18,)"),
        (lambda: cloth(PINNED, pins=[0]), "(times, pins, 3) = (3, 1, 3)"),
        (
            lambda: obstacle(MOVED[:2]),
            "Obstacle.vertex_positions must have shape (times, vertices, 3) = (3, 9, 3), or (times"
            " * vertices, 3) = (27, 3), got (2, 9, 3)",
        ),
        (
            lambda: cloth([PINNED[0], PINNED[1][:1]]),
            "Cloth.script_positions must be numbers in rows of equal length, got [array(",
        ),
        (
            lambda: ls.Simulation(ls.Scene(cloths=[cloth(PINNED.reshape(-1, 3)[:4])])),
            "cloths[0].script_positions must have 6 rows (3 script_times x 2 pins), got 4",
        ),
        (
            lambda: ls.Simulation(
                ls.Scene(cloths=[ls.Cloth(mesh=GRID)], obstacles=[obstacle(START)])
            ),
            "obstacles[0].vertex_positions must have 27 rows (3 times x 9 vertices), got 9",
        ),
    ],
)
def test_other_shapes_are_refused_with_the_right_ones(mistake, sentence):
    with pytest.raises(ls.InvalidInput, match=re.escape(sentence)):
        mistake()
