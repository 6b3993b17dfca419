"""Obstacles and meshes are read from USD and glTF files. Other libraries write most of them."""

import json

import loomstone as ls
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from usd_stages import define_mesh, new_stage

# A square tube along y with rings at y = 0, 1 and 2. The lower ring follows the first joint, the
# upper one the second joint, and the middle one both.
RINGS = np.array(
    [[x, y, z] for y in (0.0, 1.0, 2.0) for x, z in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
)
RINGS[:, [0, 2]] *= 0.2
QUADS = np.array([[4 * r + k, 4 * r + (k + 1) % 4, 4 * r + 4 + (k + 1) % 4, 4 * r + 4 + k]
                  for r in (0, 1) for k in range(4)])  # fmt: skip
TRIANGLES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
SHARES = np.repeat([[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]], 4, 0)
TIMES = np.array([0.0, 0.5, 1.0])
ANGLES = np.array([0.0, 0.3, 0.9])  # turns [rad] of the second joint (at y = 1) about z at TIMES


def bent(angle):
    """Returns the vertices of the tube after linear blend skinning, with y up."""
    hinge = np.array([0.0, 1.0, 0.0])
    turned = Rotation.from_rotvec([0, 0, angle]).apply(RINGS - hinge) + hinge
    return SHARES[:, :1] * RINGS + SHARES[:, 1:] * turned


def z_up(points):
    return np.column_stack([points[:, 0], -points[:, 2], points[:, 1]])


@pytest.fixture
def gltf(tmp_path):
    """Path of a glTF file: an animated skinned tube with three vertices for each triangle."""
    return write_gltf(tmp_path / "tube.glb")


def write_gltf(path, change=lambda _: None):
    g = pytest.importorskip("pygltflib")
    made, content = g.GLTF2(), bytearray()

    def array(values, kind, component):
        values = np.ascontiguousarray(values)
        made.bufferViews.append(
            g.BufferView(buffer=0, byteOffset=len(content), byteLength=values.nbytes)
        )
        content.extend(values.tobytes() + b"\0" * (-values.nbytes % 4))
        count = values.size // {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        made.accessors.append(
            g.Accessor(
                bufferView=len(made.bufferViews) - 1,
                componentType=component,
                count=count,
                type=kind,
            )
        )
        return len(made.accessors) - 1

    corners = TRIANGLES.reshape(-1)
    shares = np.zeros((len(corners), 4), np.uint8)
    shares[:, :2] = np.round(255 * SHARES[corners])  # 127.5 is rounded to 128
    joints = np.tile(np.array([0, 1, 0, 0], np.uint8), (len(corners), 1))
    primitive = g.Primitive(
        attributes=g.Attributes(
            POSITION=array(RINGS[corners].astype(np.float32), "VEC3", 5126),
            JOINTS_0=array(joints, "VEC4", 5121),
            WEIGHTS_0=array(shares, "VEC4", 5121),
        )
    )
    made.accessors[-1].normalized = True
    inverse = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
    inverse[1, 3, 1] = -1.0  # the matrix is stored by columns, and moves the hinge to the origin
    turns = Rotation.from_rotvec(np.outer(ANGLES, [0, 0, 1])).as_quat().astype(np.float32)
    made.meshes = [g.Mesh(primitives=[primitive])]
    made.nodes = [
        g.Node(name="Tube", mesh=0, skin=0),
        g.Node(name="hip", children=[2]),
        g.Node(name="knee", translation=[0.0, 1.0, 0.0]),
    ]
    made.skins = [g.Skin(joints=[1, 2], inverseBindMatrices=array(inverse, "MAT4", 5126))]
    sampler = g.AnimationSampler(
        input=array((TIMES + 1 / 24).astype(np.float32), "SCALAR", 5126),
        output=array(turns, "VEC4", 5126),
    )
    target = g.AnimationChannelTarget(node=2, path="rotation")
    channel = g.AnimationChannel(sampler=0, target=target)
    made.animations = [g.Animation(name="Bend", samplers=[sampler], channels=[channel])]
    made.scenes, made.scene = [g.Scene(nodes=[0, 1])], 0
    made.buffers = [g.Buffer(byteLength=len(content))]
    change(made)
    made.set_binary_blob(bytes(content))
    made.save_binary(str(path))
    return path


