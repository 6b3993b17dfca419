"""Field formulas agree with reference values, with each other, and with the laws of
magnetostatics.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M
from magnet_sources import J, sources, tetrahedron
from magnet_tables import cases, each_case


def relative(found, expected):
    """Returns the largest of the relative errors of the rows."""
    found, expected = np.atleast_2d(found), np.atleast_2d(expected)
    return (np.linalg.norm(found - expected, axis=-1) / np.linalg.norm(expected, axis=-1)).max()


def outside(source, scale, count=40, seed=1):
    """Returns points at 0.5 to 2 times `scale` [m] from the origin, but never closer than 1.05
    times the radius of the source.
    """
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    return points * np.maximum(scale * np.linspace(0.5, 2.0, count), 1.05 * source.radius)[:, None]


@each_case("iii_exterior_fields")
def test_exterior_fields_agree_with_the_reference(case):
    points, polarization = np.array(case["points"]), case["J"]
    if case["kind"] == "cuboid":
        field = M.cuboid_field(points, size=case["dim"], polarization=polarization)
    elif case["kind"] == "sphere":
        field = M.sphere_field(points, radius=case["diameter"] / 2, polarization=polarization)
    elif case["kind"] == "trimesh":
        field = M.mesh_field(
            points, ls.TriangleMesh(case["vertices"], case["faces"]), polarization=polarization
        )
    else:
        outer, inner = (
            case.get("diameter", case.get("outer_diameter")),
            case.get("inner_diameter", 0.0),
        )
        field = M.cylinder_field(
            points,
            radius=outer / 2,
            inner_radius=inner / 2,
            height=case["height"],
            polarization=polarization,
        )
    # The tolerance is the accuracy of the table, which is lower at one point of trimesh_09.
    assert relative(field, case["B"]) < (1e-9 if case["id"] == "trimesh_09" else 5e-12)


def test_loops_and_solenoids_agree_with_the_reference():
    for case in cases("vi_loop_field"):
        assert (
            relative(
                M.loop_field([case["point"]], radius=case["radius"], current=case["current"]),
                [case["B"]],
            )
            < 1e-14
        )
    for case in cases("vi_solenoid_field"):
        field = M.solenoid_field(
            [[0, case["rho"], case["z"]]],
            radius=case["radius"],
            length=case["length"],
            turns=case["turns"],
            current=case["current"],
        )
        # The tolerance is the accuracy of the table.
        assert relative(field, [[0, case["B_rho_sheet"], case["B_z_sheet"]]]) < 1e-11


def test_dipole_pairs_and_clouds_agree_with_the_reference():
    for case in cases("ii_dipole_pairs"):
        points, moments = [[0, 0, 0], case["r_1to2"]], [case["m1"], case["m2"]]
        forces, torques = M.dipole_forces(points, moments)
        assert relative(forces, [np.negative(case["F_on_2"]), case["F_on_2"]]) < 1e-14
        assert relative(torques, [case["T_on_1"], case["T_on_2"]]) < 1e-14
        # The terms of the energy may nearly cancel, which amplifies rounding errors.
        assert M.dipole_energy(points, moments) == pytest.approx(case["U"], rel=1e-12)
    for case in cases("ii_dipole_clouds"):
        points, moments = case["positions"], case["moments"]
        # Cancellation in the sums limits the accuracy.
        assert relative(M.dipole_field(points, moments, points), case["B"]) < 1e-12
        assert relative(M.dipole_forces(points, moments)[0], case["F"]) < 1e-12
        assert M.dipole_energy(points, moments) == pytest.approx(case["U"], rel=1e-12)


def test_forces_of_dipoles_keep_linear_and_angular_momentum():
    rng = np.random.default_rng(3)
    points, moments = rng.normal(size=(301, 3)), rng.normal(size=(301, 3))
    forces, torques = M.dipole_forces(points, moments)
    scale = np.abs(forces).sum()
    assert np.abs(forces.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs((torques + np.cross(points, forces)).sum(axis=0)).max() < 1e-13 * scale


def test_force_on_a_dipole_is_minus_the_gradient_of_the_energy():
    rng = np.random.default_rng(5)
    points, moments = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    force = M.dipole_forces(points, moments)[0][1]
    errors = []
    for h in (1e-2, 5e-3):  # two steps, to test for second order
        slope = np.zeros(3)
        for k in range(3):
            step = np.zeros((4, 3))
            step[1, k] = h
            slope[k] = (
                M.dipole_energy(points - step, moments) - M.dipole_energy(points + step, moments)
            ) / (2 * h)
        errors.append(np.linalg.norm(slope - force) / np.linalg.norm(force))
    assert 3.8 < errors[0] / errors[1] < 4.2


@pytest.mark.parametrize("name", sources())
@pytest.mark.parametrize("scale", [0.02, 0.1, 3.0])
def test_gradients_are_derivatives_of_fields(name, scale):
    body = sources()[name]
    points = outside(body, scale)
    step = 3e-3 * np.linalg.norm(points, axis=1).min()

    def difference(h):
        out = np.zeros((len(points), 3, 3))
        for j in range(3):
            d = np.zeros(3)
            d[j] = h
            plus, minus = M.field(body, points + d), M.field(body, points - d)
            far_plus, far_minus = M.field(body, points + 2 * d), M.field(body, points - 2 * d)
            out[:, :, j] = (8 * (plus - minus) - (far_plus - far_minus)) / (12 * h)
        return out

    gradient = M.gradient(body, points)
    size = np.linalg.norm(gradient, axis=(1, 2))
    errors = [
        np.median(np.linalg.norm(difference(h) - gradient, axis=(1, 2)) / size)
        for h in (step, step / 2)
    ]
    assert errors[1] < 1e-8  # the error of the differences is of order h^4
    # Halving h divides an error of fourth order by 16, unless rounding dominates. Rounding errors
    # are larger for a distant polyline, because the fields of its segments nearly cancel.
    assert errors[0] / errors[1] > 10 or errors[1] < (1e-9 if name == "polyline" else 1e-11)
    assert np.abs(np.trace(gradient, axis1=1, axis2=2) / size).max() < 1e-12  # div B = 0
    assert np.array_equal(gradient, gradient.transpose(0, 2, 1))


@pytest.mark.parametrize("name", ["cuboid", "cylinder", "ring", "mesh"])
def test_far_fields_lose_no_digits(name):
    """Compares fields and gradients with those of dipoles at quadrature points in the volume."""
    body = sources()[name]
    nodes, weights = np.polynomial.legendre.leggauss(12)
    nodes, weights = (nodes + 1) / 2, weights / 2
    u, v, w = (a.ravel() for a in np.meshgrid(nodes, nodes, nodes, indexing="ij"))
    share = np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
    if name == "cuboid":
        volume = 0.02 * 0.01 * 0.015
        cells = np.stack([u - 0.5, v - 0.5, w - 0.5], axis=1) * (0.02, 0.01, 0.015)
    elif name == "mesh":
        a, b, c, d = tetrahedron().vertices
        cells = a + u[:, None] * ((b - a) + v[:, None] * ((c - b) + w[:, None] * (d - c)))
        cells -= tetrahedron().vertices.mean(axis=0)  # origin at the centre of the tetrahedron
        share = share * u**2 * v
        volume = abs(np.dot(np.cross(b - a, c - a), d - a))
    else:
        inner = 0.004 if name == "ring" else 0.0
        rho = np.sqrt(inner**2 + u * (0.01**2 - inner**2))
        around = 2 * np.pi * (np.arange(32) + 0.5) / 32  # exact up to trigonometric degree 31
        cells = np.concatenate(
            [
                np.stack([rho * np.cos(p), rho * np.sin(p), (w - 0.5) * 0.013], axis=1)
                for p in around
            ]
        )
        share = np.tile(share, 32) / 32
        volume = np.pi * (0.01**2 - inner**2) * 0.013
    moments = share[:, None] * volume * np.array(J) / M.MU0
    # The points are at 1 to 1e4 times the size of the body. Meshes switch to a multipole expansion
    # at 4 radii, and cylinders use the midpoint rule for points that are distant or near the axis.
    for distance in (
        0.05,
        0.1,
        0.3,
        1.0,
        10.0,
        100.0,
    ):
        points = outside(body, distance)
        # The tolerances allow for rounding in sums of 2e3 to 6e4 terms, and at 0.05 m also for
        # errors of the quadrature.
        assert relative(M.field(body, points), M.dipole_field(cells, moments, points)) < (
            1e-13 if distance > 0.05 else 2e-11
        )
        gradient = M.dipole_gradient(cells, moments, points).reshape(-1, 9)
        assert relative(M.gradient(body, points).reshape(-1, 9), gradient) < (
            1e-12 if distance > 0.05 else 2e-10
        )


def test_a_mesh_of_a_box_is_a_cuboid_and_a_fine_prism_a_cylinder():
    box = ls.meshes.box(size=(0.02, 0.01, 0.015))
    points = np.random.default_rng(2).uniform(-0.03, 0.03, size=(500, 3))
    for quantity in ("B", "H"):
        cuboid = M.cuboid_field(points, size=(0.02, 0.01, 0.015), polarization=J, quantity=quantity)
        centre = box.vertices.mean(axis=0)
        assert (
            relative(M.mesh_field(points + centre, box, polarization=J, quantity=quantity), cuboid)
            < 1e-12
        )
    # Inscribed n-gons have an error of second order in 1/n.
    errors = []
    for n in (64, 128):
        phi = 2 * np.pi * np.arange(n) / n
        ring = np.stack([0.01 * np.cos(phi), 0.01 * np.sin(phi)], axis=1)
        vertices = np.concatenate(
            [
                np.c_[ring, np.full(n, -0.0065)],
                np.c_[ring, np.full(n, 0.0065)],
                [[0, 0, -0.0065], [0, 0, 0.0065]],
            ]
        )
        k, next_k = np.arange(n), np.roll(np.arange(n), -1)
        faces = np.concatenate(
            [
                np.c_[k, next_k, next_k + n],
                np.c_[k, next_k + n, k + n],
                np.c_[next_k, k, 0 * k + 2 * n],
                np.c_[k + n, next_k + n, 0 * k + 2 * n + 1],
            ]
        )
        away = outside(sources()["cylinder"], 0.02)
        prism = M.mesh_field(away, ls.TriangleMesh(vertices, faces), polarization=J)
        errors.append(
            relative(prism, M.cylinder_field(away, radius=0.01, height=0.013, polarization=J))
        )
    assert errors[1] < 2e-3 and 3.5 < errors[0] / errors[1] < 4.5


def test_b_and_h_differ_inside_by_the_polarization_alone():
    for name, point in (
        ("cuboid", (0.003, 0.002, -0.004)),
        ("cylinder", (0.003, 0.002, -0.004)),
        ("ring", (0.006, 0.002, 0.003)),
        ("sphere", (0.003, 0.002, -0.004)),
        ("mesh", (0.001, 0.001, 0.001)),
    ):
        body = sources()[name]
        jump = M.field(body, [point]) - M.MU0 * M.field(body, [point], quantity="H")
        assert np.allclose(jump, [J], rtol=0, atol=1e-14), name
    bore = [[0.001, 0.002, 0.003]]
    ring = sources()["ring"]
    assert np.allclose(
        M.field(ring, bore), M.MU0 * M.field(ring, bore, quantity="H"), rtol=1e-14, atol=0
    )
    assert np.allclose(
        M.sphere_field([[0, 0, 0.001]], radius=0.01, polarization=J),
        2 / 3 * np.array(J),
        rtol=1e-15,
    )


def test_normal_b_and_tangential_h_pass_through_surfaces():
    h = 1e-9  # distance to the surface [m]; over this distance, fields change by about 1e-7 T
    for name, point, normal in (
        ("cuboid", (0.01, 0.001, 0.002), (1, 0, 0)),
        ("cylinder", (0.006, 0.008, 0.002), (0.6, 0.8, 0)),
        ("cylinder", (0.003, 0.002, 0.0065), (0, 0, 1)),
        ("ring", (0.0024, 0.0032, 0.001), (-0.6, -0.8, 0)),
    ):
        body, x, n = sources()[name], np.array(point), np.array(normal)
        sides = [x - h * n, x + h * n]
        b, strength = M.field(body, sides), M.MU0 * M.field(body, sides, quantity="H")
        assert abs(np.dot(b[1] - b[0], n)) < 1e-6
        assert np.abs(np.cross(strength[1] - strength[0], n)).max() < 1e-6
        assert np.dot(strength[1] - strength[0], n) == pytest.approx(np.dot(J, n), abs=1e-6)
        # On the surface itself, the field has its outer value.
        assert np.abs(M.field(body, [x]) - b[1]).max() < 1e-6


def test_values_on_faces_edges_corners_wires_and_axes_are_finite():
    on = {
        "cuboid": [
            (0.01, 0.005, 0.0075),
            (0.01, 0.005, 0),
            (0.01, 0.005, 0.02),
            (0, 0, 0.0075),
            (0, 0, 0),
        ],
        "cylinder": [
            (0.01, 0, 0.0065),
            (0.01, 0, 0),
            (0, 0, 0.0065),
            (0, 0, 0),
            (0, 0, 0.5),
            (0.01, 0, 0.1),
        ],
        "ring": [(0.004, 0, 0.0065), (0.004, 0, 0), (0, 0, 0)],
        "mesh": [tuple(v - tetrahedron().vertices.mean(axis=0)) for v in tetrahedron().vertices],
        "loop": [(0.01, 0, 0), (0, 0, 0), (0, 0.01, 0)],
        "solenoid": [(0.01, 0, 0.01), (0.01, 0, 0), (0, 0, 0.01)],
        "polyline": [(0, 0, 0)],
        "sphere": [(0, 0, 0.01), (0, 0, 0)],
        "dipoles": [(0, 0, 0)],
    }
    for name, body in sources().items():
        assert np.isfinite(M.field(body, on[name])).all(), name
        assert np.isfinite(M.gradient(body, on[name])).all(), name


def test_near_an_edge_the_field_grows_as_the_logarithm_of_the_distance():
    """At an edge of a cuboid, two faces with charge density j meet at a right angle. When the
    distance from the edge shrinks by a factor of e, B along (1, 1, 0) grows by 2 j/(4 pi) sqrt 2.
    """
    distances = 10.0 ** -np.arange(4.0, 12.0)
    corner = np.array([0.01, 0.005, 0.0])
    away = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    field = (
        M.cuboid_field(
            corner + 0.01 * distances[:, None] * away,
            size=(0.02, 0.01, 0.015),
            polarization=(1, 1, 0),
        )
        @ away
    )
    slope = np.diff(field) / np.log(10)
    # Positions of about 0.01 m are rounded to 1e-18 m, which is 1e-5 of the smallest distance,
    # 1e-13 m.
    assert slope == pytest.approx(np.full(7, 2 / (4 * np.pi) * np.sqrt(2)), rel=1e-4)


def test_the_flux_of_b_through_a_closed_surface_is_zero_and_the_circulation_of_h_the_current():
    ball = ls.meshes.sphere(radius=0.03, subdivisions=4)
    corners = ball.vertices[ball.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    for name, body in sources().items():
        flux = np.einsum("ij,ij->i", M.field(body, corners.mean(axis=1)), normals)
        assert abs(flux.sum()) < 2e-3 * np.abs(flux).sum(), name  # error of the flat triangles
    phi = 2 * np.pi * (np.arange(400) + 0.5) / 400
    path = np.stack([0.01 + 0.004 * np.cos(phi), 0 * phi, 0.004 * np.sin(phi)], axis=1)
    step = 0.004 * 2 * np.pi / 400 * np.stack([-np.sin(phi), 0 * phi, np.cos(phi)], axis=1)
    strength = M.field(M.loop(radius=0.01, current=3.0), path, quantity="H")
    # The trapezoidal rule converges exponentially, because the integrand is smooth and periodic.
    assert (strength * step).sum() == pytest.approx(-3.0, rel=1e-12)


def test_the_same_bits_on_any_number_of_threads_and_beside_any_neighbours():
    points = np.random.default_rng(4).normal(size=(1003, 3)) * 0.03
    for name, body in sources().items():
        one, gradient = M.field(body, points, threads=1), M.gradient(body, points, threads=1)
        for threads in (2, 3, 7):
            assert np.array_equal(one, M.field(body, points, threads=threads)), name
            assert np.array_equal(gradient, M.gradient(body, points, threads=threads)), name
        assert np.array_equal(one[5:900:7], M.field(body, points[5:900:7])), name
        assert np.array_equal(gradient[5:900:7], M.gradient(body, points[5:900:7])), name
    moments = np.random.default_rng(5).normal(size=(1003, 3))
    one = M.dipole_forces(points, moments, threads=1)
    for threads in (2, 3, 7):
        assert all(
            np.array_equal(a, b)
            for a, b in zip(one, M.dipole_forces(points, moments, threads=threads), strict=True)
        )


def test_bodies_move_and_turn_with_their_fields():
    points = np.random.default_rng(6).normal(size=(20, 3)) * 0.05
    turn = np.array([0.3, -0.7, 1.1])
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    for name, body in sources().items():
        moved = body.rotated(turn).moved((0.01, 0.02, -0.03))
        expected = M.field(body, points) @ rotation.T
        assert (
            relative(M.field(moved, points @ rotation.T + (0.01, 0.02, -0.03)), expected) < 1e-11
        ), name
        assert np.allclose(moved.moment, rotation @ body.moment, rtol=1e-13, atol=0), name
        gradient = rotation @ M.gradient(body, points) @ rotation.T
        turned = M.gradient(moved, points @ rotation.T + (0.01, 0.02, -0.03))
        assert relative(turned.reshape(-1, 9), gradient.reshape(-1, 9)) < 1e-10, name
    both = [sources()["loop"], sources()["sphere"]]
    assert np.allclose(
        M.field(both, points), sum(M.field(b, points) for b in both), rtol=1e-14, atol=0
    )
