"""Exported files are read back, mostly by other libraries, and compared with the run."""

import json
import subprocess
import sys

import loomstone as ls
import numpy as np
import pytest
from loomstone.exchange.clip import clip_of
from loomstone.exchange.surfaces import srgb

# Tolerance [m] of coordinates below 0.5 m in single precision, whose relative error is 2**-24.
FLOAT = 0.5 * 2.0**-24


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of 6 frames with two cloths, a spinning body, a falling magnet, a deforming obstacle
    and a floor at rest. The uv of the first cloth have a seam.
    """
    out = tmp_path_factory.mktemp("run") / "out"
    flat = ls.grid(size=(0.1, 0.1), cells=(6, 6))
    # The uv of the last column of cells are shifted, so vertices at its inner border have two uv.
    apart = flat.vertices[flat.triangles][:, :, 0].mean(1) > 0.033
    uv = np.concatenate([flat.uv, flat.uv + (1.0, 0.0)])
    seam = ls.TriangleMesh(
        flat.vertices,
        flat.triangles,
        uv,
        uv_triangles=flat.triangles + flat.n_vertices * apart[:, None],
    )
    ball = ls.meshes.sphere(radius=0.03, subdivisions=1).moved((0.3, 0, 0))
    breath = np.array([ball.vertices, 1.05 * ball.vertices])
    spinning = ls.RigidBody(
        name="a box",
        mesh=ls.meshes.box(size=(0.02, 0.03, 0.04)),
        position=(0, 0.3, 0),
        angular_velocity=(3.0, 5.0, 20.0),
        density=500.0,
    )
    magnet = ls.RigidBody(
        name="magnet", mesh=ls.meshes.cylinder(radius=0.01, length=0.01), position=(0, -0.3, 0)
    )
    scene = ls.Scene(
        cloths=[ls.Cloth(name="a/b", mesh=seam.moved((0, 0, 0.1)), pins=[0])]
        + [ls.Cloth(name="a b", mesh=flat.moved((0, 0.15, 0.1)), pins=[0, 6])],
        bodies=[spinning, magnet],
        magnets=[
            ls.Magnet(
                body="magnet",
                source=ls.magnetics.cylinder(radius=0.01, height=0.01, polarization=(0, 0, 1.0)),
            )
        ],
        obstacles=[
            ls.Obstacle(
                name="breath",
                mesh=ball,
                times=[0.0, 1.0],
                vertex_positions=breath.reshape(-1, 3),
            ),
            ls.floor(height=-0.4, size=0.8, cells=2),
        ],
    )
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3), threads=1)
    sim.run(out=out, duration=0.1, rate=50)
    return ls.Run(out)


def expected(run, name, frame):
    """Returns the vertices of a cloth, body or obstacle in a frame."""
    t = run.topology
    if name in t.cloth_names:
        return frame.positions[t.cloth_of_vertex == t.cloth_names.index(name)]
    return frame.body_vertices[t.body_of_vertex == t.body_names.index(name)]


def names(run):
    return [*run.topology.cloth_names, *run.topology.body_names]


def corner_uv(run, name):
    """Returns the uv of the corners of a cloth of m triangles (3 m x 2)."""
    t = run.topology
    mine = np.flatnonzero(t.cloth_of_triangle == t.cloth_names.index(name))
    return t.corner_uv.reshape(-1, 3, 2)[mine].reshape(-1, 2)


@pytest.mark.parametrize("suffix", [".usdc", ".usda"])
def test_usd_has_the_positions_uv_poses_and_materials_of_the_run(run, tmp_path, suffix):
    pxr = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom, UsdShade

    (path,) = run.export(tmp_path / f"run{suffix}", frames=range(1, 6), every=2)
    # `largest_size` bounds the size of a binary file. A text file may have four times this size.
    bound = clip_of(run, range(1, 6), 2, lambda _: None).largest_size
    assert path.stat().st_size <= bound * (4 if suffix == ".usda" else 1)
    stage = pxr.Stage.Open(str(path))
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 50.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1.0, 5.0)
    meshes = {p.GetDisplayName(): UsdGeom.Mesh(p) for p in stage.Traverse() if p.IsA(UsdGeom.Mesh)}
    assert list(meshes) == names(run) and stage.GetDefaultPrim().GetName() == "run"
    for name, mesh in meshes.items():
        for code in (1, 3, 5):
            points = np.array(mesh.GetPointsAttr().Get(code), float)
            world = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(mesh.GetPrim()))
            points = points @ world[:3, :3] + world[3, :3]
            # The tolerance of bodies allows for fitted poses (1e-6 of 0.04 m) and single precision.
            allowed = FLOAT if name in run.topology.cloth_names else 1e-7
            assert points == pytest.approx(expected(run, name, run[code]), abs=allowed)
    moving = {n for n, m in meshes.items() if m.GetPointsAttr().GetNumTimeSamples()}
    assert moving == {"a/b", "a b", "breath"}
    assert len(meshes["a box"].GetOrderedXformOps()) == 2  # translation and rotation
    assert meshes["floor"].GetOrderedXformOps() == []
    for name in run.topology.cloth_names:
        uv = UsdGeom.PrimvarsAPI(meshes[name]).GetPrimvar("st").ComputeFlattened()
        # uv reach 1.05 m, so single precision changes them by at most 2**-24 m.
        assert np.array(uv) == pytest.approx(corner_uv(run, name), abs=2.0**-24)
    bound = UsdShade.MaterialBindingAPI(meshes["a b"].GetPrim()).ComputeBoundMaterial()[0]
    color = bound.ComputeSurfaceSource()[0].GetInput("diffuseColor").Get()
    assert tuple(color) == tuple(ls._core.cloth_color(1))
    subsets = UsdShade.MaterialBindingAPI(meshes["magnet"].GetPrim()).GetMaterialBindSubsets()
    assert len(subsets) == 3  # materials of sides, north pole and south pole


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_has_the_positions_uv_poses_and_materials_of_the_run(run, tmp_path, suffix):
    pygltflib = pytest.importorskip("pygltflib")
    from loomstone.exchange.gltf_reader import read_gltf

    (path,) = run.export(tmp_path / f"run{suffix}", frames=range(1, 6), every=2)
    parts, times = read_gltf(path, 25.0, ["run"])
    assert times == pytest.approx([0.0, 0.04, 0.08])
    assert [part.name for part in parts] == names(run)
    for part in parts:
        for index, code in enumerate((1, 3, 5)):
            wanted = expected(run, part.name, run[code])
            # The tolerance allows for single precision of points, displacements and rotations.
            assert part.frames[index][: len(wanted)] == pytest.approx(wanted, abs=2e-7)
    content = pygltflib.GLTF2().load(str(path))
    assert content.asset.version == "2.0" and content.scene == 0
    keyed = {c.target.path for c in content.animations[0].channels}
    assert keyed == {"translation", "rotation", "weights"}
    look = content.materials[1].pbrMetallicRoughness
    assert look.baseColorFactor[:3] == pytest.approx(ls._core.cloth_color(1))
    assert [m.doubleSided for m in content.materials][:3] == [True, True, False]


def test_another_reader_of_gltf_sees_the_first_frame_with_its_uv(run, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("pygltflib")
    (path,) = run.export(tmp_path / "run.glb")
    scene = trimesh.load_scene(path, process=False)
    turn, node = scene.graph["a/b"]
    mesh = scene.geometry[node]
    points = trimesh.transform_points(mesh.vertices, turn)  # y up
    z_up = np.column_stack([points[:, 0], -points[:, 2], points[:, 1]])
    wanted = expected(run, "a/b", run[0])
    assert z_up[: len(wanted)] == pytest.approx(wanted, abs=FLOAT)
    assert len(mesh.vertices) == len(wanted) + 7  # the 7 vertices of the seam have two uv
    uv = mesh.visual.uv[mesh.faces].reshape(-1, 2)
    assert uv == pytest.approx(corner_uv(run, "a/b"), abs=2.0**-23)  # glTF stores 1 - v, rounded


def test_alembic_has_the_positions_uv_and_poses_of_the_run(run, tmp_path):
    geometry = pytest.importorskip("alembic3d.AbcGeom")
    from alembic3d import Abc

    (path,) = run.export(tmp_path / "run.abc", frames=range(1, 6), every=2)
    top = Abc.IArchive(str(path)).getTop()
    assert top.getNumChildren() == len(names(run))
    for number, name in enumerate(names(run)):
        pose = geometry.IXform(top, top.getChildHeader(number).getName())
        mesh = geometry.IPolyMesh(pose, pose.getChildHeader(0).getName()).getSchema()
        samples = max(mesh.getNumSamples(), pose.getSchema().getNumSamples())
        assert samples == (1 if name == "floor" else 3)
        for code in (1, 3, 5):
            at = Abc.ISampleSelector(0.02 * code)  # the sample nearest to this time [s]
            points = [tuple(p) for p in mesh.getValue(at).getPositions()]
            moved = pose.getSchema().getValue(at).getMatrix()
            world = np.array([[moved[i][j] for j in range(4)] for i in range(4)])
            found = np.array(points) @ world[:3, :3] + world[3, :3]
            z_up = np.column_stack([found[:, 0], -found[:, 2], found[:, 1]])
            allowed = FLOAT if name in run.topology.cloth_names else 1e-7
            assert z_up == pytest.approx(expected(run, name, run[code]), abs=allowed)
        corners = np.array(list(mesh.getValue().getFaceIndices())).reshape(-1, 3)[:, ::-1]
        own = run.topology.body_of_triangle if number > 1 else run.topology.cloth_of_triangle
        every = run.topology.body_triangles if number > 1 else run.topology.triangles
        mine = every[own == number % 2 if number < 2 else own == number - 2]
        assert np.array_equal(corners, mine - mine.min())
    mesh = geometry.IPolyMesh(geometry.IXform(top, "a_b"), "a_b_surface").getSchema()
    uv = mesh.getUVsParam().getExpandedValue().getVals()
    found = np.array([tuple(v) for v in uv]).reshape(-1, 3, 2)[:, ::-1].reshape(-1, 2)
    assert found == pytest.approx(corner_uv(run, "a/b"), abs=2.0**-24)


def test_alembic_has_colors_of_the_vertices(run, textured, tmp_path):
    geometry = pytest.importorskip("alembic3d.AbcGeom")
    from alembic3d import Abc

    def colors(path, name):
        pose = geometry.IXform(Abc.IArchive(str(path)).getTop(), name)
        values = geometry.IPolyMesh(pose, f"{name}_surface").getSchema().getArbGeomParams()
        found = geometry.IC3fGeomParam(values, "Cd").getExpandedValue()
        assert found.getScope() == geometry.GeometryScope.kVertexScope
        return np.array([tuple(v) for v in found.getVals()])

    (path,) = run.export(tmp_path / "run.abc")
    cloth = colors(path, "a_b_2")
    assert len(cloth) == len(expected(run, "a b", run[0]))
    # Colours are rounded to bytes in sRGB, whose steps are at most 0.009 in linear RGB.
    assert cloth == pytest.approx(np.tile(ls._core.cloth_color(1), (len(cloth), 1)), abs=0.005)
    north_and_south = colors(path, "magnet")
    assert (north_and_south[:, 0] > 0.2).any() and (north_and_south[:, 2] > 0.2).any()
    (path,) = textured.export(tmp_path / "textured.abc")
    assert {tuple(c) for c in colors(path, "sheet")} == {(1, 0, 0), (0, 0, 1)}
    assert (colors(path, "sphere") == (0, 1, 0)).all()


@pytest.mark.parametrize("to", ["pc2", "mdd"])
def test_point_caches_have_the_positions_of_the_run(run, tmp_path, to):
    paths = run.export(tmp_path / "caches", to=to, frames=range(2, 6))
    found = sorted(p.name for p in (tmp_path / "caches").iterdir())
    assert sorted(p.name for p in paths) == found
    materials = {f"{s.identifier}.mtl" for s in clip_of(run, None, 1, lambda _: None).surfaces}
    still = {"floor.obj"} | materials
    moving = ["a_b", "a_b_2", "a_box", "magnet", "breath"]
    assert set(found) == still | {f"{n}.{e}" for n in moving for e in ("obj", to)}
    for name, file in zip(names(run), [*moving, "floor"], strict=True):
        base = ls.meshes.read(tmp_path / "caches" / f"{file}.obj")
        assert np.array_equal(base.vertices, expected(run, name, run[2]))
        if file == "floor":
            continue
        rate = {"rate": 50.0} if to == "pc2" else {}
        read = ls.obstacles.sequence(tmp_path / "caches" / f"{file}.{to}", mesh=base, **rate)
        wanted = np.concatenate([expected(run, name, frame) for frame in run[2:6]])
        assert np.array_equal(read.vertex_positions, wanted.astype(np.float32))
        start = 0.0 if to == "pc2" else 0.04  # .pc2 stores no times; .mdd stores them as floats
        assert read.times == pytest.approx(start + 0.02 * np.arange(4), abs=1e-8)


@pytest.mark.parametrize("to", ["obj", "ply"])
def test_mesh_sequences_have_the_bits_of_the_run_and_its_uv(run, tmp_path, to):
    run.export(tmp_path, to=to, every=5)
    files = sorted(p.name for p in tmp_path.iterdir())
    materials = 6 if to == "obj" else 0
    assert f"floor.{to}" in files and f"a_b-00005.{to}" in files and len(files) == 11 + materials
    mesh = ls.meshes.read(tmp_path / f"a_b-00005.{to}")
    assert np.array_equal(mesh.vertices, expected(run, "a/b", run[5]))
    assert np.array_equal(mesh.uv[mesh.uv_triangles].reshape(-1, 2), corner_uv(run, "a/b"))
    sequence = ls.obstacles.sequence(tmp_path / f"breath-*.{to}", rate=10.0)
    wanted = np.concatenate([expected(run, "breath", run[k]) for k in (0, 5)])
    assert np.array_equal(sequence.vertex_positions, wanted)


def test_an_earlier_export_is_replaced_only_on_request(run, tmp_path):
    run.export(tmp_path / "x", to="obj")
    (tmp_path / "x" / "notes.txt").write_text("mine")
    with pytest.raises(ls.InvalidInput, match=r"x: exists already; .*--overwrite"):
        run.export(tmp_path / "x", to="obj", frames=range(2))
    assert (tmp_path / "x" / "a_b-00005.obj").exists()
    run.export(tmp_path / "x", to="obj", frames=range(2), overwrite=True)
    left = sorted(p.name for p in (tmp_path / "x").iterdir() if "a_b-" in p.name)
    assert left == ["a_b-00000.obj", "a_b-00001.obj"]
    assert (tmp_path / "x" / "notes.txt").read_text() == "mine"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x"]


@pytest.mark.parametrize(
    "settings, said",
    [
        ({"to": "fbx"}, "to must be one of usd, gltf, alembic, pc2, mdd, obj, ply, got 'fbx'"),
        ({}, "a format must be given"),
        ({"out": "x.fbx"}, "the format does not follow from this name"),
        ({"out": "x.glb", "to": "usd"}, "a usd file must end in .usdc or .usd or .usda"),
        ({"to": "obj", "frames": range(-3, 2)}, "ascending range within the frames 0 to 5"),
        ({"to": "obj", "frames": range(3, 3)}, "ascending range within the frames 0 to 5"),
        ({"to": "obj", "frames": range(5, 0, -1)}, "ascending range within the frames 0 to 5"),
        ({"to": "obj", "frames": range(9)}, "ascending range within the frames 0 to 5"),
        ({"to": "obj", "frames": 3}, r"frames must be a range, such as range\(10, 50\), got 3"),
        ({"to": "obj", "every": 0}, r"every must be in \[1, 1000000\], got 0"),
    ],
)
def test_wrong_settings_are_one_sentence(run, tmp_path, monkeypatch, settings, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ls.InvalidInput, match=said):
        run.export(**settings)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "module, extra, suffix",
    [("pxr", "usd", "usd"), ("pygltflib", "gltf", "glb"), ("alembic3d", "alembic", "abc")],
)
def test_a_missing_package_is_named_with_its_extra(
    run, tmp_path, monkeypatch, module, extra, suffix
):
    monkeypatch.setitem(sys.modules, module, None)
    for name in [name for name in sys.modules if name.startswith(f"{module}.")]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ls.Unsupported, match=rf"pip install loomstone\[{extra}\]"):
        run.export(tmp_path / "new" / f"run.{suffix}")
    assert not (tmp_path / "new").exists()


def command(*arguments, largest_file=None):
    def limit():
        import resource
        import signal

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        if largest_file:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    return subprocess.run(
        [sys.executable, "-m", "loomstone", "export", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        preexec_fn=limit,
    )


@pytest.mark.parametrize("to", ["usd", "gltf", "alembic", "pc2", "obj"])
def test_a_full_disk_is_one_sentence_and_leaves_nothing(run, tmp_path, to):
    needed = {"usd": "pxr", "gltf": "pygltflib", "alembic": "alembic3d"}
    if to in needed:
        pytest.importorskip(needed[to])
    suffix = {"usd": ".usdc", "gltf": ".glb", "alembic": ".abc"}.get(to, "")
    done = command(run.directory, "--to", to, "--out", tmp_path / f"x{suffix}", largest_file=2000)
    assert done.returncode == 1 and len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert f"x{suffix}" in done.stderr and "cannot be written: File too large" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_command_exports_and_says_where(run, tmp_path):
    done = command(run.directory, "--out", tmp_path / "new" / "x.glb", "--frames", "1:4")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"exported: {tmp_path / 'new' / 'x.glb'}, ")
    content = (tmp_path / "new" / "x.glb").read_bytes()
    length = int.from_bytes(content[12:16], "little")
    head = json.loads(content[20 : 20 + length])
    assert head["accessors"][head["animations"][0]["samplers"][0]["input"]]["count"] == 3


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["--to", "usd", "--frames", "-3:2"], "--frames must be A:B with 0 <= A < B <= 6"),
        (["--to", "usd", "--frames", "4"], "--frames must be A:B with 0 <= A < B <= 6"),
        (["--to", "usd", "--frames", "4:9"], "--frames must be A:B with 0 <= A < B <= 6"),
        (["--to", "usd", "--every", "0"], "every must be in"),
        ([], "a format must be given"),
    ],
)
def test_wrong_options_of_the_command_are_one_sentence(run, arguments, said):
    done = command(run.directory, *arguments)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert said in done.stderr and "Traceback" not in done.stderr


def test_a_missing_or_truncated_run_is_one_sentence(run, tmp_path):
    (tmp_path / "cut").mkdir()
    content = (run.directory / "run.vtkhdf").read_bytes()
    (tmp_path / "cut" / "run.vtkhdf").write_bytes(content[: len(content) // 2])
    (tmp_path / "empty").mkdir()
    for name in ("cut", "empty", "absent"):
        done = command(tmp_path / name, "--to", "usd")
        assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
        assert str(tmp_path / name) in done.stderr


@pytest.fixture(scope="module")
def textured(tmp_path_factory):
    """A run of one frame: a green ball, and a sheet whose texture has a transparent pixel."""
    out = tmp_path_factory.mktemp("textured") / "out"
    image = np.array([[[255, 0, 0, 255], [0, 0, 0, 0]]], np.uint8)
    look = ls.Look(texture=image, color=(0, 0, 1), roughness=0.25, texture_width=0.05)
    sheet = ls.Cloth(name="sheet", mesh=ls.grid(size=(0.1, 0.1), cells=(2, 2)), look=look)
    green = ls.Look(color=(0, 1, 0), roughness=0.5)
    ball = ls.sphere(radius=0.1, centre=(0, 0, -0.2), subdivisions=1, look=green)
    ls.Simulation(ls.Scene(cloths=[sheet], obstacles=[ball]), threads=1).run(out=out, duration=0.02)
    return ls.Run(out)


IMAGE = [[[255, 0, 0], [0, 0, 255]]]  # the blue of the look replaces the transparent pixel


def test_gltf_contains_textures_and_looks(textured, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("pygltflib")
    scene = trimesh.load_scene(textured.export(tmp_path / "run.glb")[0], process=False)
    sheet, ball = (scene.geometry[name].visual for name in ("sheet", "sphere"))
    assert np.array(sheet.material.baseColorTexture.convert("RGB")).tolist() == IMAGE
    assert sheet.material.roughnessFactor == 0.25
    # trimesh counts v from the lower edge. The width of the image is 0.05 m, its height 0.025 m.
    wanted = textured.topology.corner_uv / (0.05, 0.025)
    assert np.sort(np.unique(sheet.uv[:, 1])) == pytest.approx(np.unique(wanted[:, 1]), abs=1e-6)
    assert ball.material.baseColorFactor.tolist() == [0, 255, 0, 255]


def test_usd_has_textures_in_files_beside_it(textured, tmp_path):
    pxr = pytest.importorskip("pxr.Usd")
    from PIL import Image
    from pxr import UsdGeom, UsdShade

    stage = pxr.Stage.Open(str(textured.export(tmp_path / "run.usdc")[0]))
    mesh = stage.GetPrimAtPath("/run/sheet")
    bound = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0].ComputeSurfaceSource()[0]
    assert bound.GetInput("roughness").Get() == 0.25
    source = bound.GetInput("diffuseColor").GetConnectedSources()[0][0].source
    file = UsdShade.Shader(source.GetPrim()).GetInput("file").Get().resolvedPath
    assert file == str(tmp_path / "run-sheet.png")
    assert np.array(Image.open(file)).tolist() == IMAGE
    uv = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").ComputeFlattened())
    assert uv == pytest.approx(textured.topology.corner_uv / (0.05, 0.025), abs=1e-6)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run-sheet.png", "run.usdc"]


def test_obj_has_materials_and_textures_in_files_beside_it(run, textured, tmp_path):
    from PIL import Image

    paths = textured.export(tmp_path, to="obj")
    names = ["sheet-00000.obj", "sheet.mtl", "sheet.png", "sphere.mtl", "sphere.obj"]
    assert sorted(path.name for path in tmp_path.iterdir() if "00001" not in path.name) == names
    assert sorted(paths) == sorted(tmp_path.iterdir())
    assert np.array(Image.open(tmp_path / "sheet.png")).tolist() == IMAGE
    text = (tmp_path / "sheet.mtl").read_text().splitlines()
    assert text[1:] == ["newmtl sheet_0", "Kd 1 1 1", "Pr 0.25", "map_Kd sheet.png"]
    text = (tmp_path / "sphere.mtl").read_text().splitlines()
    assert text[1:] == ["newmtl sphere_0", "Kd 0 1 0", "Pr 0.5"]
    sheet = ls.meshes.read(tmp_path / "sheet-00000.obj")
    # The width of the image is 0.05 m, its height 0.025 m.
    wanted = textured.topology.corner_uv / (0.05, 0.025)
    assert np.array_equal(sheet.uv[sheet.uv_triangles].reshape(-1, 2), wanted)
    run.export(tmp_path / "magnet", to="obj", frames=range(1))
    lines = (tmp_path / "magnet" / "magnet.obj").read_text().splitlines()
    assert lines[1] == "mtllib magnet.mtl"
    (surface,) = (
        s for s in clip_of(run, range(1), 1, lambda _: None).surfaces if s.name == "magnet"
    )
    current, found = "", []
    for line in lines:
        if line.startswith("usemtl"):
            current = line.split()[1]
        if line.startswith("f "):
            found.append(int(current.removeprefix("magnet_")))
    assert np.array_equal(found, surface.material) and set(found) == {0, 1, 2}


def test_another_reader_of_obj_sees_the_materials_and_the_texture(run, textured, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    textured.export(tmp_path, to="obj")
    sheet = trimesh.load(tmp_path / "sheet-00000.obj", process=False, force="mesh").visual
    assert np.array(sheet.material.image.convert("RGB")).tolist() == IMAGE
    ball = trimesh.load(tmp_path / "sphere.obj", process=False, force="mesh").visual
    assert ball.material.diffuse.tolist()[:3] == [0, 255, 0]


def test_ply_has_colors_of_the_vertices(run, textured, tmp_path):
    trimesh = pytest.importorskip("trimesh")

    def colors(path):
        # trimesh shows either uv or colours, and keeps the content of the file in the metadata.
        raw = trimesh.load(path, process=False).metadata["_ply_raw"]["vertex"]["data"]
        return np.column_stack([raw[name].ravel() for name in ("red", "green", "blue")])

    textured.export(tmp_path / "textured", to="ply")
    sheet = ls.meshes.read(tmp_path / "textured" / "sheet-00000.ply")
    assert np.array_equal(
        sheet.uv[sheet.uv_triangles].reshape(-1, 2), textured.topology.corner_uv
    ), "in metres, because there is no image"
    sheet = colors(tmp_path / "textured" / "sheet-00000.ply")
    assert {tuple(c) for c in sheet.tolist()} == {(255, 0, 0), (0, 0, 255)}
    assert (colors(tmp_path / "textured" / "sphere.ply") == (0, 255, 0)).all()
    run.export(tmp_path / "run", to="ply", frames=range(1))
    cloth = colors(tmp_path / "run" / "a_b_2-00000.ply")
    assert (cloth == srgb(ls._core.cloth_color(1))).all()


@pytest.mark.parametrize(
    "name, colors, said",
    [
        ("x.obj", {"colors": np.zeros((4, 3), np.uint8)}, r"x.obj: colours of vertices need a"),
        ("x.ply", {"library": "x.mtl"}, "x.ply: materials need an .obj file"),
        ("x.ply", {"colors": np.zeros((3, 3), np.uint8)}, "each of the 4 vertices, got 3"),
        ("x.ply", {"colors": np.zeros((4, 4), np.uint8)}, r"bytes \(uint8\) of shape \(n, 3\)"),
        ("x.obj", {"materials": [(0, "a"), (0, "b")]}, "must ascend and be less than 2, got 0"),
        ("x.obj", {"materials": [(2, "a")]}, "must ascend and be less than 2, got 2 for a"),
    ],
)
def test_colors_that_a_mesh_file_cannot_hold_are_refused(tmp_path, name, colors, said):
    with pytest.raises(ls.InvalidInput, match=said):
        ls._core.write_mesh(str(tmp_path / name), ls.grid(size=(1, 1), cells=(1, 1)), **colors)
    assert not list(tmp_path.iterdir())
