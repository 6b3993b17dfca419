"""Meshes: generated, read, written, moved, queried, cut into convex parts, and refused if invalid.
Also tests obstacles and the mass of bodies.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import meshes


def area(mesh):
    corners = mesh.vertices[mesh.triangles]
    return (
        np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        / 2
    )


def volume(mesh):
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_a_grid_counts_its_vertices_row_by_row():
    mesh = ls.grid(size=(0.4, 0.3), cells=(4, 3))
    assert mesh.n_triangles == 24 and mesh.n_vertices == 20
    assert np.allclose(mesh.vertices[2 * 5 + 1], (-0.1, 0.05, 0))  # column 1, row 2
    assert np.isclose(area(mesh).sum(), 0.12) and mesh.flat and not mesh.closed
    assert len(mesh.edges) == mesh.n_vertices + mesh.n_triangles - 1  # V - E + F = 1 for a disc
    assert ls.grid(triangles=14476).n_triangles == pytest.approx(14476, rel=0.01)


def test_a_grid_wants_either_triangles_or_cells():
    with pytest.raises(ls.InvalidInput, match="either triangles or cells"):
        ls.grid()
    with pytest.raises(ls.InvalidInput, match="width must be > 0"):
        ls.grid(size=(0, 1), triangles=8)


@pytest.mark.parametrize("triangles", [100, 1000, 3616])
def test_irregular_squares_have_the_count_asked_for_and_good_angles(triangles):
    mesh = meshes.irregular(size=(0.5, 0.5), triangles=triangles)
    assert abs(mesh.n_triangles - triangles) <= 1
    assert np.isclose(area(mesh).sum(), 0.25)
    quality = meshes.quality(mesh)
    assert quality["min_angle_degrees"] > 22 and quality["median_angle_degrees"] > 45
    assert np.array_equal(mesh.uv, mesh.vertices[:, :2])


def test_irregular_meshes_depend_on_the_seed_alone():
    assert meshes.irregular(triangles=200, seed=3) == meshes.irregular(triangles=200, seed=3)
    assert meshes.irregular(triangles=200, seed=3) != meshes.irregular(triangles=200, seed=4)


def test_a_disc_and_a_strip_have_their_shapes():
    disc = meshes.disc(radius=0.5, triangles=1000)
    assert abs(disc.n_triangles - 1000) <= 1
    assert area(disc).sum() == pytest.approx(np.pi / 4, rel=0.01)  # polygon of at least 60 corners
    assert meshes.quality(disc)["min_angle_degrees"] > 22
    strip = meshes.strip(length=1.0, width=0.1, triangles=400, seed=1)
    assert np.ptp(strip.vertices, axis=0) == pytest.approx((1.0, 0.1, 0.0))
    # Without a seed, the strip is a grid of only a few rows of cells, so the number of triangles is
    # only roughly as requested.
    assert meshes.strip(length=1.0, width=0.1, triangles=400).n_triangles == pytest.approx(
        400, rel=0.15
    )


def test_solids_are_closed_and_have_their_volumes():
    assert volume(meshes.sphere(radius=0.1)) == pytest.approx(4 / 3 * np.pi * 1e-3, rel=0.01)
    assert volume(meshes.box(size=(1, 2, 3))) == pytest.approx(6)
    capsule = np.pi * 0.01 * 0.5 + 4 / 3 * np.pi * 1e-3
    assert volume(meshes.capsule(radius=0.1, length=0.5)) == pytest.approx(capsule, rel=0.03)
    prism = 0.5 * 14 * np.sin(2 * np.pi / 14) * 0.01 * 0.5
    assert volume(meshes.cylinder(radius=0.1, length=0.5, segments=14)) == pytest.approx(
        prism, rel=1e-12
    )
    funnel = meshes.funnel(
        top_radius=0.2, bottom_radius=0.05, height=0.2, tube_length=0.1, wall=0.01
    )
    bar = meshes.wave_bar(length=0.5, radius=0.02, amplitude=0.05, wavelength=0.2)
    for mesh in (
        funnel,
        bar,
        meshes.sphere(radius=1),
        meshes.box(size=(1, 1, 1)),
        meshes.capsule(radius=1, length=1),
        meshes.cylinder(radius=1, length=0.1),
    ):
        assert mesh.closed and volume(mesh) > 0


def test_a_floor_is_open_and_looks_up():
    floor = meshes.floor(size=2.0)
    corners = floor.vertices[floor.triangles]
    assert (
        not floor.closed
        and (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()
    )


def test_arrays_of_a_mesh_are_read_only_views():
    mesh = ls.grid(cells=(2, 2))
    for array in (mesh.vertices, mesh.triangles, mesh.uv):
        assert not array.flags.writeable and not array.flags.owndata
    assert np.shares_memory(mesh.vertices, mesh.vertices)


@pytest.mark.parametrize("ending", [".obj", ".ply", ".vtk", ".stl"])
def test_what_is_written_is_read_again(tmp_path, ending):
    mesh = meshes.sphere(radius=0.1, subdivisions=1)
    ls.meshes.write(tmp_path / f"mesh{ending}", mesh)
    again = ls.meshes.read(tmp_path / f"mesh{ending}")
    tolerance = 1e-7 if ending == ".stl" else 0  # STL has single precision
    assert again.n_triangles == mesh.n_triangles
    assert (
        np.abs(
            np.sort(again.vertices[again.triangles].sum(1), axis=0)
            - np.sort(mesh.vertices[mesh.triangles].sum(1), axis=0)
        ).max()
        <= tolerance
    )


@pytest.mark.parametrize("ending", [".obj", ".ply"])
def test_rest_coordinates_survive_a_file(tmp_path, ending):
    mesh = meshes.irregular(triangles=60)
    ls.meshes.write(tmp_path / f"mesh{ending}", mesh)
    assert np.array_equal(ls.meshes.read(tmp_path / f"mesh{ending}").uv, mesh.uv)


def test_files_that_are_no_meshes_are_refused(tmp_path):
    with pytest.raises(ls.CacheError, match="absent.obj"):
        ls.meshes.read(tmp_path / "absent.obj")
    (tmp_path / "noise.vtk").write_text("noise")
    with pytest.raises(ls.CacheError, match="cannot be read"):
        ls.meshes.read(tmp_path / "noise.vtk")


TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    "vertices, triangles, message",
    [
        ([[0, 0]], [[0, 0, 0]], r"vertices must have shape \(n, 3\), got \(1, 2\)"),
        (TRIANGLE, [[0, 1]], r"triangles must have shape \(n, 3\), got \(1, 2\)"),
        ("noise", [[0, 1, 2]], "vertices must be an array of numbers"),
        (TRIANGLE, [[0, 1, 3]], "3"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "2"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], "area"),
        ([*TRIANGLE, [5, 5, 5]], [[0, 1, 2]], "3"),
    ],
)
def test_meshes_that_cannot_be_simulated_are_refused_by_name_of_the_item(
    vertices, triangles, message
):
    with pytest.raises(ls.InvalidInput, match=message):
        ls.TriangleMesh(vertices, triangles)


def test_nearest_vertices_are_found():
    assert meshes.nearest_vertices(
        ls.grid(size=(1, 1), cells=(2, 2)), [(-0.5, -0.5, 0), (0.1, 0.1, 3)]
    ) == [0, 4]


def test_moving_a_mesh_moves_its_vertices_and_keeps_its_rest_coordinates():
    mesh = ls.grid(cells=(2, 2))
    turned = mesh.moved((1, 2, 3), rotation=[[0, -1, 0], [1, 0, 0], [0, 0, 1]], scale=2.0)
    assert np.allclose(turned.vertices, 2 * mesh.vertices[:, [1, 0, 2]] * [-1, 1, 1] + [1, 2, 3])
    assert np.array_equal(turned.uv, mesh.uv)


def test_closest_points_on_a_sphere_lie_below_the_point():
    query = ls.meshes.SpatialQuery(meshes.sphere(radius=1.0, subdivisions=4))
    found = query.closest((2, 0, 0), 5.0)
    assert found.distance == pytest.approx(1.0, abs=2e-3) and found.normal == pytest.approx(
        (1, 0, 0), abs=0.05
    )
    assert (
        found.triangle >= 0
        and found.barycentric.sum() == pytest.approx(1)
        and np.linalg.norm(found.point) > 0.99
    )
    assert query.closest((2, 0, 0), 0.5).triangle == -1
    assert query.inside((0.5, 0, 0)) and not query.inside((1.5, 0, 0))


def test_two_crossing_triangles_are_found_and_two_apart_are_not():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [0.3, 0.9, 1]]
    assert ls.collision.intersecting_pairs(points, [[0, 1, 2], [3, 4, 5]]) == [[0, 1]]
    apart = np.array(points) + ([[0, 0, 0]] * 3 + [[0, 0, 5]] * 3)
    assert ls.collision.intersecting_pairs(apart, [[0, 1, 2], [3, 4, 5]]) == []
    with pytest.raises(ls.InvalidInput, match=r"points must have shape \(n, 3\), got \(3,\)"):
        ls.collision.intersecting_pairs([1, 2, 3], [[0, 1, 2]])


def test_obstacles_stand_or_move_as_given():
    ball = ls.sphere(radius=0.1, centre=(1, 2, 3), friction=0.5)
    assert (
        ball.mesh.vertices.mean(0) == pytest.approx((1, 2, 3))
        and ball.friction == 0.5
        and len(ball.times) == 0
    )
    moving = ls.sphere(radius=0.1, times=[0, 1], positions=[(0, 0, 0), (0, 0, 1)])
    assert (
        moving.mesh.vertices.mean(0) == pytest.approx((0, 0, 0), abs=1e-12)
        and moving.positions[1][2] == 1
    )
    spinning = ls.obstacles.box(
        size=(1, 1, 1), centre=(0, 0, 2), times=[0, 1], axis_angles=[(0, 0, 0), (0, 0, 3)]
    )
    assert spinning.positions.tolist() == [[0, 0, 2], [0, 0, 2]]
    assert ls.floor(height=-1).floor and ls.floor(height=-1).mesh.vertices[:, 2] == pytest.approx(
        -1
    )
    lying = ls.capsule(radius=0.1, length=1.0, axis=(1, 0, 0))
    assert np.ptp(lying.mesh.vertices, axis=0) == pytest.approx((1.2, 0.2, 0.2), rel=0.02)
    assert ls.obstacles.funnel(
        top_radius=0.2, bottom_radius=0.05, height=0.2, tube_length=0.1, wall=0.01
    ).mesh.closed
    assert ls.obstacles.wave_bar(
        length=0.5, radius=0.02, amplitude=0.05, wavelength=0.2, centre=(0, 0, 1)
    ).mesh.closed


def test_a_body_of_two_lumps_is_cut_into_convex_parts():
    corner = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])  # an extruded L
    vertices = np.concatenate([np.c_[corner, np.zeros(6)], np.c_[corner, np.ones(6)]])
    cap = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    wall = np.array(
        [[(i, (i + 1) % 6, 6 + (i + 1) % 6), (i, 6 + (i + 1) % 6, 6 + i)] for i in range(6)]
    ).reshape(-1, 3)
    mesh = ls.TriangleMesh(vertices, np.concatenate([cap[:, ::-1], cap + 6, wall]))
    assert mesh.closed and volume(mesh) == pytest.approx(3)
    parts = ls.meshes.convex_parts(mesh)
    assert len(parts) == 2 and sum(map(volume, parts)) == pytest.approx(3, rel=0.02)
    with pytest.raises(ls.InvalidInput, match="closed"):
        ls.meshes.convex_parts(ls.grid(cells=(2, 2)))


def test_mass_of_a_cube_and_its_inertia():
    found = ls.meshes.mass_properties(meshes.box(size=(2, 2, 2)), 10.0)
    assert found.mass == pytest.approx(80) and found.centre == pytest.approx((0, 0, 0), abs=1e-12)
    assert found.inertia == pytest.approx(np.eye(3) * 80 * 4 / 6)
    with pytest.raises(ls.InvalidInput):
        ls.meshes.mass_properties(ls.grid(cells=(2, 2)), 10.0)


def test_a_body_has_its_given_mass_or_that_of_its_density():
    box = meshes.box(size=(2, 2, 2))
    dense = ls.meshes.mass_properties(ls.RigidBody(mesh=box, density=10.0))
    given = ls.meshes.mass_properties(ls.RigidBody(mesh=box, mass=80.0))
    assert dense.mass == pytest.approx(80) and given.mass == 80 and given.volume == dense.volume
    assert given.inertia == pytest.approx(dense.inertia, rel=1e-14)
    with pytest.raises(ls.InvalidInput, match="mesh must be a closed mesh, got none"):
        ls.meshes.mass_properties(ls.RigidBody(mass=1.0))
    with pytest.raises(ls.InvalidInput, match="mass must be >= 0"):
        ls.RigidBody(mesh=box, mass=-1.0)


def test_a_damaged_file_of_a_foreign_format_is_named(tmp_path):
    pytest.importorskip("meshio")
    path = tmp_path / "bad.stl"
    path.write_text("solid bad\nfacet normal 0 0 one\nouter loop\nvertex 0 0 ply\n")
    with pytest.raises(ls.CacheError, match=r"bad\.stl: cannot be read as a mesh"):
        ls.meshes.read(path)
