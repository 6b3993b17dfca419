"""Laws of magnetisable bodies: levitation, image magnets, stability, energy, momentum, saturation,
and the explicit response.
"""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M
from magnet_bodies import quaternion
from magnet_tables import cases
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

BOX = M.soft_cuboid(size=(0.01, 0.008, 0.006), susceptibility=1000.0, cells=8)
MAGNET = M.cuboid(size=(0.01, 0.01, 0.005), polarization=(0.2, 0, 1.2))


def away(found, wanted):
    return np.linalg.norm(np.subtract(found, wanted)) / np.linalg.norm(wanted)


def lift(soft, magnet, height):
    """Magnetises `soft` by a magnet at (0, 0, height) [m]. Returns the force and torque that `soft`
    then exerts on the magnet.
    """
    there = magnet.at((0, 0, height), magnet.orientation)
    (induced,) = M.induce(soft, by=there, tolerance=1e-10).bodies
    return M.force(on=there, by=induced)


def ball_magnet(case, axis):
    polarization = case["magnet_J"] * np.array(axis)
    weight = case["magnet_density"] * 4 / 3 * np.pi * case["magnet_radius"] ** 3 * case["gravity"]
    return M.sphere(radius=case["magnet_radius"], polarization=polarization), weight


def test_a_magnet_floats_above_a_superconducting_ball_as_its_table_says():
    for case in cases("v_levitation_above_sphere"):
        magnet, weight = ball_magnet(case, np.eye(3)["xyz".index(case["moment_axis"])])
        ball = M.soft_sphere(radius=case["sphere_radius"], susceptibility=case["chi"])
        place, step = case["equilibrium_centre_distance"], 1e-4 * case["gap"]
        assert lift(ball, magnet, place).force[2] == pytest.approx(weight, rel=1e-8)
        slope = (
            lift(ball, magnet, place + step).force[2] - lift(ball, magnet, place - step).force[2]
        ) / (2 * step)
        # The relative error of the difference quotient is of second order in the step, about 1e-8.
        assert -slope == pytest.approx(case["vertical_stiffness"], rel=1e-6)


def test_diamagnetic_balls_are_pushed_from_a_magnet_as_their_table_says():
    for case in cases("v_diamagnetic_sphere_force"):
        magnet = M.sphere(radius=case["magnet_radius"], polarization=(0, 0, case["magnet_J"]))
        ball = M.soft_sphere(radius=case["sphere_radius"], susceptibility=case["chi"])
        (induced,) = M.induce(
            ball.moved((0, 0, case["centre_distance"])), by=magnet, tolerance=1e-10
        ).bodies
        force = M.force(on=induced, by=magnet).force
        assert force == pytest.approx(
            (0, 0, case["axial_force_on_sphere"]), rel=1e-8, abs=1e-9 * case["weight"]
        )


def test_a_wide_superconducting_plate_acts_as_the_plane_of_the_table():
    """Uses plates of width 6 h and thickness h, where h is the height of the magnet's centre above
    them. The tolerances cover the effect of the plates' finite width.
    """
    height = 0.015
    plates = [
        M.soft_cuboid(
            size=(6 * height, 6 * height, height), susceptibility=-1, cells=n, focus=f
        ).moved((0, 0, -height / 2))
        for n, f in ((16, 0.0), (24, height))
    ]
    for case in cases("v_levitation_above_plane"):
        angle = np.radians(case["angle_from_vertical_deg"])
        magnet, weight = ball_magnet(case, (np.sin(angle), 0, np.cos(angle)))
        at_rest = case["equilibrium_height_of_centre"]
        force, torque = (
            case["force_times_h4"] / height**4,
            case["torque_at_equilibrium"] * (at_rest / height) ** 3,
        )
        assert force * (height / at_rest) ** 4 == pytest.approx(weight, rel=1e-9)
        errors = []
        for plate in plates:
            felt = lift(plate, magnet, height)
            errors.append(abs(felt.force[2] / force - 1))
        assert max(errors) < 0.0095, case["id"]
        assert abs(felt.torque[1]) == pytest.approx(torque, abs=0.02 * force * height)