def test_a_skin_of_gltf_is_baked_to_vertices(gltf):
    tube = ls.obstacles.baked(gltf, rate=2.0, start=0.25, friction=0.7)
    assert tube.name == "tube" and tube.friction == 0.7
    assert tube.times == pytest.approx([0.25, 0.75, 1.25])
    assert tube.mesh.n_vertices == 12 and tube.mesh.n_triangles == 16  # equal vertices are joined
    frames = tube.vertex_positions.reshape(3, 12, 3)
    for angle, frame in zip(ANGLES, frames, strict=True):
        wanted = z_up(bent(angle))
        # The tolerance allows for rotations in single precision. The reader scales two weights of
        # 128 to 1/2 each.
        distance = np.linalg.norm(frame[:, None] - wanted[None], axis=2).min(1)
        assert distance.max() < 1e-6 and len(np.unique(np.round(frame, 4), axis=0)) == 12
    between = ls.obstacles.baked(gltf, rate=4.0).vertex_positions.reshape(5, 12, 3)[1]
    distance = np.linalg.norm(between[:, None] - z_up(bent(0.15))[None], axis=2).min(1)
    assert distance.max() < 1e-6  # spherical interpolation of rotations
    assert len(ls.obstacles.baked(gltf).times) == 61  # by default, 60 samples per second


def test_the_mesh_of_gltf_at_rest_is_read_with_z_up(gltf):
    mesh = ls.meshes.read(gltf)
    assert sorted(map(tuple, np.round(mesh.vertices, 6))) == sorted(
        map(tuple, np.round(z_up(RINGS), 6) + 0.0)
    )


def write_usd(path, change=lambda *_: None):
    """Writes a file in centimetres with y up: a skinned tube of quads, whose parent moves, and a
    static box. Returns the path.
    """
    stage = new_stage(path, up="Y", metres=0.01, codes=(1.0, 3.0))
    stage.SetTimeCodesPerSecond(2.0)
    from pxr import Gf, Sdf, UsdGeom, UsdSkel, Vt

    root = UsdSkel.Root.Define(stage, "/root")
    shift = UsdGeom.Xformable(root).AddTranslateOp()
    for code in (1, 2, 3):
        shift.Set(Gf.Vec3d(10.0 * (code - 1), 0, 0), code)
    mesh = define_mesh(stage, "/root/Tube", 100.0 * RINGS, QUADS.reshape(-1, 4))
    skeleton = UsdSkel.Skeleton.Define(stage, "/root/bones")
    skeleton.CreateJointsAttr(["hip", "hip/knee"])
    knee = Gf.Matrix4d().SetTranslate(Gf.Vec3d(0, 100, 0))
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1), knee])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1), knee])
    motion = UsdSkel.Animation.Define(stage, "/root/bones/bend")
    motion.CreateJointsAttr(["hip", "hip/knee"])
    for code, angle in enumerate(ANGLES, 1):
        motion.CreateTranslationsAttr().Set([Gf.Vec3f(0), Gf.Vec3f(0, 100, 0)], code)
        turn = Gf.Quatf(float(np.cos(angle / 2)), 0.0, 0.0, float(np.sin(angle / 2)))
        motion.CreateRotationsAttr().Set([Gf.Quatf(1), turn], code)
        motion.CreateScalesAttr().Set([Gf.Vec3h(1), Gf.Vec3h(1)], code)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(
        [motion.GetPath()]
    )
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([Sdf.Path("/root/bones")])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * 12)
    binding.CreateJointWeightsPrimvar(False, 2).Set(SHARES.reshape(-1).tolist())
    still = UsdGeom.Mesh.Define(stage, "/Wall")
    wall = ls.meshes.box(size=(1, 1, 1)).moved((0, 500, 0))
    still.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(wall.vertices.astype(np.float32)))
    still.CreateFaceVertexCountsAttr([3] * wall.n_triangles)
    still.CreateFaceVertexIndicesAttr(wall.triangles.reshape(-1).tolist())
    change(stage, mesh)
    stage.GetRootLayer().Save()
    return path


def test_a_skin_of_usd_is_baked_to_vertices_in_metres_with_z_up(tmp_path):
    path = write_usd(tmp_path / "tube.usda")
    content = path.read_bytes()
    tube = ls.obstacles.baked(path, parts=["Tube"], name="arm")
    assert tube.name == "arm" and tube.times == pytest.approx(TIMES)
    frames = tube.vertex_positions.reshape(3, 12, 3)
    for index, (angle, frame) in enumerate(zip(ANGLES, frames, strict=True)):
        # The tolerance allows for single precision of the tube's points, which reach 2 m.
        assert frame == pytest.approx(z_up(bent(angle) + (0.1 * index, 0, 0)), abs=1e-6)
    assert path.read_bytes() == content  # the file is not changed
    assert len(ls.obstacles.baked(path, rate=4.0).times) == 5
    assert ls.obstacles.baked(path).mesh.n_vertices == 12 + 8
    assert ls.meshes.read(path).vertices[:12] == pytest.approx(z_up(RINGS), abs=1e-6)


