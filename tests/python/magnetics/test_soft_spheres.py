"""Moments of and forces on soft spheres, estimated errors of forces between magnets and iron, and
error messages that name the faulty argument.
"""

import loomstone as ls
import numpy as np
import pytest

m = ls.magnetics
MAGNET = m.cylinder(radius=0.006, height=0.01, polarization=(0, 0, 1.2))
RADIUS = 0.004


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 8])
@pytest.mark.parametrize("z", [0.0113, 0.025])
def test_the_moment_of_a_single_sphere_does_not_depend_on_the_degree(degree, z):
    # The magnet's field is harmonic, so its mean over the sphere is its value at the centre. The
    # moment therefore follows from the field at the centre alone.
    sphere = m.soft_sphere(radius=RADIUS, susceptibility=1000, degree=degree).moved((0, 0, z))
    moment = m.induce(sphere, by=MAGNET).bodies[0].moment[2]
    share = 4 * np.pi * RADIUS**3 / m.MU0 * 1000 / 1003
    assert moment == pytest.approx(share * m.field(MAGNET, [[0, 0, z]])[0, 2], rel=3e-4)


def force_in_scene(*more, **of_sphere):
    """Vertical force [N] on a soft sphere in a scene, with its centre 11.3 mm above the magnet's.

    more : further magnets of the scene
    of_sphere : arguments of soft_sphere()
    """
    ball = ls.meshes.sphere(radius=RADIUS, subdivisions=1)
    base = ls.obstacles.mesh(ls.meshes.box(size=(1e-3,) * 3), name="base", centre=(0, 0, -0.1))
    sphere = m.soft_sphere(radius=RADIUS, susceptibility=1000, **of_sphere)
    scene = ls.Scene(
        bodies=[ls.RigidBody(name="ball", mesh=ball, shape="sphere", position=(0, 0, 0.0113))],
        obstacles=[base],
        gravity=(0, 0, 0),
        magnets=[
            ls.Magnet(body="base", source=MAGNET),
            ls.Magnet(body="ball", source=sphere),
            *more,
        ],
    )
    return ls.Simulation(scene, threads=1).magnetic_forces()[0][0, 2]


def test_a_sphere_in_a_scene_feels_the_same_force_with_iron_far_away_or_a_saturation():
    alone = force_in_scene()
    cube = m.soft_cuboid(size=(0.01,) * 3, susceptibility=1000, cells=8).moved((10, 0, 0))
    assert force_in_scene(ls.Magnet(body="base", source=cube)) == pytest.approx(alone, rel=1e-3)
    assert force_in_scene(saturation=1e6) == pytest.approx(alone, rel=1e-3)


def test_the_error_of_a_force_between_a_dipole_and_iron_is_finite_and_that_of_its_reaction():
    dipole = m.dipoles([[0, 0, 0]], [[0, 0, 1.0]]).moved((1e-3, 0, 0.02))
    for soft in (
        m.soft_sphere(radius=0.01, susceptibility=1000),
        m.soft_cuboid(size=(0.016,) * 3, susceptibility=1000, cells=8),
    ):
        iron = m.induce(soft, by=dipole).bodies[0]
        on, back = m.force(on=dipole, by=iron).error, m.force(on=iron, by=dipole).error
        assert 0 < on < 1e-2 and on == back
        assert np.array_equal(m.forces([dipole, iron]).errors, [on, on])


def exact_force(radius, distance, moment, susceptibility):
    """Attraction [N] of a sphere and a dipole that points to its centre, by solid harmonics."""
    degree = np.arange(1, 100_000)
    response = degree * susceptibility / (degree * (susceptibility + 2) + 1)
    powers = np.exp((2 * degree + 1) * np.log(radius) - (2 * degree + 5) * np.log(distance))
    terms = response * (degree + 1.0) ** 2 * (2 * degree + 4) * powers
    return m.MU0 * moment**2 / (8 * np.pi) * terms.sum()


@pytest.mark.parametrize("ratio", [0.5, 0.1, 0.02, 0.01, 0.005])
@pytest.mark.parametrize("gap", [0.05, 1.0])
def test_the_error_of_the_force_between_a_large_sphere_and_a_small_magnet_covers_the_truth(
    ratio, gap
):
    small = ratio * RADIUS
    distance = RADIUS + (1 + gap) * small
    magnet = m.sphere(radius=small, polarization=(0, 0, 1.2)).moved((0, 0, distance))
    iron = m.soft_sphere(radius=RADIUS, susceptibility=1000.0)
    found = m.force(on=magnet, by=m.induce(iron, by=magnet).bodies[0])
    moment = 1.2 / m.MU0 * 4 / 3 * np.pi * small**3
    exact = exact_force(RADIUS, distance, moment, 1000.0)
    wrong = abs(-found.force[2] - exact)
    assert 0.5 * wrong < found.error < 5 * wrong
    # For ratios of 0.1 and more, the solid harmonics of the soft sphere have the degree that the
    # tolerance requires. For smaller ratios, the highest degree allowed may be too low.
    assert ratio < 0.05 or wrong < 1e-5 * exact


def test_bad_arguments_of_figures_and_cells_are_named(tmp_path):
    cube = m.cuboid(size=(0.01,) * 3, polarization=(0, 0, 1))
    plain = m.cuboid(size=(0.01,) * 3, polarization=(0, 0, 0))
    path = tmp_path / "picture.png"
    for call, said in [
        (lambda: m.plot_slice([plain], path), "their field is 0 in the whole slice"),
        (lambda: m.plot_slice([cube], path, centre=(0, 0)), "centre must be three finite"),
        (lambda: m.plot_slice([cube], path, extent=-0.1), "extent must be > 0"),
        (lambda: m.plot_curve(m.force_over_distance(cube, cube, []), path), "at least one place"),
        (lambda: m.cell_level(m.cells(cube, density=8e6), -1), "level must be at least 0"),
    ]:
        with pytest.raises(ls.InvalidInput, match=said):
            call()
    assert not path.exists()
    assert m.forces(cube).forces.shape == (1, 3)
