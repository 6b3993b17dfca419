"""Errors of treecode sums over many dipoles are at most twice the requested tolerance. The sums
conserve momentum, and are the same on any number of threads.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M

N = 9000  # enough for the treecode; up to about 7,700 dipoles are summed directly


def shaken_lattice(n=N, seed=1):
    rng = np.random.default_rng(seed)
    side = int(np.ceil(n ** (1 / 3)))
    cells = np.stack(np.unravel_index(np.arange(n), (side, side, side)), axis=1)
    return 0.01 * (cells + 0.5 * rng.random((n, 3))) / side, 1e-3 * rng.normal(size=(n, 3))


def clustered(n=N):
    """Dipoles on a sphere, on a line and in a tight cluster; two have the same position."""
    rng = np.random.default_rng(3)
    ball = rng.normal(size=(n // 2, 3))
    ball *= 0.01 / np.linalg.norm(ball, axis=1)[:, None]
    line = np.stack([np.linspace(0, 0.3, n // 4), np.zeros(n // 4), np.zeros(n // 4)], axis=1)
    bunch = 0.02 + 1e-4 * rng.random((n - n // 2 - n // 4, 3))
    points = np.concatenate([ball, line, bunch])
    points[-1] = points[-2]
    return points, 1e-3 * rng.normal(size=(n, 3))


def aligned(n=N):
    """Equal dipoles near the points of a lattice, like cells of a magnet. The forces that the
    neighbours of an inner dipole exert on it nearly cancel.
    """
    points, _ = shaken_lattice(n)
    return points, np.tile((0.3e-3, 0, 1e-3), (n, 1))


def off(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


# Largest allowed error, as a multiple of the tolerance. The treecode estimates its root mean square
# error from a sample of 128 observers. The estimate is wrong by a few tenths of its value, and by
# more if a few observers have much larger errors than the rest (for example, close to a dipole).
SAMPLED = 2.0


@pytest.mark.parametrize(
    ("dipoles", "tolerance"),
    [
        (shaken_lattice, 1e-2),
        (shaken_lattice, 1e-4),
        (shaken_lattice, 1e-7),
        (clustered, 1e-4),
        (aligned, 1e-4),
    ],
)
def test_field_gradient_forces_and_torques_keep_the_tolerance(dipoles, tolerance):
    points, moments = dipoles()
    forces, torques = M.dipole_forces(points, moments)
    found_forces, found_torques = M.dipole_forces(points, moments, tolerance=tolerance)
    assert (
        off(found_forces, forces) <= SAMPLED * tolerance
        and off(found_torques, torques) <= SAMPLED * tolerance
    )
    assert not np.array_equal(found_forces, forces)  # the treecode is used
    rng = np.random.default_rng(5)
    observers = rng.normal(size=(8000, 3)) * 0.02
    field = M.dipole_field(points, moments, observers)
    assert (
        off(M.dipole_field(points, moments, observers, tolerance=tolerance), field)
        <= SAMPLED * tolerance
    )
    if tolerance == 1e-4 and dipoles is not clustered:
        gradient = M.dipole_gradient(points, moments, observers)
        found = M.dipole_gradient(points, moments, observers, tolerance=tolerance)
        assert off(found, gradient) <= SAMPLED * tolerance
        assert np.array_equal(found, np.swapaxes(found, 1, 2))
        # Fields of multipoles have no divergence, so the trace vanishes at any tolerance.
        assert np.abs(np.trace(found, axis1=1, axis2=2)).max() <= 1e-12 * np.abs(found).max()


def test_forces_of_one_set_of_dipoles_on_another_keep_the_tolerance():
    points, moments = shaken_lattice()
    others, other_moments = clustered()
    others = others + (0.005, 0.003, 0.001)
    exact = M.dipole_forces(points, moments, others, other_moments)
    found = M.dipole_forces(points, moments, others, other_moments, tolerance=1e-5)
    for a, b in zip(found, exact, strict=True):
        assert off(a, b) <= SAMPLED * 1e-5


@pytest.mark.parametrize("tolerance", [3e-2, 1e-4])
def test_momentum_is_kept_to_rounding_whatever_the_tolerance(tolerance):
    points, moments = shaken_lattice()
    forces, torques = M.dipole_forces(points, moments, tolerance=tolerance)
    arms = points - points.mean(axis=0)
    # The tolerance allows for rounding in sums over 9000 dipoles.
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * np.abs(forces).sum()
    assert (
        np.abs((torques + np.cross(arms, forces)).sum(axis=0)).max() < 1e-13 * np.abs(torques).sum()
    )


def test_the_same_bits_on_any_number_of_threads():
    points, moments = clustered()
    one = M.dipole_forces(points, moments, tolerance=1e-4, threads=1)
    gradient = M.dipole_gradient(points, moments, points, tolerance=1e-3, threads=1)
    for threads in (2, 3, 5):
        found = M.dipole_forces(points, moments, tolerance=1e-4, threads=threads)
        assert all(np.array_equal(a, b) for a, b in zip(found, one, strict=True))
        assert np.array_equal(
            M.dipole_gradient(points, moments, points, tolerance=1e-3, threads=threads), gradient
        )


def test_few_dipoles_are_summed_directly_and_lengths_do_not_matter():
    points, moments = shaken_lattice(300)
    for a, b in zip(
        M.dipole_forces(points, moments, tolerance=1e-3),
        M.dipole_forces(points, moments),
        strict=True,
    ):
        assert np.array_equal(a, b)
    points, moments = shaken_lattice()
    found = M.dipole_field(points, moments, points, tolerance=1e-7)
    for scale in (1e-9, 1e9):  # high-order derivatives neither overflow nor underflow
        scaled = M.dipole_field(scale * points, moments, scale * points, tolerance=1e-7)
        assert off(scaled * scale**3, found) < 1e-6


def test_tolerances_out_of_range_are_named():
    points, moments = shaken_lattice(10)
    for tolerance in (0.0, 0.5, float("nan")):
        with pytest.raises(ls.InvalidInput, match=r"tolerance must be in \[1e-10, 0.1\]"):
            M.dipole_field(points, moments, points, tolerance=tolerance)
        with pytest.raises(ls.InvalidInput, match=r"tolerance must be in \[1e-10, 0.1\]"):
            M.dipole_forces(points, moments, tolerance=tolerance)


def test_very_many_dipoles_keep_the_tolerance_on_any_number_of_threads():
    points, moments = aligned(200_000)
    rows = np.random.default_rng(8).choice(len(points), 200, replace=False)
    forces, _ = M.dipole_forces(points[rows], moments[rows], points, moments)
    found = [
        M.dipole_forces(points, moments, tolerance=1e-2, threads=threads) for threads in (1, 2)
    ]
    assert off(found[0][0][rows], forces) <= SAMPLED * 1e-2
    assert all(np.array_equal(a, b) for a, b in zip(*found, strict=True)), (
        "the same bits on any number of threads"
    )