def test_the_pull_on_an_iron_plate_is_that_of_an_image_and_of_a_catalogue():
    """Compares flux densities and pulls of the catalogue in scenes/pull.py with those computed for
    blocks with a polarization of 1.24 T. The pulls deviate more than the flux densities. Also
    compares the computed pull on the scene's plate with that of an image magnet.
    """
    spec = spec_from_file_location("pull", Path(__file__).parents[3] / "scenes" / "pull.py")
    assert spec is not None and spec.loader is not None
    pull = module_from_spec(spec)
    spec.loader.exec_module(pull)
    for edges, (density, force) in pull.CATALOGUE.items():
        size = tuple(1e-3 * edge for edge in edges)
        assert M.field(pull.block(size), [[0, 0, 0.5 * size[2]]])[0, 2] == pytest.approx(
            density, rel=2e-3
        )
        assert pull.image_pull(0.0, size) == pytest.approx(force, rel=0.22)
    assert pull.image_pull(0.0, size) == pytest.approx(force, rel=5e-3), "that of the largest"
    gaps = np.array((0.0, 1e-5, 1e-4, 5e-4, 1e-3, 2e-3, 4e-3))
    images = np.array([pull.image_pull(gap) for gap in gaps])
    # The image assumes an infinite plate. The plate of the scene is at least five times as wide as
    # the magnet.
    assert pull.plate_pull(gaps, susceptibility=1e5) == pytest.approx(images, rel=2e-3)
    # Without `focus`, the panels opposite the edges of the magnet's pole are few and large, so the
    # tolerance is larger.
    plate = M.soft_cuboid(size=pull.PLATE, susceptibility=1e5, cells=8)
    for gap, image in zip(gaps, images, strict=True):
        turned = (
            pull.block()
            .rotated((0, 0, 0.5))
            .moved((0.0013, 0.0007, -0.5 * (pull.PLATE[2] + pull.MAGNET[2]) - gap))
        )
        (induced,) = M.induce(plate, by=turned).bodies
        assert -M.force(on=induced, by=turned).force[2] == pytest.approx(image, rel=1.5e-2)


def test_a_soft_body_cut_in_two_is_attracted_like_the_whole():
    """Two touching halves act like the whole body. The charges on the two faces of the cut cancel
    as far as the panels resolve them.
    """
    magnet = M.cuboid(size=(0.01, 0.01, 0.01), polarization=(0.3, 0, 1)).moved(
        (0.004, 0.002, 0.014)
    )
    whole, half = (
        M.soft_cuboid(size=(length, 0.01, 0.01), susceptibility=1, cells=8)
        for length in (0.02, 0.01)
    )
    for chi in (-1.0, -0.5, 10.0, 1000.0, np.inf):
        half = half.with_susceptibility(chi)
        cut = M.induce(
            [half.at((-0.005, 0, 0)), half.at((0.005, 0, 0))], by=magnet, tolerance=1e-5
        ).bodies
        (uncut,) = M.induce(whole.with_susceptibility(chi), by=magnet).bodies
        wanted = M.force(on=uncut, by=magnet).force
        assert away(sum(M.force(on=body, by=magnet).force for body in cut), wanted) < 1e-2, chi


def stiffness_sum(bodies_at, place, step=1e-5):
    """Divergence [N/m] of the force bodies_at(position) with respect to position, at `place`."""
    total = 0.0
    for axis in np.eye(3):
        total += (
            (bodies_at(place + step * axis) - bodies_at(place - step * axis)) @ axis / (2 * step)
        )
    return total


def test_hard_magnets_have_no_stable_place_and_superconductors_do():
    """Earnshaw's theorem: div F = 0 between hard magnets, so no position is stable in all
    directions. Above a superconductor, div F < 0.
    """
    ball = M.sphere(radius=0.003, polarization=(1.2, 0, 0))
    place = np.array((0.001, 0.0005, 0.012))

    def by_hard(x):
        return M.force(on=ball.at(x), by=MAGNET, tolerance=1e-10).force

    plate = M.soft_cuboid(size=(0.05, 0.05, 0.01), susceptibility=-1, cells=8).moved((0, 0, -0.005))

    def by_superconductor(x):
        there = ball.at(x)
        return M.force(on=there, by=M.induce(plate, by=there).bodies[0]).force

    size = np.linalg.norm(by_hard(place)) / 0.01
    # The tolerance of forces between hard magnets is 1e-10. The error of difference quotients is of
    # second order in `step`.
    assert abs(stiffness_sum(by_hard, place)) < 1e-5 * size
    assert (
        stiffness_sum(by_superconductor, place)
        < -0.1 * np.linalg.norm(by_superconductor(place)) / 0.01
    )


