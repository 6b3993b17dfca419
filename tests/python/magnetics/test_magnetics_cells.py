"""Magnets as hierarchies of dipole cells: figures 6.5 and 6.7 of [Thomaszewski2010], the moment of
every level, fronts (cells that interact, chosen by (6.19)), conservation of momentum, convergence,
refused input, and estimated errors.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M
from magnet_tables import cases

CUBE = dict(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))


def lattice(n):
    """Returns positions [m] and moments [A m^2] of the n^3 cells of the magnet CUBE."""
    line = (np.arange(n) + 0.5) / n * 0.01 - 0.005
    x, y, z = np.meshgrid(line, line, line, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    return points, np.tile((0, 0, 1e-6 / M.MU0 / n**3), (n**3, 1))


@pytest.mark.parametrize(
    ("name", "m1", "m2", "force", "torque1", "torque2"),
    [
        # m2 lies in direction +x from m1. The numbers after the directions of m1 and m2 are the
        # signs of the force on m2 along x and y, and of the torques on m1 and m2 about z.
        ("A1, side by side, parallel: repelled", (0, 1, 0), (0, 1, 0), (1, 0), 0, 0),
        ("A2, side by side, antiparallel: attracted", (0, 1, 0), (0, -1, 0), (-1, 0), 0, 0),
        ("B1, in line, parallel: attracted", (1, 0, 0), (1, 0, 0), (-1, 0), 0, 0),
        ("B2, in line, antiparallel: repelled", (1, 0, 0), (-1, 0, 0), (1, 0), 0, 0),
        (
            "C1, at right angles: sheared, both turned towards B1",
            (1, 0, 0),
            (0, 1, 0),
            (0, 1),
            -1,
            -1,
        ),
        (
            "C2, at right angles, m2 turned round: all signs change",
            (1, 0, 0),
            (0, -1, 0),
            (0, -1),
            1,
            1,
        ),
    ],
)
def test_the_six_arrangements_of_figure_6_5(name, m1, m2, force, torque1, torque2):
    def bar(direction):
        size = np.where(np.array(direction) != 0, 0.03, 0.01)  # long along its moment
        return M.cuboid(size=size, polarization=direction)

    a, b = bar(m1), bar(m2).moved((0.06, 0, 0))
    # With a density of 1e3 cells/m^3, each magnet is a single cell.
    for engine, density in (
        ("cells", 1e3),
        ("cells", 8e6),
        ("exact", None),
    ):
        on_2 = M.force(on=b, by=a, engine=engine, density=density)
        on_1 = M.force(on=a, by=b, engine=engine, density=density)
        small = 1e-9 * np.linalg.norm(on_2.force)
        assert [np.sign(round(x / small) * small) for x in on_2.force[:2]] == list(force), (
            name,
            engine,
        )
        assert abs(on_2.force[2]) < small
        for found, sign in ((on_1.torque, torque1), (on_2.torque, torque2)):
            assert np.sign(round(found[2] / (0.01 * small))) == sign, (name, engine)
            assert np.abs(found[:2]).max() < 0.01 * small
        # Magnets of a single cell exert the forces (6.10) and torques (6.11) of dipoles.
        if density == 1e3:
            forces, torques = M.dipole_forces([a.position, b.position], [a.moment, b.moment])
            assert np.allclose(
                on_2.force, forces[1], rtol=0, atol=1e-12 * np.linalg.norm(forces[1])
            )
            assert np.allclose([on_1.torque, on_2.torque], torques, rtol=0, atol=1e-12)


def test_every_level_carries_the_whole_moment_and_leaves_keep_their_margin():
    magnets = {
        "cuboid": M.cuboid(size=(0.02, 0.011, 0.013), polarization=(0.2, 0.5, 1)),
        "cylinder": M.cylinder(radius=0.01, height=0.02, polarization=(0.2, 0.5, 1)),
        "ring": M.cylinder(
            radius=0.01, height=0.02, inner_radius=0.005, polarization=(0.2, 0.5, 1)
        ),
        "sphere": M.sphere(radius=0.01, polarization=(0.2, 0.5, 1)),
        "mesh": M.mesh(ls.meshes.sphere(radius=0.01, subdivisions=3), polarization=(0.2, 0.5, 1)),
    }
    for name, magnet in magnets.items():
        body = M.cells(magnet.at((0.1, 0.2, 0.3), (0.5, 0.5, -0.5, 0.5)), density=5e7)
        for level in range(12):
            _, moments = M.cell_level(body, level)
            assert np.allclose(
                moments.sum(axis=0), body.moment, rtol=0, atol=1e-13 * np.linalg.norm(body.moment)
            ), (
                name,
                level,
            )
        leaves, _ = M.cell_level(M.cells(magnet, density=5e7), 99)
        assert len(leaves) > 50
        rho = np.linalg.norm(leaves[:, :2], axis=1)
        if name in ("sphere", "mesh"):
            depth = 0.01 - np.linalg.norm(leaves, axis=1)
        elif name == "cuboid":
            depth = (np.array((0.02, 0.011, 0.013)) / 2 - np.abs(leaves)).min(axis=1)
        else:
            depth = np.minimum(0.01 - rho, 0.01 - np.abs(leaves[:, 2]))
            depth = np.minimum(depth, rho - 0.005) if name == "ring" else depth
        # The centre of a leaf of volume v lies at least v^(1/3) / 2 below the surface. The last
        # subdivision is a bisection, so there are up to 1e8 leaves/m^3, twice the given density.
        slack = 1e-12 if name != "mesh" else 2e-4  # the mesh approximates the sphere
        assert depth.min() >= 0.5 * (1 / 1e8) ** (1 / 3) - slack, name


def test_cells_of_a_cube_are_the_lattice():
    for n in (2, 4, 8):
        body = M.cells(M.cuboid(**CUBE), density=n**3 * 1e6)
        found, moments = M.cell_level(body, 99)
        points, expected = lattice(n)
        order = np.lexsort(np.round(found / 1e-6).T)
        assert np.allclose(
            found[order], points[np.lexsort(np.round(points / 1e-6).T)], rtol=0, atol=1e-15
        )
        assert np.allclose(moments, expected, rtol=1e-12, atol=0)


def test_figure_6_7_cells_converge_to_the_exact_force_from_a_distance():
    table = cases("i_cuboid_parallel_force")
    exact = {
        round(1e3 * c["gap"], 6): c["F2"][2]
        for c in table
        if c["dim1"] == c["dim2"] and c["kind"] == "axial"
    }
    contact = table[0]["F2"][2]
    for gap in (5.0, 10.0, 20.0):
        errors = []
        for n in (1, 2, 4, 8):
            a = M.cells(M.cuboid(**CUBE), density=n**3 * 1e6, separation=1e6)  # uses all leaves
            found = M.force(on=a.moved((0, 0, 0.01 + 1e-3 * gap)), by=a)
            errors.append(abs(found.force[2] / exact[gap] - 1))
            points, moments = lattice(n)
            forces, _ = M.dipole_forces(
                points + (0, 0, 0.01 + 1e-3 * gap), moments, points, moments
            )
            # The force between the leaves agrees with the sum over two lattices of dipoles.
            assert found.force[2] == pytest.approx(forces[:, 2].sum(), rel=1e-11)
        assert errors[3] < errors[2] < errors[1] and errors[3] < 5e-3, (gap, errors)
    # If the magnets touch, the force of the cells does not converge to the exact one. It is 36 %
    # too large with 4 cells along each edge, and 39 % with 8.
    for n in (4, 8):
        points, moments = lattice(n)
        forces, _ = M.dipole_forces(points + (0, 0, 0.01), moments, points, moments)
        assert 1.3 < forces[:, 2].sum() / contact < 1.5


def test_fronts_refine_towards_the_other_body_and_save_cells():
    long = M.cells(
        M.cuboid(size=(0.1, 0.01, 0.01), polarization=(0, 0, 1)), density=8e6, separation=3
    )
    other = M.cells(M.cuboid(**CUBE), density=8e6, separation=3).moved((0.045, 0, 0.0125))
    front, moments = M.cell_front(long, other)
    leaves, _ = M.cell_level(long, 99)
    assert len(front) < 0.7 * len(leaves)
    assert np.allclose(moments.sum(axis=0), long.moment)
    sizes = moments[:, 2]
    near = front[:, 0] > 0.03
    assert sizes[near].max() == pytest.approx(sizes.min()) and sizes[~near].max() > 3 * sizes.min()
    far, _ = M.cell_front(long, other.moved((1.0, 0, 0)))
    assert len(far) == 1
    # Using fronts changes the force by less than 1 % compared with using all leaves.
    every = [
        M.cells(M.cuboid(size=size, polarization=(0, 0, 1)), density=8e6, separation=1e6)
        for size in ((0.1, 0.01, 0.01), (0.01, 0.01, 0.01))
    ]
    whole = M.force(on=every[1].moved(other.position), by=every[0])
    assert np.linalg.norm(M.force(on=other, by=long).force - whole.force) < 0.01 * np.linalg.norm(
        whole.force
    )


def test_cells_keep_momentum_near_far_and_overlapping():
    rng = np.random.default_rng(2)
    a = M.cells(M.cylinder(radius=0.01, height=0.02, polarization=(0.2, 0.5, 1)), density=2e7)
    for offset in ((0.03, 0.01, 0.02), (0.3, 0.1, 0), (0.004, 0.003, 0.005), (0, 0, 0)):
        b = M.cells(M.cuboid(size=(0.01, 0.02, 0.01), polarization=(1, 0.5, 0)), density=2e7).at(
            offset, rng.normal(size=4)
        )
        on_b, on_a = M.force(on=b, by=a), M.force(on=a, by=b)
        assert np.isfinite(on_b.force).all() and np.linalg.norm(on_b.force) < 1e4
        assert np.array_equal(on_b.force, -on_a.force)
        # Opposite forces prove little, because one may be computed as the negative of the other.
        # Therefore, if the bodies do not overlap, force and torque on `a` are compared with a
        # direct sum over both fronts.
        (xa, ma), (xb, mb) = M.cell_front(a, b), M.cell_front(b, a)
        if np.linalg.norm(offset) > 0.02:
            fa, ta = M.dipole_forces(xa, ma, xb, mb)
            turn = (ta + np.cross(xa - a.position, fa)).sum(axis=0)
            assert np.allclose(turn, on_a.torque, rtol=0, atol=1e-12 * np.linalg.norm(on_a.force))
            assert np.allclose(
                fa.sum(axis=0), on_a.force, rtol=0, atol=1e-12 * np.linalg.norm(on_a.force)
            )


def test_cells_of_a_cylinder_converge_to_the_magnet():
    a = M.cuboid(**CUBE)
    b = M.cylinder(radius=0.005, height=0.01, polarization=(0, 0.3, 1)).at(
        (0.012, 0.008, 0.02), (0.9, 0.2, 0.1, 0.3)
    )
    exact = M.force(on=b, by=a, tolerance=1e-6)
    errors = []
    for density in (6.4e7, 5.12e8, 4.1e9):
        found = M.force(on=b, by=a, engine="cells", density=density)
        errors.append(np.linalg.norm(found.force - exact.force) / np.linalg.norm(exact.force))
    # Convergence is only of first order, because no cell centre lies within half a cell of the
    # surface. The mean distance of the centres from the axis is therefore too small.
    assert errors[2] < errors[1] < errors[0] and errors[2] < 0.01
    assert np.linalg.norm(found.torque - exact.torque) < 0.02 * np.linalg.norm(exact.torque)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: M.cells(M.loop(radius=1, current=1), density=1),
            "must be a solid magnet to be divided into cells",
        ),
        (lambda: M.cells(M.cuboid(**CUBE), density=0), r"density must be > 0 \[1/m\^3\]"),
        (
            lambda: M.cells(M.cuboid(**CUBE), density=1e30),
            "density must give at most 4000000 cells",
        ),
        (
            lambda: M.cells(M.cuboid(**CUBE), density=8e6, separation=0.5),
            r"separation must be >= 1 \[1\]",
        ),
        (lambda: M.cell_level(M.cuboid(**CUBE), 0), "body must have cells"),
        (
            lambda: M.cell_front(M.cells(M.cuboid(**CUBE), density=8e6), M.cuboid(**CUBE)),
            "body must have cells",
        ),
        (
            lambda: M.force(on=M.cuboid(**CUBE), by=M.cuboid(**CUBE), engine="cells"),
            "density .* must be given",
        ),
        (
            lambda: M.force(on=M.cuboid(**CUBE), by=M.cuboid(**CUBE), density=1),
            'density must be None with engine="exact", got',
        ),
        (
            lambda: M.force(on=M.cuboid(**CUBE), by=M.cuboid(**CUBE), engine="magic"),
            'engine must be "exact" or "cells"',
        ),
    ],
)
def test_mistakes_with_cells_are_named(call, message):
    with pytest.raises(ls.InvalidInput, match=message):
        call()


def test_the_estimated_error_of_cells_is_of_the_size_of_the_true_one():
    rng = np.random.default_rng(1)
    ratios = []
    for trial in range(60):
        sizes = rng.uniform(0.004, 0.012, (2, 3))
        lower = M.cuboid(size=tuple(sizes[0]), polarization=(0, 0, 1))
        upper = M.cuboid(size=tuple(sizes[1]), polarization=tuple(rng.normal(size=3)))
        height = 0.5 * (sizes[0, 2] + sizes[1, 2])
        if trial % 2:
            upper = upper.rotated(tuple(rng.normal(size=3)))
            height = 0.5 * (sizes[0, 2] + np.linalg.norm(sizes[1]))
        upper = upper.moved((0, 0, height + rng.uniform(0.1, 2) * sizes[:, 2].min()))
        density = rng.choice([100, 500, 2000]) / np.prod(sizes[0])
        found = M.force(on=upper, by=lower, engine="cells", density=density)
        exact = M.force(on=upper, by=lower, tolerance=1e-8)
        true = max(
            np.linalg.norm(found.force - exact.force),
            np.linalg.norm(found.torque - exact.torque) / upper.radius,
        )
        ratios.append(found.error / true)
    # In at least nine of ten cases, the estimate is between half and ten times the true error.
    assert np.mean((np.array(ratios) > 0.5) & (np.array(ratios) < 10.0)) >= 0.9
