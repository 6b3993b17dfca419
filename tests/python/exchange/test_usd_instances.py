"""Instances of a PointInstancer are read as meshes. A warning names shapes that are not meshes."""

import warnings

import loomstone as ls
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from usd_stages import define_mesh, new_stage

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], float)  # of a tetrahedron
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
TURNS = Rotation.from_rotvec([[0, 0, 0.3], [0.4, 0, 0], [0, 1.0, 0], [0.2, 0.3, 0.4]])
SCALES = np.array([[1, 1, 1], [2, 1, 1], [1, 1, 3], [1, -1, 1]], float)
PLACES = np.array([[10, 0, 0], [0, 10, 0], [0, 0, 10], [-10, 0, 0]], float)


def mesh_at(stage, path, points=POINTS):
    return define_mesh(stage, path, points, FACES)


def write(path, prototypes=("/many/small", "/many/large"), change=lambda *_: None):
    """Writes an instancer at x = 100 with four instances of two tetrahedra, and a third mesh.
    Returns the path.
    """
    stage = new_stage(path)
    stage.SetTimeCodesPerSecond(1.0)
    from pxr import Gf, UsdGeom

    many = UsdGeom.PointInstancer.Define(stage, "/many")
    UsdGeom.Xformable(many).AddTranslateOp().Set(Gf.Vec3d(100, 0, 0))
    mesh_at(stage, f"{prototypes[0]}/mesh")
    UsdGeom.Xformable(mesh_at(stage, prototypes[1], 2 * POINTS)).AddTranslateOp().Set(
        Gf.Vec3d(0, 0, 1)
    )
    many.CreatePrototypesRel().SetTargets(list(prototypes))
    many.CreateProtoIndicesAttr([0, 1, 0, 1])
    many.CreatePositionsAttr([Gf.Vec3f(*map(float, place)) for place in PLACES])
    many.CreateScalesAttr([Gf.Vec3f(*map(float, scale)) for scale in SCALES])
    many.CreateOrientationsAttr(
        [Gf.Quath(float(w), float(x), float(y), float(z)) for x, y, z, w in TURNS.as_quat()]
    )
    mesh_at(stage, "/alone", POINTS + (0, 0, 50))
    change(stage, many)
    stage.GetRootLayer().Save()
    return path


def wanted(numbers=range(4)):
    """Returns the points, in space, of the instances with these numbers and of the third mesh."""
    found = []
    for k in numbers:
        local = 2 * POINTS + (0, 0, 1) if k % 2 else POINTS
        found.append(TURNS[k].apply(SCALES[k] * local) + PLACES[k] + (100, 0, 0))
    return np.concatenate([*found, POINTS + (0, 0, 50)])