@pytest.mark.parametrize("suffix", ["glb", "usdc"])
def test_boxes_that_touch_along_edges_are_read_from_an_export(tmp_path, suffix):
    boxes = [
        ls.obstacles.box(size=(0.1, 0.1, 0.1), centre=(0.1 * i, 0.0, 0.1 * i), name=f"box {i}")
        for i in range(2)
    ]
    cloth = ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(2, 2)).moved((0.0, 0.0, 0.3)))
    run = tmp_path / "run"
    scene = ls.Scene(cloths=[cloth], obstacles=boxes)
    ls.Simulation(scene, threads=1).run(out=run, duration=0.04)
    (path,) = ls.Run(run).export(tmp_path / f"boxes.{suffix}")
    whole = ls.meshes.read(path, with_uv=False)
    assert whole.n_triangles == 8 + 2 * 12 and whole.n_vertices == 9 + 2 * 8


def test_cloth_is_carried_by_a_baked_obstacle(tmp_path):
    path = write_usd(tmp_path / "tube.usdc")
    cloth = ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(3, 3)).moved((0.1, 0, 2.01)))
    tube = ls.obstacles.baked(path, parts=["Tube"], friction=1.0)
    sim = ls.Simulation(ls.Scene(cloths=[cloth], obstacles=[tube]), threads=1)
    *_, last = sim.frames(duration=0.2)
    assert last.body_vertices == pytest.approx(
        0.6 * tube.vertex_positions[:12] + 0.4 * tube.vertex_positions[12:24], abs=1e-9
    )


def no_skin(made):
    made.nodes[0].skin = 3


def no_joint(made):
    made.skins[0].joints = [1]


def compressed(made):
    made.extensionsRequired = ["KHR_draco_mesh_compression"]


def two_animations(made):
    again = made.animations[0]
    made.animations.append(
        type(again)(name="Wave", samplers=again.samplers, channels=again.channels)
    )


def lines(made):
    made.meshes[0].primitives[0].mode = 1


def one_key(made):
    for sampler in made.animations[0].samplers:
        made.accessors[sampler.input].count = made.accessors[sampler.output].count = 1


def cycle(made):
    made.nodes[2].children = [1]


def matrix(made):
    moved = made.nodes[made.animations[0].channels[0].target.node]
    moved.matrix = [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0, 0, 1.0, 0, 1.0]
    moved.translation = None


@pytest.mark.parametrize(
    "change, settings, said",
    [
        (no_skin, {}, r"'Tube' refers to skins\[3\], but the file has only 1"),
        (no_joint, {}, "uses joint 1, but its skin has only 1"),
        (compressed, {}, "requires KHR_draco_mesh_compression, which is not supported"),
        (two_animations, {}, "has several animations, 'Bend', 'Wave'; give animation="),
        (two_animations, {"animation": ["Bend", "x"]}, "one of 'Bend', 'Wave', got 'x'"),
        (lines, {}, "'Tube' must consist of triangles, got points or lines"),
        (one_key, {}, "the animation must last longer than 0 s, got one keyframe"),
        (cycle, {}, "a node must have one parent, got several or a cycle"),
        (matrix, {}, "node 2 must not have a matrix, because an animation changes its rotation"),
        (
            lambda made: made.animations.clear(),
            {},
            "has no animation; use loomstone.obstacles.mesh",
        ),
        (lambda made: made.meshes.clear(), {}, r"refers to meshes\[0\], but the file has only 0"),
        (lambda made: setattr(made.skins[0], "joints", []), {}, "but its skin has only 0"),
        (lambda made: made.scenes.clear(), {}, "must hold a mesh, but holds none"),
        (lambda _: None, {"animation": "Run"}, "animation must be one of 'Bend', got 'Run'"),
        (
            lambda _: None,
            {"parts": ["Leg"]},
            "parts must be names of its meshes, 'Tube', got 'Leg'",
        ),
        (lambda _: None, {"parts": []}, "parts must name a mesh, one of 'Tube'"),
        (lambda _: None, {"parts": "Tube"}, "parts must be a list of names, got 'Tube'"),
        (lambda _: None, {"rate": -1.0}, "rate must be > 0"),
    ],
)
def test_what_is_wrong_with_gltf_is_one_sentence(tmp_path, change, settings, said):
    path = write_gltf(tmp_path / "tube.glb", change)
    with pytest.raises((ls.InvalidInput, ls.Unsupported), match=said):
        ls.obstacles.baked(path, **settings)


