"""Energies of magnets agree with forces and torques, and potentials agree with fields."""

import loomstone as ls
import numpy as np
import pytest
from magnet_sources import MAGNETS


@pytest.mark.parametrize("name", MAGNETS)
def test_forces_and_torques_are_minus_the_derivatives_of_the_energy(name):
    fixed, body = (
        MAGNETS["cuboid"],
        MAGNETS[name].moved((0.004, 0.003, 0.016)).rotated((0.3, -0.2, 0.5)),
    )

    def energy(moved):
        return ls.magnetics.energy([fixed, moved], tolerance=1e-9)

    exact = ls.magnetics.force(on=body, by=fixed, tolerance=1e-9)
    step = 1e-4  # error of central differences: (step / distance)^2 = 1e-4 of the derivative
    for axis in np.eye(3):
        slope = -(energy(body.moved(step * axis)) - energy(body.moved(-step * axis))) / (2 * step)
        assert slope == pytest.approx(exact.force @ axis, abs=3e-4 * np.linalg.norm(exact.force))
        turn = 0.01
        slope = -(energy(body.rotated(turn * axis)) - energy(body.rotated(-turn * axis))) / (
            2 * turn
        )
        assert slope == pytest.approx(exact.torque @ axis, abs=3e-4 * np.linalg.norm(exact.torque))


@pytest.mark.parametrize("name", MAGNETS)
def test_the_field_strength_is_the_descent_of_the_potential(name):
    magnet = MAGNETS[name].moved((0.002, -0.001, 0.003)).rotated((0.3, -0.2, 0.5))
    random = np.random.default_rng(8)
    # One special point is next to the centre of the magnet, and the other is 5 cm above the centre.
    special = magnet.position + np.array([[1e-9, 0, 0], [0, 0, 0.05]])
    points = np.vstack(
        (random.uniform(-0.015, 0.015, (200, 3)), random.uniform(-0.1, 0.1, (50, 3)), special)
    )
    # The relative error of central differences due to rounding is 1e-16 size / step = 1e-11, for a
    # size of 1 cm. Their truncation error is proportional to step^2 and larger near edges.
    step = 1e-7
    ends = [
        [ls.magnetics.potential(magnet, points + sign * step * axis) for sign in (-1, 1)]
        for axis in np.eye(3)
    ]
    slopes = np.array([low - high for low, high in ends]).T / (2 * step)
    wanted = ls.magnetics.field(magnet, points, quantity="H")
    error = np.linalg.norm(slopes - wanted, axis=1) / np.linalg.norm(wanted, axis=1)
    assert np.median(error) < 1e-8 and error.max() < 1e-4


def test_currents_have_no_potential():
    with pytest.raises(ls.Unsupported, match="scalar potential"):
        ls.magnetics.potential(ls.magnetics.loop(radius=0.1, current=1.0), [[0, 0, 0]])


def test_the_energy_of_spheres_is_that_of_their_dipoles():
    random = np.random.default_rng(3)
    places, moments = random.uniform(-0.1, 0.1, (4, 3)), random.normal(size=(4, 3))
    bodies = [
        ls.magnetics.dipoles([[0, 0, 0]], [m]).moved(x)
        for x, m in zip(places, moments, strict=True)
    ]
    assert ls.magnetics.energy(bodies) == pytest.approx(
        ls.magnetics.dipole_energy(places, moments), rel=1e-13
    )


@pytest.mark.parametrize("other", ["loop", "larger magnet", "smaller magnet", "dipole"])
def test_the_energy_of_currents_is_refused(other):
    bodies = {
        "loop": ls.magnetics.loop(radius=0.1, current=1.0),
        "larger magnet": ls.magnetics.cuboid(size=(0.4, 0.4, 0.4), polarization=(0, 0, 1)),
        "smaller magnet": ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1)),
        "dipole": ls.magnetics.dipoles([[0, 0, 0]], [(0, 0, 1)]),
    }
    loop = ls.magnetics.loop(radius=0.1, current=1.0)
    for pair in ([loop, bodies[other].moved((0, 0, 1))], [bodies[other].moved((0, 0, 1)), loop]):
        with pytest.raises(ls.Unsupported, match="got a current"):
            ls.magnetics.energy(pair)