def test_forces_follow_from_the_energy():
    ball = M.soft_sphere(radius=0.005, susceptibility=50.0)

    def energy(x):  # half of the interaction energy: magnetising the ball takes the other half
        there = ball.at((x, 0.002, 0.012))
        return 0.5 * M.energy(
            [MAGNET, *M.induce(there, by=MAGNET, tolerance=1e-9).bodies], tolerance=1e-9
        )

    (induced,) = M.induce(ball.at((0.003, 0.002, 0.012)), by=MAGNET, tolerance=1e-9).bodies
    slope = (energy(0.003 + 1e-5) - energy(0.003 - 1e-5)) / 2e-5
    assert M.force(on=induced, by=MAGNET).force[0] == pytest.approx(-slope, rel=1e-4)


@pytest.mark.parametrize("gap", [2e-3, 2e-4, 0.0])
def test_the_energy_of_what_magnetises_is_that_of_the_magnets_dipoles(gap):
    """Compares the energy of box and magnet with that of box and dipoles in the magnet's volume."""
    size, polarization = np.array((0.008, 0.006, 0.005)), np.array((0.2, 0, 1.2))
    magnet = M.cuboid(size=size, polarization=polarization).moved((0.001, 0.0005, 0.0055 + gap))
    (induced,) = M.induce(BOX, by=magnet).bodies
    x, w = np.polynomial.legendre.leggauss(16)
    nodes = 0.5 * size * np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
    moments = (
        np.einsum("i,j,k->ijk", w, w, w).reshape(-1, 1) * size.prod() / 8 * polarization / M.MU0
    )
    # The tolerance allows for errors of two quadratures near contact: over the panels of the box,
    # and over the volume of the magnet.
    wanted = M.energy([M.dipoles(nodes, moments).moved(magnet.position), induced])
    assert M.energy([magnet, induced]) == pytest.approx(
        wanted, rel={2e-3: 1e-4, 2e-4: 3e-3, 0.0: 1e-2}[gap]
    )


def several(turn=None):
    bodies = [BOX, M.soft_sphere(radius=0.004, susceptibility=-1.0).moved((0, 0.012, 0.002))]
    bodies += [
        M.soft_mesh(
            ls.meshes.sphere(radius=0.003, subdivisions=2), susceptibility=10.0, panels=0
        ).moved((0.012, 0, 0))
    ]
    bodies += [M.soft_sphere(radius=0.003, susceptibility=1e5).moved((0.012, 0.008, 0))]
    magnet = MAGNET.moved((0, 0, -0.01))
    if turn is None:
        return bodies, magnet
    return [b.at(turn.apply(b.position), quaternion(turn)) for b in bodies], magnet.at(
        turn.apply(magnet.position), quaternion(turn)
    )


def test_bodies_of_all_kinds_keep_momentum_whatever_frame_and_threads():
    soft, magnet = several()
    induced = M.induce(soft, by=magnet, field=(0.01, 0, 0.02), tolerance=1e-9, threads=1)
    assert induced.residual <= 1e-9
    everything = [*induced.bodies, magnet]
    found = M.forces(everything)
    size = np.linalg.norm(found.forces, axis=1).max()
    assert np.linalg.norm(found.forces.sum(axis=0)) < 1e-13 * size
    arms = np.cross([b.position for b in everything], found.forces)
    assert np.linalg.norm((found.torques + arms).sum(axis=0)) < 1e-13 * size * 0.02
    other = M.induce(soft, by=magnet, field=(0.01, 0, 0.02), tolerance=1e-9, threads=3)
    assert np.array_equal([b.moment for b in induced.bodies], [b.moment for b in other.bodies])
    turn = Rotation.from_rotvec((0.3, -1.1, 0.7))
    soft, magnet = several(turn)
    turned = M.induce(soft, by=magnet, field=turn.apply((0.01, 0, 0.02)), tolerance=1e-9)
    for a, b in zip(turned.bodies, induced.bodies, strict=True):
        # The tolerance covers the approximate far field of panels, which the rotation changes.
        assert away(a.moment, turn.apply(b.moment)) < 1e-6


