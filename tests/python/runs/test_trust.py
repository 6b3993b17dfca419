"""Files of a run are data. The copy of the scene file that they contain is executed only if it
equals the scene file on disk, or if the user trusts the run.
"""

import json
import math
import pickle
import shutil
import subprocess
import sys

import loomstone as ls
import pytest
from loomstone.runs.magnet_record import magnets_from_record, magnets_to_record

SCENE = """
import loomstone as ls
duration, rate = 0.08, 25.0
integrator = ls.SemiImplicitEuler(step=4e-3)
render = ls.RenderOptions(width=80, height=60, samples=1, field_lines=12)
def scene():
    ball = ls.meshes.sphere(radius=0.01, subdivisions=1)
    magnet = ls.magnetics.sphere(radius=0.01, polarization=(0, 0, 1))
    soft = ls.magnetics.soft_sphere(radius=0.01, susceptibility=10.0)
    return ls.Scene(
        cloths=[ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(4, 4)), pins=[0])],
        bodies=[ls.RigidBody(name="ball", mesh=ball, position=(0, 0, -0.1))],
        obstacles=[
            ls.Obstacle(name="iron", mesh=ball.moved((0.05, 0, -0.1)), times=[0, 1],
                        positions=[(0, 0, 0), (0, 0, 0.1)])],
        magnets=[ls.Magnet(body="ball", source=magnet),
                 ls.Magnet(body="iron", source=soft.moved((0.05, 0, -0.1)))],
    )
def check(run):
    print("checked")
"""