def test_a_truncated_or_foreign_gltf_is_one_sentence(gltf, tmp_path):
    content = gltf.read_bytes()
    for size in (0, 3, 12, 18, 40, 400, len(content) // 2, len(content) - 40):
        (tmp_path / "cut.glb").write_bytes(content[:size])
        with pytest.raises(ls.CacheError, match="cut.glb: .*") as told:
            ls.obstacles.baked(tmp_path / "cut.glb")
        assert "\n" not in str(told.value)
    for text in ("", "{}", "[]", json.dumps({"asset": {"version": "2.0"}, "nodes": [{"mesh": 7}]})):
        (tmp_path / "odd.gltf").write_text(text)
        with pytest.raises((ls.CacheError, ls.InvalidInput), match="odd.gltf: "):
            ls.obstacles.baked(tmp_path / "odd.gltf")


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda made: made.nodes.append(None), r"nodes\[3\] must be an object, got nothing"),
        (lambda made: made.scenes.append(None), r"scenes\[1\] must be an object, got nothing"),
        (lambda made: setattr(made.accessors[0], "count", True), "a whole number, got True"),
        (
            lambda made: setattr(made.meshes[0].primitives[0].attributes, "POSITION", "x"),
            r"attributes.POSITION must be a whole number, got 'x'",
        ),
    ],
)
def test_values_of_gltf_of_a_wrong_type_are_one_sentence(tmp_path, change, said):
    path = write_gltf(tmp_path / "odd.glb", change)
    with pytest.raises(ls.CacheError, match=f"odd.glb: is malformed, .*{said}"):
        ls.obstacles.baked(path)


def unbound(stage, mesh):
    from pxr import UsdSkel

    UsdSkel.BindingAPI(mesh.GetPrim()).GetSkeletonRel().SetTargets(["/root/none"])


def no_bone(_, mesh):
    from pxr import UsdSkel

    UsdSkel.BindingAPI(mesh.GetPrim()).GetJointIndicesPrimvar().Set([0, 5] * 12)


def no_poses(stage, _):
    from pxr import Gf, UsdSkel

    bones = UsdSkel.Skeleton(stage.GetPrimAtPath("/root/bones"))
    bones.GetRestTransformsAttr().Set([Gf.Matrix4d(1)])


def many_codes(stage, _):
    stage.SetEndTimeCode(1e9 + 1.0)


def still(stage, _):
    stage.RemovePrim("/root")


def static(stage, _):
    stage.ClearMetadata("startTimeCode")
    stage.ClearMetadata("endTimeCode")


def fewer_points(stage, mesh):
    mesh.GetPointsAttr().Set([(0, 0, 0)] * 3)


def more_points(stage, _):
    points = stage.GetPrimAtPath("/Wall").GetAttribute("points")
    points.Set(points.Get(), 1.0)
    points.Set([(0, 0, 0)] * 9, 2.0)


