"""Forces between magnets and currents agree with reference values, energies and conservation
laws.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M
from magnet_sources import MAGNETS
from magnet_tables import cases

TOLERANCES = [1e-4, 1e-8]


def error(found, force, torque, radius):
    """Returns the larger of the errors of the force and of torque / radius, divided by the larger
    of the expected force and torque / radius.
    """
    size = max(np.linalg.norm(force), np.linalg.norm(torque) / radius)
    return (
        max(np.linalg.norm(found.force - force), np.linalg.norm(found.torque - torque) / radius)
        / size
    )


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_parallel_cuboids_agree_with_the_closed_form_at_every_gap_and_in_contact(tolerance):
    for case in cases("i_cuboid_parallel_force"):
        a = M.cuboid(size=case["dim1"], polarization=(0, 0, case["Jz1"]))
        b = M.cuboid(size=case["dim2"], polarization=(0, 0, case["Jz2"])).moved(case["pos2"])
        found = M.force(on=b, by=a, tolerance=tolerance)
        torque = case.get("T2_about_centre2", found.torque)
        assert error(found, case["F2"], torque, b.radius) < tolerance, case["id"]


@pytest.mark.parametrize(
    "offset", [(0.003, -0.002, 0.018), (-0.004, 0.014, 0.001), (0.011, 0.0, 0.0146), (0, 0, 0.0165)]
)
def test_the_closed_form_of_parallel_cuboids_is_what_integration_finds(offset):
    """Rotating b by 1e-9 rad about each axis makes M.force() integrate instead of using the closed
    form.
    """
    a = M.cuboid(size=(0.012, 0.01, 0.015), polarization=(0.4, -0.6, 0.8))
    for turn in ((0, 0, 0), (np.pi / 2, 0, 0), (0, 0, -np.pi / 2), (0, np.pi, 0)):
        b = (
            M.cuboid(size=(0.008, 0.014, 0.01), polarization=(-0.3, 0.5, 0.9))
            .at(offset)
            .rotated(turn)
        )
        closed = M.force(on=b, by=a, tolerance=1e-8)
        # The bound is three times the tolerance of the integral, whose integrand has logarithmic
        # singularities at aligned edges. The effect of the rotation is much smaller.
        integrated = M.force(on=b.rotated((1e-9, 1e-9, 1e-9)), by=a, tolerance=1e-7)
        assert error(closed, integrated.force, integrated.torque, b.radius) < 3e-7
        assert closed.error < 1e-10 * np.linalg.norm(closed.force)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_turned_cuboids_agree_with_the_reference(tolerance):
    for case in cases("i_cuboid_general_FT"):
        a = M.cuboid(size=case["dim1"], polarization=case["J1"])
        b = M.cuboid(size=case["dim2"], polarization=case["J2_body"]).at(
            case["pos2"], case["quat2_wxyz"]
        )
        assert (
            error(
                M.force(on=b, by=a, tolerance=tolerance),
                case["F2"],
                case["T2_about_centre2"],
                b.radius,
            )
            < tolerance
        )
        back = M.force(on=a, by=b, tolerance=tolerance)
        assert (
            error(back, np.negative(case["F2"]), case["T1_about_centre1"], a.radius) < 3 * tolerance
        )


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_cylinders_rings_and_loops_agree_with_the_reference(tolerance):
    for case in cases("vi_coaxial_cylinder_magnets"):
        a, b = (
            M.cylinder(
                radius=case[f"outer_radius{k}"],
                inner_radius=case[f"inner_radius{k}"],
                height=case[f"height{k}"],
                polarization=(0, 0, case[f"J{k}z"]),
            )
            for k in (1, 2)
        )
        found = M.force(on=b.moved((0, 0, case["centre2_z"])), by=a, tolerance=tolerance)
        assert found.force[2] == pytest.approx(case["F_on_2_z"], rel=tolerance)
    for case in cases("vi_coaxial_loops"):
        a, b = (
            M.loop(radius=case["a"], current=case["I1"]),
            M.loop(radius=case["b"], current=case["I2"]),
        )
        found = M.force(on=b.moved((0, 0, case["z"])), by=a, tolerance=tolerance)
        assert found.force[2] == pytest.approx(case["F2_z"], rel=tolerance)
    for case in cases("vi_loop_cylinder_magnet"):
        magnet = M.cylinder(
            radius=case["magnet_diameter"] / 2,
            height=case["magnet_height"],
            polarization=(0, 0, case["magnet_Jz"]),
        )
        loop = M.loop(radius=case["loop_radius"], current=case["loop_current"])
        found = M.force(
            on=magnet.moved((0, 0, case["magnet_centre_z"])), by=loop, tolerance=tolerance
        )
        assert found.force[2] == pytest.approx(case["F_on_magnet_z"], rel=tolerance)
    for case in cases("vi_general_loop_FT"):
        if case["source"] == "loop":
            by = M.loop(radius=case["source_radius"], current=case["source_current"])
        else:
            by = M.cuboid(size=case["source_dim"], polarization=case["source_J"])
        on = M.loop(radius=case["loop_radius"], current=case["loop_current"]).at(
            case["loop_pos"], case["loop_quat_wxyz"]
        )
        found = M.force(on=on, by=by, tolerance=tolerance)
        assert (
            error(found, case["F_on_loop"], case["T_on_loop_about_its_centre"], on.radius)
            < tolerance
        )


def pair(kind_a, kind_b):
    j = (0.4, -0.7, 0.9)
    make = {
        "cuboid": lambda: M.cuboid(size=(0.02, 0.012, 0.015), polarization=j),
        "cylinder": lambda: M.cylinder(radius=0.008, height=0.012, polarization=j),
        "ring": lambda: M.cylinder(radius=0.008, height=0.012, inner_radius=0.003, polarization=j),
        "sphere": lambda: M.sphere(radius=0.009, polarization=j),
        "mesh": lambda: M.mesh(ls.meshes.sphere(radius=0.009, subdivisions=1), polarization=j),
        "loop": lambda: M.loop(radius=0.01, current=50.0),
        "solenoid": lambda: M.solenoid(radius=0.008, length=0.015, turns=30, current=5.0),
        "polyline": lambda: M.polyline(
            [[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0.003], [0, 0, 0]], current=20.0
        ),
        "dipoles": lambda: M.dipoles(
            [[0, 0, 0.003], [0.004, 0, 0]], [[0.1, 0.2, 0.3], [0.3, -0.2, 0.1]]
        ),
    }
    return make[kind_a](), make[kind_b]().at((0.017, 0.013, 0.019), (0.8, 0.3, -0.4, 0.2))


KINDS = ["cuboid", "cylinder", "ring", "sphere", "mesh", "loop", "solenoid", "polyline", "dipoles"]


@pytest.mark.parametrize("kind", KINDS)
def test_integration_over_either_body_gives_the_same_force(kind):
    """Compares force and torque of a body on a cuboid with those on dipoles that fill the cuboid.

    The force on the cuboid is taken as minus that of the cuboid on the body.
    """
    a, b = pair("cuboid", kind)
    whole = M.force(on=b, by=a, tolerance=1e-9)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    u, v, w = (x.ravel() / 2 for x in np.meshgrid(nodes, nodes, nodes, indexing="ij"))
    share = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() / 8
    size = np.array((0.02, 0.012, 0.015))
    moments = share[:, None] * size.prod() * np.array((0.4, -0.7, 0.9)) / M.MU0
    cells = M.dipoles(np.stack([u, v, w], axis=1) * size, moments)
    on_cells = M.force(on=cells, by=b, tolerance=1e-9)
    assert (
        error(on_cells, -whole.force, M.force(on=a, by=b, tolerance=1e-9).torque, a.radius) < 1e-5
    )


@pytest.mark.parametrize("kind_a", KINDS)
@pytest.mark.parametrize("kind_b", KINDS)
def test_linear_and_angular_momentum_are_kept_to_rounding(kind_a, kind_b):
    a, b = pair(kind_a, kind_b)
    on_b, on_a = M.force(on=b, by=a), M.force(on=a, by=b)
    assert np.linalg.norm(on_a.force + on_b.force) <= 1e-14 * np.linalg.norm(on_b.force)
    turned = on_a.torque + on_b.torque + np.cross(b.position - a.position, on_b.force)
    assert np.linalg.norm(turned) < 1e-14 * (
        np.linalg.norm(on_b.force) * 0.03 + np.linalg.norm(on_b.torque)
    )
    system = M.forces([a, b], tolerance=1e-4)
    assert (
        error(M.Force(system.forces[1], system.torques[1], 0), on_b.force, on_b.torque, b.radius)
        < 2e-4
    )


@pytest.mark.parametrize(
    "kinds",
    [("cuboid", "cuboid"), ("cuboid", "cylinder"), ("ring", "mesh"), ("cylinder", "sphere")],
)
def test_force_and_torque_are_minus_the_gradient_of_the_energy(kinds):
    """The energy is E = - integral of J_b . H_a over the volume of b, where J_b is the polarization
    of b and H_a the field of a. A sum over dipoles that fill b approximates the integral.
    """
    b, a = pair(*kinds)  # b is at the origin
    nodes, weights = np.polynomial.legendre.leggauss(14)
    nodes, weights = (nodes + 1) / 2, weights / 2
    if kinds[0] == "cuboid":
        u, v, w = (x.ravel() - 0.5 for x in np.meshgrid(nodes, nodes, nodes, indexing="ij"))
        share = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() * 0.02 * 0.012 * 0.015
        cells = np.stack([u * 0.02, v * 0.012, w * 0.015], axis=1)
    else:
        inner, phi = (0.003 if kinds[0] == "ring" else 0.0), 2 * np.pi * np.arange(40) / 40
        u, p, w = (x.ravel() for x in np.meshgrid(nodes, phi, nodes, indexing="ij"))
        rho = np.sqrt(inner**2 + u * (0.008**2 - inner**2))
        share = (
            np.einsum("i,j,k->ijk", weights, np.ones(40) / 40, weights).ravel()
            * np.pi
            * (0.008**2 - inner**2)
            * 0.012
        )
        cells = np.stack([rho * np.cos(p), rho * np.sin(p), (w - 0.5) * 0.012], axis=1)
    moments = share[:, None] * np.array((0.4, -0.7, 0.9)) / M.MU0

    def energy(shift, turn):
        angle = np.linalg.norm(turn)
        k = np.cross(np.eye(3), turn / angle) if angle else np.zeros((3, 3))
        rotation = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
        return -(M.field(a, cells @ rotation.T + shift) * (moments @ rotation.T)).sum()

    found = M.force(on=b, by=a, tolerance=1e-9)
    zero, force, torque = np.zeros(3), np.zeros(3), np.zeros(3)
    for k in range(3):
        d = np.zeros(3)
        d[k] = 1e-4
        force[k] = -(energy(d, zero) - energy(-d, zero)) / 2e-4
        d[k] = 1e-3
        torque[k] = -(energy(zero, d) - energy(zero, -d)) / 2e-3
    assert error(found, force, torque, b.radius) < 1e-4  # error of second-order differences


def test_a_magnet_cut_in_two_feels_and_exerts_the_same():
    a = M.cuboid(size=(0.01, 0.01, 0.01), polarization=(0.3, 0.4, 1.0))
    half = M.cuboid(size=(0.01, 0.01, 0.005), polarization=(0.3, 0.4, 1.0))
    parts = [half.moved((0, 0, -0.0025)), half.moved((0, 0, 0.0025))]
    b = M.cuboid(size=(0.008, 0.012, 0.01), polarization=(0, 0.2, 1.0)).at(
        (0.003, 0.002, 0.0125), (1, 0.1, 0, 0.05)
    )
    whole = M.force(on=b, by=a, tolerance=1e-9)
    both = [M.force(on=b, by=part, tolerance=1e-9) for part in parts]
    assert np.linalg.norm(sum(f.force for f in both) - whole.force) < 1e-8 * np.linalg.norm(
        whole.force
    )
    assert (
        np.linalg.norm(sum(f.torque for f in both) - whole.torque)
        < 1e-8 * np.linalg.norm(whole.force) * b.radius
    )


def test_forces_scale_with_size_and_polarization_and_turn_with_the_frame():
    a, b = pair("cuboid", "cylinder")
    f = M.force(on=b, by=a, tolerance=1e-8)
    large = M.force(
        on=M.cylinder(radius=0.8, height=1.2, polarization=(0.8, -1.4, 1.8)).at(
            100 * b.position, b.orientation
        ),
        by=M.cuboid(size=(2, 1.2, 1.5), polarization=(0.4, -0.7, 0.9)),
        tolerance=1e-8,
    )
    assert np.allclose(
        large.force, 2e4 * f.force, rtol=1e-7, atol=1e-7 * np.linalg.norm(large.force)
    )
    assert np.allclose(
        large.torque, 2e6 * f.torque, rtol=1e-7, atol=1e-7 * np.linalg.norm(large.torque)
    )
    turn = np.array([0.0, 0.0, np.pi / 2])
    x, y, _ = b.position
    turned = M.force(
        on=b.rotated(turn).moved((-y - x, x - y, 0)), by=a.rotated(turn), tolerance=1e-8
    )
    assert np.allclose(
        turned.force,
        [-f.force[1], f.force[0], f.force[2]],
        rtol=0,
        atol=1e-7 * np.linalg.norm(f.force),
    )


def test_far_apart_bodies_are_dipoles():
    for kind in ("cuboid", "cylinder", "mesh", "loop", "solenoid"):
        a, b = pair("cuboid", kind)
        b = b.at((3.0, 5.0, -4.0), b.orientation)
        found = M.force(on=b, by=a, tolerance=1e-8)
        force, torque = M.dipole_forces([b.position], [b.moment], [a.position], [a.moment])
        # The next multipole is smaller by about the factor (size / distance)^2 = 1e-5.
        assert error(found, force[0], torque[0], b.radius) < 1e-4, kind


def test_many_bodies_feel_the_sum_of_pairs_on_any_number_of_threads():
    rng = np.random.default_rng(8)
    kinds = ["cuboid", "cylinder", "sphere", "loop", "mesh", "dipoles"]
    bodies = [
        pair(kind, "loop")[0].at(
            0.05 * np.array((i % 2, i // 2 % 2, i // 4)) + 0.005 * rng.random(3), rng.normal(size=4)
        )
        for i, kind in enumerate(kinds)
    ]
    one = M.forces(bodies, tolerance=1e-6, threads=1)
    for threads in (2, 3, 7):
        assert all(
            np.array_equal(x, y)
            for x, y in zip(one, M.forces(bodies, tolerance=1e-6, threads=threads), strict=True)
        )
    size = np.linalg.norm(one.forces, axis=1).max()
    assert np.abs(one.forces.sum(axis=0)).max() < 1e-14 * size
    arms = np.array([b.position for b in bodies])
    assert np.abs((one.torques + np.cross(arms, one.forces)).sum(axis=0)).max() < 1e-14 * size
    for i, on in enumerate(bodies):
        pairs = [M.force(on=on, by=by, tolerance=1e-8) for k, by in enumerate(bodies) if k != i]
        assert np.linalg.norm(sum(f.force for f in pairs) - one.forces[i]) < 5e-6 * size


def test_spheres_among_themselves_feel_the_sum_of_pairs():
    rng = np.random.default_rng(9)
    spheres = [
        M.sphere(radius=0.004, polarization=rng.normal(size=3)).at(
            0.02 * np.array((i % 3, i // 3 % 3, i // 9)), rng.normal(size=4)
        )
        for i in range(20)
    ]
    bodies = [
        *spheres,
        M.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1)).moved((0.03, 0.03, 0.06)),
    ]
    together = M.forces(bodies, tolerance=1e-8)
    size = np.linalg.norm(together.forces, axis=1).max()
    for i in (0, 7, 20):
        pairs = [
            M.force(on=bodies[i], by=by, tolerance=1e-10) for k, by in enumerate(bodies) if k != i
        ]
        assert np.linalg.norm(sum(f.force for f in pairs) - together.forces[i]) < 1e-7 * size
        assert (
            np.linalg.norm(sum(f.torque for f in pairs) - together.torques[i]) < 1e-7 * size * 0.01
        )
    arms = np.array([b.position for b in bodies])
    assert np.abs(together.forces.sum(axis=0)).max() < 1e-13 * size
    assert (
        np.abs((together.torques + np.cross(arms, together.forces)).sum(axis=0)).max()
        < 1e-14 * size
    )


@pytest.mark.parametrize("name", ["cuboid", "cylinder", "ring", "mesh", "sphere"])
def test_solid_magnets_that_overlap_are_refused(name):
    cuboid, other = MAGNETS["cuboid"], MAGNETS[name]
    low = 0.006 if name in ("mesh", "sphere") else 0.004 if name == "cuboid" else 0.005
    message = "magnets must lie apart to exert forces, but {} overlaps {}; move one of them"
    for place in ((0.001, 0.002, 0.002), (0.001, 0.002, 0.004 + 0.98 * low)):
        inside = other.moved(place)
        with pytest.raises(ls.InvalidInput, match=message.format("on", "by")):
            M.force(on=inside, by=cuboid)
        with pytest.raises(ls.InvalidInput, match=message.format("on", "by")):
            M.force(on=cuboid, by=inside)
        far = [cuboid.moved((0.1, 0, 0)), cuboid, cuboid.moved((0.2, 0, 0)), inside]
        names = (r"bodies\[1\]", r"bodies\[3\]")
        with pytest.raises(ls.InvalidInput, match=message.format(*names)):
            M.forces(far)
    touching = other.moved((0.001, 0.002, 0.004 + low))
    assert np.isfinite(M.force(on=touching, by=cuboid, tolerance=1e-2).force).all()


def _touching_pairs():
    """Returns, by name, two bodies and the height [m] at which the second touches the first."""
    cuboid = M.cuboid(size=(0.008, 0.008, 0.03), polarization=(0.2, 0, 1))
    small = M.cuboid(size=(0.006, 0.006, 0.02), polarization=(0, 0.1, 1))
    cylinder = M.cylinder(radius=0.005, height=0.01, polarization=(0, 0.1, 1))
    mesh = M.mesh(ls.meshes.box(size=(0.008, 0.006, 0.01)), polarization=(0, 0, 1))
    iron = M.soft_cuboid(size=(0.01, 0.01, 0.01), susceptibility=10.0, cells=8)
    (induced,) = M.induce(iron, field=(0, 0, 0.5)).bodies
    return {
        "parallel cuboids": (cuboid, small, 0.025),
        "cuboids": (cuboid, small.rotated((0, 0, 0.3)), 0.025),
        "cuboid and cylinder": (cuboid, cylinder, 0.02),
        "cylinder and mesh": (cylinder, mesh, 0.01),
        "cuboid and iron": (cuboid, induced, 0.02),
    }


@pytest.mark.parametrize("name", _touching_pairs())
def test_the_force_between_magnets_does_not_jump_where_they_touch(name):
    """Poses of bodies in contact are rounded, so that bodies may overlap a little. The force on the
    surface charge of one body must then use the outer value of the other body's H, which jumps at
    the surface of that other body. A change of the gap by 1.6e-8 m changes the force by less than
    1e-5 of its value; the tolerance allows for the quadrature.
    """
    by, body, touching = _touching_pairs()[name]
    apart = M.force(on=body.moved((0, 0, touching + 8e-9)), by=by, tolerance=1e-5)
    close = M.force(on=body.moved((0, 0, touching - 8e-9)), by=by, tolerance=1e-5)
    assert error(close, apart.force, apart.torque, body.radius) < 1e-4


@pytest.mark.parametrize("name", [name for name in _touching_pairs() if "iron" not in name])
def test_the_energy_of_magnets_does_not_jump_where_they_touch(name):
    by, body, touching = _touching_pairs()[name]
    apart = M.energy([by, body.moved((0, 0, touching + 8e-9))], tolerance=1e-5)
    close = M.energy([by, body.moved((0, 0, touching - 8e-9))], tolerance=1e-5)
    assert close == pytest.approx(apart, rel=1e-4)


def test_an_induced_body_that_overlaps_another_magnet_is_refused():
    soft = M.soft_cuboid(size=(0.01, 0.01, 0.01), susceptibility=10.0, cells=8)
    (induced,) = M.induce(soft, field=(0, 0, 1)).bodies
    with pytest.raises(ls.InvalidInput, match="on overlaps by"):
        M.force(on=induced, by=MAGNETS["sphere"].moved((0.004, 0.006, 0)))


def test_mistakes_with_forces_are_named():
    a = M.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    with pytest.raises(ls.InvalidInput, match=r"tolerance must be in \[1e-12, 0.1\]"):
        M.force(on=a, by=a.moved((0.1, 0, 0)), tolerance=0)
    with pytest.raises(ls.InvalidInput, match="must be closed to feel and exert forces"):
        M.force(on=M.polyline([[0, 0, 0], [1, 0, 0]], current=1), by=a)
    with pytest.raises(ls.InvalidInput, match="threads must be at least 0"):
        M.forces([a, a.moved((0.1, 0, 0))], threads=-2)


def test_wires_that_meet_are_refused_because_their_force_is_infinite():
    loop = M.loop(radius=0.02, current=1.0)
    square = M.polyline(
        [[0.02, -0.01, 0], [0.02, 0.01, 0], [0.04, 0.01, 0], [0.04, -0.01, 0], [0.02, -0.01, 0]],
        current=1.0,
    )
    for other in (
        loop,
        loop.moved((0.04, 0, 0)),  # touches the loop from outside
        loop.rotated((0.3, 0.4, 0.5)),  # crosses it at two points
        square,
    ):
        with pytest.raises(ls.InvalidInput, match="thin wires must lie apart.* on meets by"):
            M.force(on=other, by=loop)
    with pytest.raises(ls.InvalidInput, match=r"bodies\[0\] meets bodies\[2\]"):
        M.forces([loop, loop.moved((0, 0, 0.01)), square])
    # At a small gap, two equal coaxial loops attract each other like long parallel wires, with the
    # force mu0 I^2 / (2 pi gap) per unit length.
    gap = 1e-5
    pull = M.force(on=loop.moved((0, 0, gap)), by=loop).force[2]
    assert pull == pytest.approx(-M.MU0 * 0.02 / gap, rel=1e-4)
    linked = loop.rotated((np.pi / 2, 0, 0)).moved((0.02, 0, 0))  # linked like a chain
    assert np.isfinite(M.force(on=linked, by=loop).torque).all()