def check(mesh, points):
    """Checks that a mesh has these vertices, up to their order, and faces outward."""
    assert mesh.n_vertices == len(points) and mesh.n_triangles == len(points)
    distance = np.linalg.norm(mesh.vertices[:, None] - points[None], axis=2)
    # Orientations have half precision. This displaces points in proportion to their distance from
    # the origin of their instance, which is at most 9 m.
    assert distance.min(1).max() < 0.01 and distance.min(0).max() < 0.01
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    piece = distance.argmin(1)[mesh.triangles[:, 0]] // 4
    for number in range(len(points) // 4):
        mine = piece == number
        shift = points[4 * number]
        volume = np.einsum("ij,ij->i", a - shift, np.cross(b - shift, c - shift))[mine].sum()
        assert volume > 0.0


@pytest.mark.parametrize(
    "prototypes", [("/many/small", "/many/large"), ("/kept/small", "/kept/large")]
)
def test_instances_have_places_turns_and_scales(tmp_path, prototypes):
    path = write(tmp_path / "many.usda", prototypes)
    check(ls.meshes.read(path), wanted())
    check(ls.meshes.read(write(tmp_path / "out.usda", prototypes, hidden)), wanted([0, 3]))


def hidden(stage, many):
    many.CreateInvisibleIdsAttr([2])
    many.DeactivateId(1)


def test_places_of_instances_are_those_of_usd(tmp_path):
    path = write(tmp_path / "many.usda")
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    many = UsdGeom.PointInstancer(stage.GetPrimAtPath("/many"))
    matrices = np.array(many.ComputeInstanceTransformsAtTime(0.0, 0.0))
    mesh = ls.meshes.read(path)
    for k in (0, 1, 2, 3):
        points = (2 if k % 2 else 1) * POINTS
        there = points @ matrices[k][:3, :3] + matrices[k][3, :3] + (100, 0, 0)
        distance = np.linalg.norm(mesh.vertices[:, None] - there[None], axis=2)
        assert distance.min(0).max() < 1e-5  # single precision of 100 m


@pytest.mark.parametrize("kind", ["SpecifierDef", "SpecifierOver", "SpecifierClass"])
@pytest.mark.parametrize("leaf", ["/many/small/inner/leaf", "/many/small/leaf"])
def test_instances_in_instances_are_read(tmp_path, kind, leaf):
    from_usd = pytest.importorskip("pxr.UsdGeom")
    from pxr import Sdf

    def nested(stage, many):
        inner = from_usd.PointInstancer.Define(stage, "/many/small/inner")
        mesh_at(stage, leaf)
        stage.GetPrimAtPath("/many/small").SetSpecifier(getattr(Sdf, kind))
        inner.CreatePrototypesRel().SetTargets([leaf])
        inner.CreateProtoIndicesAttr([0, 0])
        inner.CreatePositionsAttr([(0, 0, 5), (0, 0, -5)])
        stage.RemovePrim("/many/small/mesh")
        many.GetProtoIndicesAttr().Set([0, 1, 1, 1])
        many.CreateInvisibleIdsAttr([1, 2, 3])

    path = write(tmp_path / "many.usda", change=nested)
    inner = [TURNS[0].apply(POINTS + (0, 0, z)) + PLACES[0] + (100, 0, 0) for z in (5, -5)]
    check(ls.meshes.read(path), np.concatenate([*inner, POINTS + (0, 0, 50)]))


def test_moving_instances_are_sampled(tmp_path):
    def move(stage, many):
        many.GetPositionsAttr().Set([tuple(map(float, p)) for p in PLACES], 0.0)
        many.GetPositionsAttr().Set([tuple(map(float, p + (0, 4, 0))) for p in PLACES], 1.0)

    path = write(tmp_path / "many.usda", change=move)
    baked = ls.obstacles.baked(path, rate=2.0, parts=["/many/large"])
    frames = baked.vertex_positions.reshape(3, 8, 3)
    assert frames[1] - frames[0] == pytest.approx(np.tile([0, 2.0, 0], (8, 1)), abs=1e-5)
    assert frames[2] - frames[0] == pytest.approx(np.tile([0, 4.0, 0], (8, 1)), abs=1e-5)


def vanishing(stage, many):
    many.CreateInvisibleIdsAttr().Set([], 0.0)
    many.GetInvisibleIdsAttr().Set([1], 1.0)


def appearing(_, many):
    many.CreateInvisibleIdsAttr().Set([1, 3], 0.0)
    many.GetInvisibleIdsAttr().Set([], 1.0)


@pytest.mark.parametrize(
    "change, said",
    [
        (appearing, "/many: must keep its instances, but they change at time code 1"),
        (vanishing, "/many: must keep its instances, but they change at time code 1"),
        (lambda _, many: many.GetProtoIndicesAttr().Set([0, 2]), "protoIndices must be 0 to 1"),
        (lambda _, many: many.GetProtoIndicesAttr().Set([0, 1]), "a position for each of its 2"),
    ],
)
def test_what_is_wrong_with_instances_is_one_sentence(tmp_path, change, said):
    path = write(tmp_path / "many.usda", change=change)
    with pytest.raises(ls.InvalidInput, match=f"many.usda: .*{said}"):
        ls.obstacles.baked(path)


def test_visible_shapes_that_are_not_meshes_are_named(tmp_path):
    from_usd = pytest.importorskip("pxr.UsdGeom")

    def shapes(stage, many):
        from_usd.Sphere.Define(stage, "/ball")
        from_usd.Cube.Define(stage, "/many/small/box")
        from_usd.Cube.Define(stage, "/hidden").CreateVisibilityAttr("invisible")
        from_usd.Camera.Define(stage, "/camera")

    path = write(tmp_path / "many.usda", change=shapes)
    said = r"many.usda: only meshes are read, so 2 .*: /many/small/box \(Cube\), /ball \(Sphere\);"
    with pytest.warns(ls.SceneWarning, match=said):
        check(ls.meshes.read(path), wanted())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ls.meshes.read(write(tmp_path / "plain.usda"))