def test_a_ball_of_panels_near_a_box_answers_as_the_exact_ball():
    exact = M.soft_sphere(radius=0.004, susceptibility=100.0)
    panels = M.soft_mesh(
        ls.meshes.sphere(radius=0.004, subdivisions=3), susceptibility=100.0, panels=0
    )
    found = [
        M.induce([BOX, ball.moved((0, 0, 0.009))], field=(0, 0, 0.1)).bodies
        for ball in (exact, panels)
    ]
    forces = [M.force(on=ball, by=box).force for box, ball in found]
    assert away(forces[1], forces[0]) < 0.02  # 1280 triangles lack 0.9 % of the ball's volume


@pytest.mark.parametrize("susceptibility", [-1.0, -0.5, -1e-5, 1e-5, 1.0, 1e5, np.inf])
def test_every_susceptibility_converges_and_leaves_no_net_charge(susceptibility):
    box = BOX.with_susceptibility(susceptibility)
    pair = [box, box.moved((0, 0, 0.0065))]
    induced = M.induce(pair, field=(0, 0.02, 0.1), tolerance=1e-8)
    assert induced.residual <= 1e-8 and induced.iterations <= 50
    point = np.array([[0.3, 1.0, 0.5]])
    moments = [b.moment for b in induced.bodies]
    dipole = M.field(M.dipoles([b.position for b in induced.bodies], moments), point)
    # Terms beyond the dipoles are (size / distance)^2 = 1e-4 of the field. A net charge of 1e-5 of
    # the charge on a face would be detected.
    assert away(M.field(induced.bodies, point), dipole) < 1e-3


def test_a_ball_saturates_as_its_law_says():
    saturation, chi, volume = 2.0, 500.0, 4e-6 / 3 * np.pi
    ball = M.soft_sphere(radius=0.01, susceptibility=chi, saturation=saturation)
    for field in (1e-3, 0.3, 0.66, 0.7, 3.0, 100.0):

        def excess(j, field=field):  # J - chi H / (1 + chi H / J_s) with H = B - J / 3, all in T
            return j - chi * (field - j / 3) / (1 + chi * (field - j / 3) / saturation)

        wanted = brentq(excess, 0.0, min(3 * field, saturation), xtol=1e-15)
        (induced,) = M.induce(ball, field=(0, field, 0), tolerance=1e-10).bodies
        assert M.MU0 * induced.moment[1] / volume == pytest.approx(wanted, rel=1e-8)


@pytest.mark.parametrize("chi", [1e9, 1e12, 1e15, np.inf])
def test_ideal_iron_saturates(chi):
    saturation, volume = 2.0, 4e-6 / 3 * np.pi
    ball = M.soft_sphere(radius=0.01, susceptibility=chi, saturation=saturation)
    box = M.soft_cuboid(size=(0.01,) * 3, susceptibility=chi, saturation=saturation, cells=8)
    for field in (0.01, 0.6, 0.66, 0.7, 1.0, 3.0, 100.0):
        (induced,) = M.induce(ball, field=(0, field, 0)).bodies
        wanted = min(3 * field, saturation)
        assert M.MU0 * induced.moment[1] / volume == pytest.approx(wanted, rel=1e-4)
        (induced,) = M.induce(box, field=(0, field, 0)).bodies
        # Before it saturates, a cube of very high susceptibility has a demagnetisation factor below
        # 1/3, so its mean polarization exceeds 3 times the field.
        mean = M.MU0 * induced.moment[1] / box.volume
        assert min(3 * field, saturation * (1 - 1e-6)) < mean <= saturation * (1 + 1e-6)


def test_saturating_bodies_do_not_exceed_their_saturation_and_begin_linear():
    box = M.soft_cuboid(size=(0.01, 0.01, 0.02), susceptibility=1e4, saturation=1.5, cells=8)
    linear = M.soft_cuboid(size=(0.01, 0.01, 0.02), susceptibility=1e4, cells=8)
    pair = [box, box.moved((0, 0, 0.021))]
    last = 0.0
    for field in (1e-4, 0.1, 0.5, 2.0, 50.0):
        moment = M.induce(pair, field=(0, 0, field)).bodies[0].moment[2] * M.MU0 / box.volume
        assert last < moment < 1.5
        last = moment
    assert last > 1.45
    weak = [M.induce(b, field=(0, 0, 1e-5)).bodies[0].moment[2] for b in (box, linear)]
    assert weak[0] == pytest.approx(weak[1], rel=1e-4)


