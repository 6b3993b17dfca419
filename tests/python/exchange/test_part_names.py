"""Meshes of the same name in USD and glTF files are told apart by their paths."""

import loomstone as ls
import numpy as np
import pytest
from usd_stages import define_mesh, new_stage

SIZES = {"/a/mesh": 0.1, "/b/mesh": 0.2, "/wall": 0.3}  # lengths of the edges of three boxes [m]


def write_usd(path):
    stage = new_stage(path)
    from pxr import Gf, UsdGeom

    for name, size in SIZES.items():
        box = ls.meshes.box(size=(size, size, size))
        mesh = define_mesh(stage, name, box.vertices, box.triangles)
        move = UsdGeom.Xformable(mesh).AddTranslateOp()
        for code in (0, 1):
            move.Set(Gf.Vec3d(code, 0, 0), code)
    stage.GetRootLayer().Save()
    return path


def write_gltf(path):
    g = pytest.importorskip("pygltflib")
    times = np.array([0, 1], np.float32)
    shifts = np.array([[0, 0, 0], [1, 0, 0]], np.float32)
    made, content = g.GLTF2(), bytearray()

    def array(values, kind, component=5126):
        made.bufferViews.append(
            g.BufferView(buffer=0, byteOffset=len(content), byteLength=values.nbytes)
        )
        content.extend(values.tobytes())
        made.accessors.append(
            g.Accessor(
                bufferView=len(made.bufferViews) - 1,
                componentType=component,
                count=len(values),
                type=kind,
            )
        )
        return len(made.accessors) - 1

    made.nodes = [g.Node(name="a", children=[2]), g.Node(name="b", children=[3])]
    made.animations = [g.Animation(samplers=[], channels=[])]
    sampler = g.AnimationSampler(input=array(times, "SCALAR"), output=array(shifts, "VEC3"))
    made.animations[0].samplers.append(sampler)
    for number, (name, size) in enumerate(SIZES.items()):
        box = ls.meshes.box(size=(size, size, size))
        primitive = g.Primitive(
            attributes=g.Attributes(POSITION=array(box.vertices.astype(np.float32), "VEC3")),
            indices=array(box.triangles.reshape(-1).astype(np.uint32), "SCALAR", 5125),
        )
        made.meshes.append(g.Mesh(primitives=[primitive]))
        made.nodes.append(g.Node(name=name.rsplit("/", 1)[1], mesh=number))
        target = g.AnimationChannelTarget(node=2 + number, path="translation")
        made.animations[0].channels.append(g.AnimationChannel(sampler=0, target=target))
    made.scenes, made.scene = [g.Scene(nodes=[0, 1, 4])], 0
    made.buffers = [g.Buffer(byteLength=len(content))]
    made.set_binary_blob(bytes(content))
    made.save_binary(str(path))
    return path


@pytest.mark.parametrize("write, suffix", [(write_usd, "usda"), (write_gltf, "glb")])
def test_meshes_of_the_same_name_are_chosen_by_path(tmp_path, write, suffix):
    path = write(tmp_path / f"boxes.{suffix}")
    for names, sizes in (
        (["/b/mesh"], [0.2]),
        (["a/mesh"], [0.1]),
        (["wall"], [0.3]),
        (["/wall", "b/mesh"], [0.2, 0.3]),
        (None, [0.1, 0.2, 0.3]),
    ):
        mesh = ls.obstacles.baked(path, rate=1.0, parts=names).mesh
        found = np.unique(np.round(2 * np.abs(mesh.vertices), 6))
        assert found.tolist() == sizes and mesh.n_vertices == 8 * len(sizes)
    said = "2 have the name 'mesh'; name them by their paths, '/a/mesh', '/b/mesh'"
    with pytest.raises(ls.InvalidInput, match=said):
        ls.obstacles.baked(path, parts=["mesh"])
    said = "parts must be names of its meshes, .*'/a/mesh', '/b/mesh'.*, got '/c/mesh'"
    with pytest.raises(ls.InvalidInput, match=said):
        ls.obstacles.baked(path, parts=["/c/mesh"])


def test_a_surface_may_have_the_name_of_the_scope_of_materials(hanging, tmp_path):
    pxr = pytest.importorskip("pxr.UsdGeom")
    cloth = ls.Cloth(name="materials", mesh=hanging.cloths[0].mesh, pins=[0])
    ls.Simulation(ls.Scene(cloths=[cloth]), threads=1).run(out=tmp_path / "run", duration=0.04)
    from pxr import Usd, UsdShade

    stage = Usd.Stage.Open(str(ls.Run(tmp_path / "run").export(tmp_path / "run.usdc")[0]))
    mesh = pxr.Mesh(stage.GetPrimAtPath("/run/materials"))
    assert mesh and len(mesh.GetFaceVertexCountsAttr().Get()) == 128
    material, _ = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()
    assert material.GetPath() == "/run/materials_/materials_0"
