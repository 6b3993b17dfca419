"""Cameras are fitted to what is drawn, turn about it, and can be given on the command line."""

import json

import loomstone as ls
import numpy as np
import pytest
from loomstone.cli import app
from loomstone.pictures import fitted_camera, read_camera, turntable
from PIL import Image
from typer.testing import CliRunner

MARGIN = 0.92  # fraction of the width or height of the picture that a fitted view fills


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of a sheet that swings down beside a sphere, above a floor."""
    out = tmp_path_factory.mktemp("cameras") / "run"
    cloth = ls.Cloth(mesh=ls.grid(size=(0.4, 0.4), cells=(6, 6)), pins=[0, 6])
    obstacles = [ls.sphere(radius=0.1, centre=(0.5, 0, 0), subdivisions=2), ls.floor(height=-1)]
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], obstacles=obstacles),
        integrator=ls.SemiImplicitEuler(step=8e-3),
        threads=1,
    )
    sim.run(out=out, duration=0.16)
    return ls.Run(out)


def render(run, *arguments):
    given = ["render", str(run.directory), "--width", "160", "--height", "90", "--jobs", "1"]
    done = CliRunner().invoke(app, [*given, *map(str, arguments)])
    return done.exit_code, done.output


def reach(alphas):
    """Returns how far pixels that are covered in any of the pictures reach to the left, right, top
    and bottom, from 0 (middle) to 1 (edge of the picture).
    """
    rows, columns = np.nonzero(np.max(alphas, axis=0) > 200)  # shadows are more transparent
    height, width = alphas[0].shape
    ends = np.array([columns.min(), width - 1 - columns.max(), rows.min(), height - 1 - rows.max()])
    return 1.0 - 2.0 * ends / np.array([width, width, height, height])


def alphas(directory):
    return [np.asarray(Image.open(path))[..., 3] for path in sorted(directory.glob("*.png"))]


@pytest.mark.parametrize("turn", [[], ["--turntable", "360"]])
def test_a_fit_touches_the_margin_of_the_picture(run, tmp_path, turn):
    code, said = render(run, "--fit", "--background", "none", "--out", tmp_path, *turn)
    assert code == 0, said
    seen = reach(alphas(tmp_path))
    pixel = 2.0 / 90.0
    assert seen.max() < MARGIN + 2 * pixel
    if not turn:  # fills width or height
        assert min(seen[:2]) > MARGIN - 2 * pixel or min(seen[2:]) > MARGIN - 2 * pixel


def test_a_run_without_a_camera_fills_the_picture_by_default(run, tmp_path):
    assert render(run, "--background", "none", "--out", tmp_path / "a")[0] == 0
    assert render(run, "--background", "none", "--fit", "--out", tmp_path / "b")[0] == 0
    for one, other in zip(alphas(tmp_path / "a"), alphas(tmp_path / "b"), strict=True):
        assert np.array_equal(one, other)


def test_a_fit_replaces_keyframes_by_the_direction_of_the_first(run, tmp_path):
    file = tmp_path / "moving.json"
    file.write_text(json.dumps({"times": [0, 1], "eyes": [[0, -9, 0], [9, 0, 0]]}))
    still = tmp_path / "still.json"
    still.write_text(json.dumps({"eye": [0, -9, 0]}))
    for camera in (file, still):
        out = tmp_path / camera.stem
        assert render(run, "--camera", camera, "--fit", "--frame", 4, "--out", out)[0] == 0
    one, other = (tmp_path / name / "frame-00004.png" for name in ("moving", "still"))
    assert one.read_bytes() == other.read_bytes()


def test_a_fitted_camera_keeps_its_direction_and_depends_on_the_frames(run):
    options = ls.RenderOptions(width=160, height=90, camera=ls.Camera(eye=(0, -1, 0)))
    camera = fitted_camera(run, options)
    assert not camera.fit and np.allclose(np.subtract(camera.target, camera.eye)[[0, 2]], 0)
    assert fitted_camera(run, options, frames=[0]) != camera
    with pytest.raises(ls.InvalidInput, match="keyframes cannot be fitted"):
        keys = ls.Camera(times=[0.0], eyes=[(0, -1, 0)])
        fitted_camera(run, options.replace(camera=keys))
    with pytest.raises(ls.InvalidInput, match="the run has 5 frames"):
        fitted_camera(run, options, frames=[7])


def test_a_turntable_ends_where_it_began(run):
    camera = turntable(run, ls.Camera(), degrees=360.0)
    spacing = run[1].time - run[0].time
    assert camera.turn == pytest.approx(360.0 / (len(run) * spacing))
    assert turntable(run, ls.Camera(), degrees=1.0 * ls.units.turn) == camera
    options = ls.RenderOptions(width=64, height=36, camera=camera, shadows=False)
    renderer = ls.pictures.Renderer(run.topology, options)
    renderer.fit(run[0])
    start = renderer.surfaces(run[0])[0]
    assert not np.array_equal(start, renderer.surfaces(run[1])[0])


def test_the_camera_of_the_command_line_is_that_of_the_options(run, tmp_path):
    place = ["--eye", "0.3", "-1.5", "0.4", "--target", "0.1", "0", "-0.1", "--fov", "30"]
    assert render(run, *place, "--out", tmp_path / "a")[0] == 0
    camera = ls.Camera(
        fit=False, eye=(0.3, -1.5, 0.4), target=(0.1, 0, -0.1), field_of_view_degrees=30
    )
    options = ls.RenderOptions(width=160, height=90, camera=camera)
    ls.pictures.render_run(run, options, out=tmp_path / "b", jobs=1)
    file = tmp_path / "camera.json"
    file.write_text(json.dumps({"eye": [0.3, -1.5, 0.4], "target": [0.1, 0, -0.1]}))
    assert render(run, "--camera", file, "--fov", 30, "--out", tmp_path / "c")[0] == 0
    pictures = [sorted((tmp_path / name).glob("*.png")) for name in "abc"]
    assert len(pictures[0]) == 5
    for one, other, third in zip(*pictures, strict=True):
        assert one.read_bytes() == other.read_bytes() == third.read_bytes()


def test_the_camera_of_the_command_line_can_look_straight_down(run, tmp_path):
    code, said = render(run, "--eye", 0, 0, 3, "--target", 0, 0, 0, "--frame", 0, "--out", tmp_path)
    assert code == 0, said
    assert (tmp_path / "frame-00000.png").exists()


def test_a_target_without_an_eye_is_refused_in_one_sentence(run, tmp_path):
    code, said = render(run, "--target", 0, 0, 0, "--frame", 0, "--out", tmp_path)
    assert code == 1 and said.startswith("loomstone: --target needs --eye"), said


def test_a_camera_path_is_kept_with_the_pictures(run, tmp_path):
    file = tmp_path / "path.json"
    keys = {"times": [0, 0.16], "eyes": [[1, -2, 1], [-1, -2, 1]], "targets": [[0, 0, 0]] * 2}
    file.write_text(json.dumps(keys))
    assert render(run, "--camera", file, "--out", tmp_path / "a")[0] == 0
    kept = ls.pictures.directory.drawn_with(tmp_path / "a").camera
    assert np.array_equal(kept.eyes, keys["eyes"]) and kept == read_camera(file)
    first, *_, last = sorted((tmp_path / "a").glob("*.png"))
    assert first.read_bytes() != last.read_bytes()
    assert render(run, "--camera", file, "--out", tmp_path / "a")[0] == 0


@pytest.mark.parametrize(
    "text, said",
    [
        (None, "the camera cannot be read: No such file"),
        ("{", "must be JSON with fields of Camera"),
        ("[1]", "must be a JSON object"),
        ('{"eyee": [1, 1, 1]}', "did you mean 'eye'"),
        ('{"eye": "here"}', "eye"),
    ],
)
def test_a_wrong_camera_file_is_refused_in_one_sentence(run, tmp_path, text, said):
    file = tmp_path / "camera.json"
    if text is not None:
        file.write_text(text)
    code, output = render(run, "--camera", file, "--out", tmp_path / "a")
    assert code == 1 and said in output and "Traceback" not in output


def test_quiet_prints_nothing(run, tmp_path):
    assert render(run, "--frame", 0, "--quiet", "--out", tmp_path) == (0, "")


def test_the_turn_of_a_camera_is_an_angle_per_time():
    assert ls.Camera(turn=90).turn == 90.0
    assert ls.Camera(turn=90 * ls.units["deg/s"]).turn == pytest.approx(90.0)
    assert ls.Camera(turn=1 * ls.units["rpm"]).turn == pytest.approx(6.0)


@pytest.mark.parametrize("first", [[0, -1, 4], [0, 3000, 4], [0, -(10**9), 4]])
def test_curves_whose_points_do_not_follow_each_other_are_refused(hanging, first):
    sim = ls.Simulation(hanging, threads=1)
    renderer = ls.pictures.Renderer(sim.topology, ls.RenderOptions(width=64, height=48, samples=1))
    curves = ls.pictures.Curves(np.eye(4, 3), first, np.zeros(4), 0.01)
    with pytest.raises(ls.InvalidInput, match="must ascend from 0"):
        renderer.render(sim.frame(), curves)