def loomstone(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "loomstone", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.fixture(scope="module")
def from_stranger(tmp_path_factory):
    """Directory of a run whose scene file creates the file `marker`. Both files have been deleted,
    but the run contains a copy of the scene file.
    """
    place = tmp_path_factory.mktemp("stranger")
    scene, out, marker = place / "scene.py", place / "out", place / "marker"
    scene.write_text(f"open({str(marker)!r}, 'a').close()\n" + SCENE)
    done = loomstone("run", scene, "--out", out, "--threads", 1)
    assert done.returncode == 0, done.stderr
    marker.unlink()
    scene.unlink()
    return out


@pytest.fixture
def run(from_stranger, tmp_path):
    shutil.copytree(from_stranger, tmp_path / "out")
    return tmp_path / "out"


def marker_of(from_stranger):
    return from_stranger.parent / "marker"


@pytest.mark.parametrize("command", ["resume", "check"])
def test_a_program_from_a_stranger_does_not_run(command, run, from_stranger):
    done = loomstone(command, run)
    assert done.returncode == 1 and not marker_of(from_stranger).exists()
    assert len(done.stderr.strip().splitlines()) == 1 and "--trust" in done.stderr, done.stderr
    trusted = loomstone(command, run, "--trust")
    assert trusted.returncode == 0 and marker_of(from_stranger).exists(), trusted.stderr
    marker_of(from_stranger).unlink()


def test_pictures_with_field_lines_and_descriptions_need_no_program(run, from_stranger):
    drawn = loomstone("render", run, "--jobs", 1)
    assert drawn.returncode == 0, drawn.stderr
    with_lines = (run / "frames" / "frame-00001.png").read_bytes()
    bare = loomstone("render", run, "--jobs", 1, "--field-lines", 0, "--out", run / "bare")
    assert bare.returncode == 0, bare.stderr
    assert (run / "bare" / "frame-00001.png").read_bytes() != with_lines
    told = loomstone("info", run, "--source")
    assert told.returncode == 0 and "def scene():" in told.stdout
    assert loomstone("info", run).returncode == 0
    assert not marker_of(from_stranger).exists()


def test_field_lines_drawn_from_stored_magnets_are_those_of_the_simulation(tmp_path):
    space = {}
    exec(SCENE, space)
    sim = ls.Simulation(space["scene"](), integrator=space["integrator"], threads=1)
    sim.run(out=tmp_path / "out", duration=0.08, render=space["render"])
    stored = ls.Run(tmp_path / "out")
    paths = ls.pictures.render_run(stored, space["render"], out=tmp_path / "again", jobs=1)
    for path in paths:
        assert path.read_bytes() == (tmp_path / "out" / "frames" / path.name).read_bytes()


def test_the_scene_file_at_hand_runs_and_a_changed_one_does_not(tmp_path):
    scene, out = tmp_path / "scene.py", tmp_path / "out"
    scene.write_text(SCENE)
    assert loomstone("run", scene, "--out", out, "--threads", 1).returncode == 0
    assert "checked" in loomstone("check", out).stdout
    scene.write_text(SCENE + "# changed\n")
    with pytest.raises(ls.CacheError, match="differs from it.*--trust"):
        ls.Run(out).scene()
    assert isinstance(ls.Run(out).scene(trust=True), ls.Scene)


def altered(run, change):
    """Changes the metadata of a run, as a stranger could do, and returns the run."""
    with ls.Run(run) as stored:
        frames, topology, metadata = list(stored), stored.topology, stored.metadata
    change(metadata)
    writer = ls._core.FrameWriter(str(run), topology, json.dumps(metadata))
    for frame in frames:
        writer.write(frame)
    return run


def test_a_scene_file_that_came_with_the_run_is_not_at_hand(run, from_stranger):
    source = ls.Run(run).metadata["scene_file"]["source"]
    (run / "scene.py").write_text(source)
    for path, cause in ((str(run / "scene.py"), "lies in the directory"), ("s.py", "not absolute")):
        altered(run, lambda metadata, p=path: metadata["scene_file"].update(path=p))
        with pytest.raises(ls.CacheError, match=cause):
            ls.Run(run).scene()
    assert not marker_of(from_stranger).exists()


def test_a_program_cannot_hide_behind_control_characters(run):
    hidden = "evil()  # \x1b[1K\r\u202e harmless\n"
    altered(run, lambda metadata: metadata["scene_file"].update(source=hidden))
    assert loomstone("info", run, "--source").stdout == (
        "evil()  # \\x1b[1K\\r\\u202e harmless\n\n"
    )


@pytest.mark.parametrize(
    "program", [3, [], {"path": 3}, {"path": "/x", "source": "", "parameters": []}]
)
def test_a_damaged_program_is_refused_in_one_sentence(run, program):
    altered(run, lambda metadata: metadata.update(scene_file=program))
    with pytest.raises(ls.CacheError):
        ls.Run(run).scene(trust=True)


def test_magnets_are_stored_as_numbers_and_read_without_pickles(run, monkeypatch):
    record = ls.Run(run).metadata["magnetic_scene"]
    monkeypatch.setattr(pickle, "loads", None)
    scene = magnets_from_record(record)
    assert [magnet.body for magnet in scene.magnets] == ["ball", "iron"]
    assert scene.magnets[0].source.moment.tolist() == pytest.approx(
        [0, 0, 4 / 3 * math.pi * 0.01**3 / ls.magnetics.MU0], rel=1e-12
    )
    assert magnets_to_record(scene) == record


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r.update(magnets=3),
        lambda r: r.pop("bodies"),
        lambda r: r["magnets"][0].update({"is": "Scene"}),
        lambda r: r["magnets"][0]["fields"].update(body=7),
        lambda r: r["magnets"][0]["fields"]["source"].update(state=[["sphere", [], None, None]]),
        lambda r: r["bodies"][0]["fields"]["mesh"]["vertices"].update(type="|O"),
        lambda r: r["bodies"][0]["fields"]["mesh"]["vertices"].update(shape=[3, 10**9]),
        lambda r: r["bodies"][0]["fields"]["mesh"]["vertices"].update(array="AA"),
    ],
)
def test_damaged_magnets_are_refused_in_one_sentence(run, change):
    altered(run, lambda metadata: change(metadata["magnetic_scene"]))
    with pytest.raises(ls.CacheError, match="its magnets cannot be read"):
        ls.Run(run).magnetic_scene()
