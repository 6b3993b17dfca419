"""Texture coordinates are read from USD and glTF files, as from OBJ files."""

import loomstone as ls
import numpy as np
import pytest

FLOAT = 2.0**-24  # error of uv below 1 m in single precision; glTF stores 1 - v


def corner_uv(mesh):
    return mesh.uv[mesh.uv_triangles]


def curved_garment():
    """Returns a sheet that is bent to about a quarter of a cylinder, with a seam in uv."""
    flat = ls.grid(size=(0.3, 0.4), cells=(6, 8))
    x, y, _ = flat.vertices.T
    bent = np.column_stack([0.2 * np.sin(5 * x), y, 0.2 * np.cos(5 * x)])
    right = flat.vertices[flat.triangles][:, :, 0].mean(1) > 0.05
    uv = np.concatenate([flat.uv, flat.uv + (0.5, 0.1)])
    return ls.TriangleMesh(
        bent,
        flat.triangles,
        uv,
        uv_triangles=flat.triangles + flat.n_vertices * right[:, None],
    )


@pytest.mark.parametrize("suffix, package", [("glb", "pygltflib"), ("usdc", "pxr")])
def test_an_exported_garment_is_read_back_as_cloth(tmp_path, suffix, package):
    pytest.importorskip(package)
    garment = curved_garment()
    cloth = ls.Cloth(name="skirt", mesh=garment)
    sim = ls.Simulation(ls.Scene(cloths=[cloth]), threads=1)
    sim.run(out=tmp_path / "run", duration=0.02, rate=100)
    (path,) = ls.Run(tmp_path / "run").export(tmp_path / f"skirt.{suffix}")
    again = ls.meshes.read(path)
    assert np.array_equal(again.triangles, garment.triangles)
    assert again.vertices == pytest.approx(garment.vertices, abs=FLOAT) and not again.flat
    assert corner_uv(again) == pytest.approx(corner_uv(garment), abs=FLOAT)
    assert len(again.uv) == len(np.unique(garment.uv_triangles))  # the seam stays a seam
    ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=again)]), threads=1)
    assert len(ls.meshes.read(path, with_uv=False).uv) == 0
    assert len(ls.obstacles.baked(path).mesh.uv) == 0
    image = ls.Look(texture=np.zeros((2, 2, 3), np.uint8), texture_width=0.1)
    carried = ls.obstacles.baked(path, look=image).mesh
    assert corner_uv(carried) == pytest.approx(corner_uv(garment), abs=FLOAT)


QUADS = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
POINTS = np.array([[x, y, 0.0] for y in (0, 1) for x in (0, 1, 2)])
UV = POINTS[:, :2] * 0.25 + (0.1, 0.2)


def write_usd(path, interpolation, values, indices=None, left=False):
    """Writes a mesh of two quads with texture coordinates. Its points are in centimetres. Returns
    the path.
    """
    pytest.importorskip("pxr")
    from pxr import Sdf, Usd, UsdGeom, Vt

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    mesh = UsdGeom.Mesh.Define(stage, "/root/sheet")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(POINTS.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr(QUADS.reshape(-1).tolist())
    if left:
        mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation
    )
    primvar.Set(Vt.Vec2fArray.FromNumpy(np.asarray(values, np.float32)))
    if indices is not None:
        primvar.SetIndices(Vt.IntArray.FromNumpy(np.asarray(indices, np.int32)))
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(
    "interpolation, values, indices",
    [
        ("vertex", UV, None),
        ("varying", UV, None),
        ("vertex", UV[::-1], [5, 4, 3, 2, 1, 0]),
        ("faceVarying", UV[QUADS.reshape(-1)], None),
        ("faceVarying", UV, QUADS.reshape(-1)),
    ],
)
def test_usd_has_uv_of_vertices_or_corners(tmp_path, interpolation, values, indices, left):
    path = write_usd(tmp_path / "sheet.usda", interpolation, values, indices, left)
    mesh = ls.meshes.read(path)
    assert mesh.n_triangles == 4 and len(mesh.uv) == 6
    wanted = 100 * mesh.vertices[mesh.triangles][:, :, :2] * 0.25 + (0.1, 0.2)
    assert corner_uv(mesh) == pytest.approx(wanted, abs=1e-6)


def test_usd_keeps_seams_between_quads(tmp_path):
    values = np.concatenate([UV[QUADS[0]], UV[QUADS[1]] + (3.0, 0.0)])
    mesh = ls.meshes.read(write_usd(tmp_path / "sheet.usda", "faceVarying", values))
    assert mesh.n_vertices == 6 and len(mesh.uv) == 8
    right = mesh.vertices[mesh.triangles][:, :, 0].mean(1) > 0.01
    assert (corner_uv(mesh)[:, :, 0] > 2.0).all(1).tolist() == right.tolist()


def test_usd_with_one_uv_for_a_whole_mesh_has_none(tmp_path):
    assert len(ls.meshes.read(write_usd(tmp_path / "sheet.usda", "constant", UV[:1])).uv) == 0


def test_uv_of_usd_that_do_not_match_are_one_sentence(tmp_path):
    for interpolation, count in (("vertex", 6), ("faceVarying", 8)):
        path = write_usd(tmp_path / f"{interpolation}.usda", interpolation, UV[:5])
        said = f"/root/sheet: primvars:st must have {count} rows .* '{interpolation}', got 5 x 2"
        with pytest.raises(ls.InvalidInput, match=said):
            ls.meshes.read(path)
        assert ls.meshes.read(path, with_uv=False).n_triangles == 4
    path = write_usd(tmp_path / "flat.usda", "vertex", 0 * UV)
    with pytest.raises(ls.InvalidInput, match="zero rest area in uv .*with_uv=False"):
        ls.meshes.read(path)


