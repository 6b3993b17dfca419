"""Passes contain depth, normals and ids of surfaces, and the name of the surface with each id."""

import sys

import loomstone as ls
import numpy as np
import pytest
from loomstone.cli import app
from loomstone.pictures import write_passes
from typer.testing import CliRunner

OpenEXR = pytest.importorskip("OpenEXR", reason="passes need the package OpenEXR")

# The camera looks down at a square of 0.5 m from a distance of 1 m.
OPTIONS = ls.RenderOptions(
    width=64, height=64, camera=ls.Camera(fit=False, eye=(0, 0, 1), up=(0, 1, 0))
)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("passes") / "run"
    cloth = ls.Cloth(name="sheet", mesh=ls.grid(size=(0.5, 0.5), cells=(4, 4)))
    ball = ls.sphere(radius=0.1, centre=(0, 0, 0.3))
    scene = ls.Scene(cloths=[cloth], obstacles=[ball], gravity=(0, 0, 0))
    ls.Simulation(scene, threads=1).run(out=out, duration=0.04)
    return ls.Run(out)


def channels(path):
    file = OpenEXR.File(str(path))
    return file.header(), {name: channel.pixels for name, channel in file.channels().items()}


def test_passes_hold_what_the_scene_says(run, tmp_path):
    paths = write_passes(run, OPTIONS, ["depth", "normal", "id"], out=tmp_path, frames=[1])
    assert [path.name for path in paths] == ["depth-00001.exr", "normal-00001.exr", "id-00001.exr"]
    _, depth = channels(paths[0])
    _, normal = channels(paths[1])
    header, number = channels(paths[2])
    assert header["surfaces"].split("\n") == ["1 sheet", "2 sphere", "3 field lines"]
    z, n, i = depth["Z"], normal["RGB"], number["id"]
    assert z.dtype == np.float32 and z.shape == (64, 64)
    assert i[32, 32] == 2 and i[32, 10] == 1 and i[0, 0] == 0
    assert np.isinf(z[0, 0]) and not n[0, 0].any()
    assert z[32, 10] == pytest.approx(1.0) and np.allclose(n[32, 10], (0, 0, 1))
    assert z[32, 32] == pytest.approx(0.6, abs=2e-3)  # the ball has flat triangles
    before = [path.read_bytes() for path in paths]
    write_passes(run, OPTIONS, ["depth", "normal", "id"], out=tmp_path, frames=[1])
    assert before == [path.read_bytes() for path in paths]


def test_the_command_writes_passes_in_place_of_pictures(run):
    given = ["render", str(run.directory), "--pass", "depth", "--pass", "id", "--width", "32"]
    done = CliRunner().invoke(app, [*given, "--height", "32"])
    assert done.exit_code == 0 and "passes: " in done.output, done.output
    names = sorted(path.name for path in (run.directory / "passes").iterdir())
    assert names == ["depth-00000.exr", "depth-00001.exr", "id-00000.exr", "id-00001.exr"]
    assert not (run.directory / "frames").exists()
    assert not (run.directory / "video.mp4").exists()


def test_passes_and_pictures_with_the_same_look_show_the_same_view(run):
    look = ["--color-by", "stretch", "--wireframe", "--field-lines", "5"]
    given = ["render", str(run.directory), "--pass", "depth", "--frame", "0", "--width", "64"]
    depths = []
    for options in ([], look):
        done = CliRunner().invoke(app, [*given, "--height", "64", *options])
        assert done.exit_code == 0, done.output
        depths.append(channels(run.directory / "passes" / "depth-00000.exr")[1]["Z"])
    assert not np.array_equal(*depths)  # the view leaves room for the colour bar of --color-by


def test_a_wrong_pass_and_a_missing_package_are_one_sentence(run, tmp_path, monkeypatch):
    with pytest.raises(ls.InvalidInput, match="pass must be depth, normal, id, got 'albedo'"):
        write_passes(run, OPTIONS, ["albedo"], out=tmp_path)
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(ls.Unsupported, match=r"loomstone\[exr\]"):
        write_passes(run, OPTIONS, ["depth"], out=tmp_path)
