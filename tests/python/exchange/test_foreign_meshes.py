"""Meshes of trimesh and meshio are accepted in place of a TriangleMesh."""

import loomstone as ls
import meshio
import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

BOX = ls.meshes.box(size=(0.1, 0.2, 0.3))
QUADS = np.array([[0, 1, 3, 2], [2, 3, 5, 4]])
POINTS = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0, 2], [1, 2]], float)

BOXES = {
    "trimesh": trimesh.Trimesh(BOX.vertices, BOX.triangles, process=False),
    "meshio": meshio.Mesh(BOX.vertices, [("line", BOX.edges[:2]), ("triangle", BOX.triangles)]),
}


@pytest.mark.parametrize("box", BOXES.values(), ids=list(BOXES))
def test_meshes_of_trimesh_and_meshio_are_accepted_as_triangle_meshes(box, tmp_path):
    assert ls.Cloth(mesh=box).mesh == BOX
    assert ls.Cloth(mesh=BOX).replace(mesh=box).mesh == BOX
    assert ls.RigidBody(mesh=box, parts=[box]).parts == [BOX]
    assert ls.Obstacle(mesh=box).mesh == BOX
    assert ls.obstacles.mesh(box, centre=(1, 0, 0)).mesh == BOX.moved((1, 0, 0))
    assert ls.meshes.quality(box) == ls.meshes.quality(BOX)
    assert ls.meshes.mass_properties(box, density=1.0).mass == pytest.approx(0.006)
    assert ls.meshes.nearest_vertices(box, BOX.vertices[:2]) == [0, 1]
    point = ls.meshes.SpatialQuery(box).closest((1.0, 0.0, 0.0), 2.0)
    assert point.distance == pytest.approx(0.95)
    ls.meshes.write(tmp_path / "box.ply", box)
    assert ls.meshes.read(tmp_path / "box.ply") == BOX
    source = ls.magnetics.mesh(box, polarization=(0, 0, 1))
    ours = ls.magnetics.mesh(BOX, polarization=(0, 0, 1))
    at = [(0.3, 0.2, 0.1)]
    assert np.array_equal(ls.magnetics.field([source], at), ls.magnetics.field([ours], at))


def test_polygons_of_meshio_are_split_into_triangles(tmp_path):
    quads = meshio.Mesh(POINTS, [("quad", QUADS)])
    wanted = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]]
    mesh = ls.Cloth(mesh=quads).mesh
    assert np.array_equal(mesh.triangles, wanted) and not mesh.vertices[:, 2].any()
    meshio.write(tmp_path / "quads.vtk", meshio.Mesh(np.c_[POINTS, 0 * POINTS[:, 0]], quads.cells))
    assert np.array_equal(ls.meshes.read(tmp_path / "quads.vtk").triangles, wanted)
    dart = np.array([[2.0, 0, 0], [0.3, 0.3, 0], [0, 2, 0], [0, 0, 0]])
    concave = ls.Cloth(mesh=meshio.Mesh(dart, [("quad", [[0, 1, 2, 3]])])).mesh
    corners = concave.vertices[concave.triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (doubled > 0).all() and doubled.sum() == pytest.approx(1.2)


@pytest.mark.parametrize(
    "mesh, said",
    [
        (meshio.Mesh(POINTS, [("quad", [[0, 1, 3, 7]])]), "use the 6 points .* an index of 7"),
        (meshio.Mesh(POINTS, [("line", [[0, 1]])]), "flat triangles or polygons, got cells of no"),
        (
            meshio.Mesh(np.eye(4)[:, :3], [("tetra", [[0, 1, 2, 3]])]),
            "flat triangles or polygons, got cells of tetra; extract the surface first",
        ),
        (
            meshio.Mesh(POINTS, [("triangle6", [[0, 1, 2, 3, 4, 5]])]),
            "got cells of triangle6; extract the surface first",
        ),
        (
            meshio.Mesh(
                np.r_[POINTS, POINTS][:9],
                [("quad", [[0, 1, 2, 3]]), ("quad9", [list(range(8)) + [0]])],
            ),
            "got cells of quad, quad9; extract the surface first",
        ),
        (trimesh.Trimesh(POINTS @ np.eye(2, 3), [[0, 1, 1]], process=False), "triangle 0"),
        (
            trimesh.Scene({"a": BOXES["trimesh"], "b": BOXES["trimesh"]}),
            "one surface, got a trimesh.Scene of 'a', 'b'; give one of its meshes",
        ),
    ],
    ids=["out of range", "lines", "tetra", "curved", "curved beside flat", "degenerate", "scene"],
)
def test_a_mesh_of_another_package_that_is_no_surface_is_refused_in_one_sentence(mesh, said):
    for take in (lambda: ls.Cloth(mesh=mesh), lambda: ls.obstacles.mesh(mesh)):
        with pytest.raises(ls.InvalidInput, match=said):
            take()


def test_an_object_that_is_no_mesh_is_refused():
    with pytest.raises(TypeError, match="mesh must be a TriangleMesh, got the dict"):
        ls.Cloth(mesh={})