def write_gltf(path, uv_counts=(12,)):
    """Writes two nodes, a plain and a mirrored one, and returns the path.

    Each number in `uv_counts` is the number of uv of one mesh (0: none). If there is only one mesh,
    both nodes show it. A mesh has four triangles, each with vertices of its own and uv whose
    integer part is the number of the triangle.
    """
    g = pytest.importorskip("pygltflib")
    corners = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]]).reshape(-1)
    uv = np.tile([[0.1, 0.1], [0.3, 0.1], [0.3, 0.3]], (4, 1)) + np.repeat(np.arange(4), 3)[:, None]
    made, content = g.GLTF2(), bytearray()

    def array(values, kind):
        made.bufferViews.append(
            g.BufferView(buffer=0, byteOffset=len(content), byteLength=values.nbytes)
        )
        content.extend(values.tobytes())
        view = len(made.bufferViews) - 1
        made.accessors.append(
            g.Accessor(bufferView=view, componentType=5126, count=len(values), type=kind)
        )
        return len(made.accessors) - 1

    for count in uv_counts:
        attributes = g.Attributes(POSITION=array(POINTS[corners].astype(np.float32), "VEC3"))
        if count:
            stored = np.column_stack([uv[:, 0], 1.0 - uv[:, 1]])[:count]
            attributes.TEXCOORD_0 = array(stored.astype(np.float32), "VEC2")
        made.meshes.append(g.Mesh(primitives=[g.Primitive(attributes=attributes)]))
    made.nodes = [
        g.Node(name="plain", mesh=0, translation=[0.0, 0.0, 3.0]),
        g.Node(name="mirrored", mesh=len(uv_counts) - 1, scale=[-1.0, 1.0, 1.0]),
    ]
    made.scenes, made.scene = [g.Scene(nodes=[0, 1])], 0
    made.buffers = [g.Buffer(byteLength=len(content))]
    made.set_binary_blob(bytes(content))
    made.save_binary(str(path))
    return path


def test_gltf_keeps_uv_at_the_corners_of_instances_and_mirrored_nodes(tmp_path):
    mesh = ls.meshes.read(write_gltf(tmp_path / "sheets.glb"))
    assert mesh.n_vertices == 12 and mesh.n_triangles == 8
    corners = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
    for triangle, uv in zip(mesh.triangles, corner_uv(mesh), strict=True):
        number = int(uv[0, 0])
        place = mesh.vertices[triangle]
        place = np.column_stack([place[:, 0], place[:, 2]])  # y up becomes z up
        wanted = POINTS[corners[number], :2] * (1.0 if place[:, 0].max() > 0 else -1.0, 1.0)
        order = [int(np.abs(uv - number - at).sum(1).argmin())
                 for at in ([0.1, 0.1], [0.3, 0.1], [0.3, 0.3])]  # fmt: skip
        assert sorted(order) == [0, 1, 2] and place[order] == pytest.approx(wanted, abs=1e-6)


def test_uv_of_gltf_that_do_not_match_are_one_sentence(tmp_path):
    for counts, said in (
        ((12, 0), "either all meshes must have texture coordinates or none, but '/mirrored' has"),
        ((9,), "the texture coordinates of 'plain' must be 12 x 2 numbers, got 9 x 2"),
    ):
        path = write_gltf(tmp_path / "sheets.glb", counts)
        with pytest.raises(ls.InvalidInput, match=said):
            ls.meshes.read(path)
        assert ls.meshes.read(path, with_uv=False).n_triangles == 8


def test_a_skin_of_gltf_keeps_the_uv_of_its_corners(tmp_path):
    from test_baked import RINGS, TRIANGLES, z_up
    from test_baked import write_gltf as write_tube

    uv = np.tile([[0.1, 0.1], [0.3, 0.1], [0.3, 0.3]], (len(TRIANGLES), 1))
    uv += np.repeat(np.arange(len(TRIANGLES)), 3)[:, None]
    stored = np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]).astype(np.float32)

    def add_uv(made):
        import base64

        import pygltflib as g

        data = base64.b64encode(stored.tobytes()).decode()
        made.buffers.append(g.Buffer(uri=f"{g.DATA_URI_HEADER}{data}", byteLength=stored.nbytes))
        made.bufferViews.append(g.BufferView(buffer=1, byteOffset=0, byteLength=stored.nbytes))
        view = len(made.bufferViews) - 1
        made.accessors.append(
            g.Accessor(bufferView=view, componentType=5126, count=len(stored), type="VEC2")
        )
        made.meshes[0].primitives[0].attributes.TEXCOORD_0 = len(made.accessors) - 1

    path = write_tube(tmp_path / "tube.glb", add_uv)
    look = ls.Look(texture=np.zeros((2, 2, 3), np.uint8))
    mesh = ls.obstacles.baked(path, rate=2.0, look=look).mesh
    assert mesh.n_vertices == 12
    for triangle, found in zip(mesh.triangles, corner_uv(mesh), strict=True):
        number = int(found[0, 0])
        assert found == pytest.approx(uv.reshape(-1, 3, 2)[number], abs=1e-5)
        wanted = z_up(RINGS[TRIANGLES[number]])
        assert mesh.vertices[triangle] == pytest.approx(wanted, abs=1e-6)