def test_the_explicit_response_is_that_of_lone_balls_to_the_magnets_alone():
    volume = 4e-6 / 3 * np.pi
    for chi, share in ((2.0, 6 / 5), (np.inf, 3.0), (-0.5, -1.5 / 2.5), (-1.0, -1.0)):
        ball = M.soft_sphere(radius=0.01, susceptibility=chi)
        both = M.induce(
            [ball, ball.moved((0, 0, 0.03))], field=(0, 0, 0.1), response="explicit", density=1e9
        ).bodies
        for body in both:
            assert body.moment == pytest.approx((0, 0, share * 0.1 * volume / M.MU0), rel=1e-12)
    # At this distance from a magnet, the force with the explicit response differs by 10 to 40 %
    # from that with the mutual response.
    cube, magnet = (
        M.soft_cuboid(size=(0.01,) * 3, susceptibility=1e4),
        M.cuboid(size=(0.01,) * 3, polarization=(0, 0, 1)),
    )
    cube = cube.moved((0, 0, 0.02))
    (true,) = M.induce(cube, by=magnet).bodies
    (rough,) = M.induce(cube, by=magnet, response="explicit", density=5.12e8).bodies
    ratio = M.force(on=rough, by=magnet).force[2] / M.force(on=true, by=magnet).force[2]
    assert 1.1 < abs(ratio - 1) + 1 < 1.4


def open_box():
    box = ls.meshes.box(size=(1, 1, 1))
    return ls.TriangleMesh(box.vertices, box.triangles[:-1])


ball = dict(radius=0.01, susceptibility=1.0)
BAD = {
    "susceptibility must be >= -1": lambda: M.soft_sphere(radius=1, susceptibility=-1.5),
    "susceptibility must be >= -1 .* other than 0": lambda: M.soft_cuboid(
        size=(1, 1, 1), susceptibility=0.0
    ),
    "susceptibility must be >= -1 .* got nan": lambda: BOX.with_susceptibility(np.nan),
    "radius must be > 0": lambda: M.soft_sphere(radius=np.nan, susceptibility=1),
    "size must be three lengths > 0": lambda: M.soft_cuboid(size=(1, 0, 1), susceptibility=1),
    "focus must be >= 0": lambda: M.soft_cuboid(size=(1, 1, 1), susceptibility=1, focus=-1.0),
    "cells of a cuboid must be a multiple of 4": lambda: M.soft_cuboid(
        size=(1, 1, 1), susceptibility=1, cells=10
    ),
    "degree must be between 0": lambda: M.soft_sphere(**ball, degree=401),
    "mesh must be closed": lambda: M.soft_mesh(open_box(), susceptibility=1),
    r"panels must be in \[0, 8000\], got 9000": lambda: M.soft_mesh(
        ls.meshes.box(size=(1, 1, 1)), susceptibility=1, panels=9000
    ),
    "saturation must be >= 0": lambda: M.soft_sphere(**ball, saturation=-1.0),
    "saturation must be 0 .* unless": lambda: M.soft_sphere(
        radius=1, susceptibility=-1, saturation=1.0
    ),
    r"soft\[0\] must lie apart .* by\[0\]": lambda: M.induce(BOX, by=MAGNET),
    r"soft\[0\] must lie apart .* soft\[1\]": lambda: M.induce([BOX, M.soft_sphere(**ball)]),
    "field must be finite": lambda: M.induce(BOX, field=(0, np.nan, 0)),
    "tolerance must be in": lambda: M.induce(BOX, field=(0, 0, 1), tolerance=0.0),
    "response must be": lambda: M.induce(BOX, field=(0, 0, 1), response="thesis"),  # type: ignore[arg-type]
    "density must be 0 .* without the explicit response, got 1": lambda: M.induce(
        BOX, field=(0, 0, 1), density=1.0
    ),
    "density must be > 0": lambda: M.induce(BOX, field=(0, 0, 1), response="explicit"),
    "saturation must be 0 .* explicit": lambda: M.induce(
        M.soft_sphere(**ball, saturation=1.0), field=(0, 0, 1), response="explicit", density=1e9
    ),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_bodies_are_refused(message):
    with pytest.raises(ls.InvalidInput, match=message):
        BAD[message]()