@pytest.mark.parametrize(
    "change, settings, said",
    [
        (unbound, {}, "/root/Tube is bound to /root/none, which is not a skeleton"),
        (no_bone, {}, "/root/Tube uses joint 5, but its skeleton has 2 joints"),
        (no_poses, {}, "its skeleton must have 2 poses, one per joint, got 1"),
        (many_codes, {}, "must have at most 100000 samples, but 5e.08 s at 2 per second have more"),
        (still, {}, "must move, but is at rest in all 3 samples; use loomstone.obstacles.mesh"),
        (static, {}, r"has no animation \(no range of time codes\); use"),
        (fewer_points, {}, "each corner must be one of its 3 points"),
        (more_points, {}, "must keep its 8 points, got 9 at time code 2"),
        (lambda *_: None, {"animation": "Run"}, "USD has no named animations; leave out animation"),
        (lambda *_: None, {"parts": ["Leg"]}, "names of its meshes, 'Tube', 'Wall', got 'Leg'"),
    ],
)
def test_what_is_wrong_with_usd_is_one_sentence(tmp_path, change, settings, said):
    path = write_usd(tmp_path / "tube.usda", change)
    with pytest.raises(ls.InvalidInput, match=said):
        ls.obstacles.baked(path, **settings)


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_a_truncated_or_missing_usd_is_one_sentence(tmp_path, suffix):
    content = write_usd(tmp_path / f"tube{suffix}").read_bytes()
    for size in (0, 20, len(content) // 2):
        (tmp_path / f"cut{suffix}").write_bytes(content[:size])
        with pytest.raises((ls.CacheError, ls.InvalidInput), match="cut") as told:
            ls.obstacles.baked(tmp_path / f"cut{suffix}")
        assert "\n" not in str(told.value)
    with pytest.raises(ls.CacheError, match="cannot be read: there is no such file"):
        ls.obstacles.baked(tmp_path / f"absent{suffix}")
    with pytest.raises(ls.InvalidInput, match="must end in .usd, .usda"):
        ls.obstacles.baked(tmp_path / "tube.fbx")


def test_a_crash_of_the_library_is_one_sentence(tmp_path, monkeypatch):
    path = write_usd(tmp_path / "tube.usda")
    for program, said in (
        ("import os; os.abort()", "is damaged, and cannot be read as USD: usd-core has crashed"),
        ("raise ValueError('no\\nmore')", "cannot be read as USD: more"),
    ):
        monkeypatch.setattr("loomstone.exchange.usd_process._PROGRAM", program)
        with pytest.raises(ls.CacheError, match=said):
            ls.obstacles.baked(path)


def test_an_error_of_the_reader_itself_is_not_said_of_the_file(gltf, tmp_path, monkeypatch):
    path = write_usd(tmp_path / "tube.usda")
    broken = "import loomstone.exchange.usd_reader as r; del r._bake_skins;"
    program = "from loomstone.exchange.usd_process import serve; serve()"
    monkeypatch.setattr("loomstone.exchange.usd_process._PROGRAM", f"{broken} {program}")
    with pytest.raises(RuntimeError, match="NameError: name '_bake_skins' is not defined"):
        ls.obstacles.baked(path)
    broken = "import sys; sys.modules['loomstone.exchange.usd_reader'] = None;"
    monkeypatch.setattr("loomstone.exchange.usd_process._PROGRAM", f"{broken} {program}")
    with pytest.raises(RuntimeError, match="import of loomstone.exchange.usd_reader halted"):
        ls.obstacles.baked(path)
    for error in (AttributeError, TypeError):

        def fail(*_, error=error):
            raise error("of our own")

        monkeypatch.setattr("loomstone.exchange.gltf_reader.sample_times", fail)
        with pytest.raises(error, match="^of our own$"):
            ls.obstacles.baked(gltf)


def test_values_of_usd_of_a_wrong_type_are_one_sentence(tmp_path):
    text = write_usd(tmp_path / "tube.usda").read_text()
    for old, new, said in (
        ("int[] faceVertexCounts = ", "asset[] faceVertexCounts = [@x@] #", "faceVertexCounts"),
        ("point3f[] points = ", "asset points = @x@ #", "points cannot be read as an array"),
        ("uniform token[] joints = ", "uniform int joints = 3 #", "joints cannot be read as"),
        (
            "matrix4d[] bindTransforms = ",
            "int bindTransforms = 3 #",
            "bindTransforms cannot be read",
        ),
    ):
        assert old in text
        (tmp_path / "odd.usda").write_text(text.replace(old, new))
        with pytest.raises(ls.InvalidInput, match=f"odd.usda: .*{said}"):
            ls.obstacles.baked(tmp_path / "odd.usda")


def test_what_an_export_writes_is_an_obstacle_of_the_next_run(tmp_path):
    pytest.importorskip("pxr")
    mesh = ls.grid(size=(0.1, 0.1), cells=(4, 4))
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=[0])]), threads=1)
    sim.run(out=tmp_path / "run", duration=0.08, rate=50)
    run = ls.Run(tmp_path / "run")
    (path,) = run.export(tmp_path / "run.usdc")
    again = ls.obstacles.baked(path)
    assert again.times == pytest.approx(run.times)
    wanted = run.positions[:].reshape(-1, 3)
    assert again.vertex_positions == pytest.approx(wanted, abs=2.0**-27)  # single precision


def test_a_file_that_usd_cannot_open_is_refused_without_the_place_in_its_sources(tmp_path):
    pytest.importorskip("pxr")
    (tmp_path / "empty.usdc").touch()
    (tmp_path / "words.usda").write_text("no layer")
    for name in ("empty.usdc", "words.usda"):
        with pytest.raises(ls.CacheError, match="cannot be read as USD: ") as told:
            ls.meshes.read(tmp_path / name)
        assert name in str(told.value) and "at line" not in str(told.value), told.value
