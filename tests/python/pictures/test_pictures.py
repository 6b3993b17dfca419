"""The picture of a frame depends on the run and the options, but neither on when it is drawn nor on
which other frames are drawn. A directory never mixes pictures of different runs or options, and a
command that is refused deletes no pictures.
"""

import itertools
import json
import shutil

import loomstone as ls
import numpy as np
import pytest
from loomstone.cli import app
from loomstone.pictures import encode, fitted_camera, render_run
from loomstone.pictures.directory import drawn_with
from PIL import Image
from typer.testing import CliRunner

FIT = ls.RenderOptions(width=96, height=54, samples=1, shadows=False, ambient_occlusion=False)
PLAIN = FIT.replace(camera=ls.Camera(fit=False, eye=(0.4, -0.5, 0.3), target=(0.1, 0.1, -0.1)))


@pytest.fixture(scope="module")
def scene():
    """A cloth pinned along one edge swings down. Cameras fitted to different frames differ."""
    return ls.Scene(
        cloths=[ls.Cloth(mesh=ls.grid(size=(0.2, 0.2), cells=(4, 4)), pins=[0, 1, 2, 3, 4])]
    )


def simulate(scene, out, duration=0.16, **options):
    """Simulates with long steps, writes a run (by default with 5 frames) and returns its report."""
    return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=8e-3), threads=1).run(
        out=out, duration=duration, **options
    )


@pytest.fixture(scope="module")
def drawn(scene, tmp_path_factory):
    """Directory of a run whose pictures were drawn during the simulation."""
    out = tmp_path_factory.mktemp("drawn") / "run"
    simulate(scene, out, render=FIT)
    return out


@pytest.fixture
def copied(drawn, tmp_path):
    """A copy of the run `drawn` that may be changed."""
    return shutil.copytree(drawn, tmp_path / "run")


def pictures(directory):
    return {
        path.name: np.asarray(Image.open(path)) for path in sorted(directory.glob("frame-*.png"))
    }


def same(one, other):
    return one.keys() == other.keys() and all(
        np.array_equal(one[name], other[name]) for name in one
    )


def stopped_after(frames, scene, out, **options):
    """Starts a run that an exception ends after the given number of frames."""

    def kill(sim):
        if sim.time > (frames - 1) * 0.04 + 1e-6:
            raise RuntimeError("killed")

    with pytest.raises(RuntimeError):
        simulate(scene, out, control=kill, **options)
    assert len(ls.Run(out)) == frames


def render(*arguments):
    done = CliRunner().invoke(app, ["render", *map(str, arguments), "--jobs", "1"])
    return done.exit_code, done.output


@pytest.mark.parametrize("jobs", [1, 2])
def test_pictures_drawn_afterwards_are_those_drawn_while_it_ran(drawn, tmp_path, jobs):
    paths = render_run(ls.Run(drawn), FIT, out=tmp_path / "again", jobs=jobs)
    assert [path.name for path in paths] == [f"frame-{i:05d}.png" for i in range(5)]
    assert same(pictures(tmp_path / "again"), pictures(drawn / "frames"))


def test_a_single_picture_is_that_of_the_sequence_and_touches_none_of_it(copied):
    before = pictures(copied / "frames")
    code, said = render(copied, "--frame", 3)
    assert code == 0 and str(copied / "frame-00003.png") in said
    assert np.array_equal(pictures(copied)["frame-00003.png"], before["frame-00003.png"])
    assert render(copied, "--frame", -1, "--wireframe", "--out", copied / "lines")[0] == 0
    assert same(pictures(copied / "frames"), before) and list(pictures(copied / "lines")) == [
        "frame-00004.png"
    ]
    code, said = render(copied, "--frame", 0, "--out", copied / "frames")
    assert code == 1 and "holds the pictures of a whole run" in said


@pytest.mark.parametrize("frames", [1, 3])
def test_a_resumed_run_has_the_pictures_of_one_that_was_not_interrupted(
    scene, drawn, tmp_path, frames
):
    stopped_after(frames, scene, tmp_path / "run", render=FIT)
    report = simulate(scene, tmp_path / "run", resume=True, render=True, control=lambda _: None)
    assert same(pictures(tmp_path / "run" / "frames"), pictures(drawn / "frames")) and report[
        "video"
    ].endswith("video.mp4")


def test_pictures_asked_for_late_are_drawn_from_the_cache_before_the_video(scene, drawn, tmp_path):
    stopped_after(3, scene, tmp_path / "run")
    simulate(scene, tmp_path / "run", resume=True, render=FIT, control=lambda _: None)
    assert same(pictures(tmp_path / "run" / "frames"), pictures(drawn / "frames"))
    (tmp_path / "run" / "frames" / "frame-00001.png").unlink()
    report = simulate(scene, tmp_path / "run", resume=True, render=True)  # on a finished run
    assert same(pictures(tmp_path / "run" / "frames"), pictures(drawn / "frames"))
    assert (tmp_path / "run" / "video.mp4").stat().st_size > 500 and report["frames"] == 5


def test_a_video_lacks_no_frame(copied, tmp_path):
    (copied / "frames" / "frame-00002.png").unlink()
    with pytest.raises(ls.CacheError, match="has none of frame 2"):
        encode(copied / "frames", tmp_path / "video.mp4", frames=5)
    code, said = render(copied)
    assert code == 0 and len(pictures(copied / "frames")) == 5, said


def test_a_run_remembers_the_options_of_its_pictures(copied):
    assert "scene_file" not in ls.Run(copied).metadata and drawn_with(copied / "frames") == FIT
    times = {path: path.stat().st_mtime_ns for path in (copied / "frames").glob("*.png")}
    code, said = render(copied)
    assert code == 0 and "(5)" in said
    assert times == {path: path.stat().st_mtime_ns for path in (copied / "frames").glob("*.png")}, (
        "what is there is kept"
    )


def test_other_options_neither_delete_nor_mix_pictures(scene, copied):
    before = pictures(copied / "frames")
    code, said = render(copied, "--width", 64, "--wireframe")
    assert code == 1 and "width 96 instead of 64" in said and "--out" in said and "--again" in said
    with pytest.raises(
        ls.InvalidInput, match="other options, camera .*; move it away, so that resuming draws all"
    ):
        simulate(scene, copied, resume=True, render=PLAIN)
    with pytest.raises(ls.InvalidInput, match="color_by must be"):
        render_run(ls.Run(copied), FIT.replace(color_by="mood"), again=True)
    assert same(pictures(copied / "frames"), before)
    assert render(copied, "--width", 64, "--out", copied / "small")[0] == 0
    assert (copied / "small" / "video.mp4").exists() and same(pictures(copied / "frames"), before)
    assert render(copied, "--width", 64, "--again")[0] == 0
    assert same(pictures(copied / "frames"), pictures(copied / "small"))
    simulate(scene, copied, duration=0.24, resume=True, render=True)
    shapes = {image.shape for image in pictures(copied / "frames").values()}
    assert len(pictures(copied / "frames")) == 7 and shapes == {(54, 64, 3)}


def test_pictures_of_a_run_with_another_control_function_are_not_kept(scene, tmp_path):
    def pull(sim):
        sim.external_forces = np.full_like(sim.positions, 1e-3)

    for name, control in (("still", lambda sim: None), ("pulled", pull)):
        simulate(scene, tmp_path / name, duration=0.08, control=control)
    shown = ("--width", 64, "--out", tmp_path / "pictures")
    assert render(tmp_path / "still", *shown)[0] == 0
    code, said = render(tmp_path / "pulled", *shown)
    assert code == 1 and "pictures of another run" in said


@pytest.mark.parametrize("name", ["100 %d", "12:30", "%05d"])
def test_a_directory_with_a_special_name_gets_a_video(drawn, tmp_path, name):
    shutil.copytree(drawn, tmp_path / name)
    code, said = render(tmp_path / name, "--width", 64, "--out", tmp_path / name / "small")
    assert code == 0, said
    assert (tmp_path / name / "small" / "video.mp4").stat().st_size > 0


def test_a_video_of_unknown_origin_is_not_replaced(copied, tmp_path):
    (tmp_path / "video.mp4").write_bytes(b"a film")
    code, said = render(copied, "--width", 64, "--out", tmp_path)
    assert code == 1 and "video.mp4 but no options.json" in said
    assert (tmp_path / "video.mp4").read_bytes() == b"a film"


def test_pictures_of_unknown_origin_are_not_touched(copied):
    for wrong in ("{", "[]", '{"options": []}', '{"options": {"camera": []}, "run": ""}'):
        (copied / "frames" / "options.json").write_text(wrong)
        code, said = render(copied)
        assert code == 1 and "no options.json" in said and len(pictures(copied / "frames")) == 5
    (copied / "frames" / "options.json").write_text(
        json.dumps({"options": FIT.to_dict(), "run": "another"})
    )
    code, said = render(copied)
    assert code == 1 and "pictures of another run" in said and len(pictures(copied / "frames")) == 5


def test_pictures_of_a_run_of_another_scene_with_the_same_options_are_not_kept(tmp_path):
    def simulated(name, density):
        mesh = ls.grid(size=(0.2, 0.2), cells=(2, 2))
        sheet = ls.Cloth(mesh=mesh, material=ls.ClothMaterial(density=density), pins=[0])
        simulate(ls.Scene(cloths=[sheet]), tmp_path / name, duration=0.08)
        return tmp_path / name

    light, heavy, again = simulated("light", 0.1), simulated("heavy", 0.3), simulated("light2", 0.1)
    shown = ("--width", 64, "--out", tmp_path / "pictures")
    assert render(light, *shown)[0] == 0
    assert render(again, *shown)[0] == 0, "the same run, simulated again"
    code, said = render(heavy, *shown)
    assert code == 1 and "pictures of another run" in said


def test_a_run_whose_pictures_are_given_other_options_meanwhile_leaves_them_alone(
    scene, drawn, tmp_path
):
    out, draws = tmp_path / "run", itertools.count()

    def other(sim):
        if next(draws) == 7:  # between the second and the third frame
            render_run(
                ls.Run(shutil.copytree(out, tmp_path / "seen")),
                PLAIN,
                out=tmp_path / "other",
                jobs=1,
            )
            shutil.rmtree(out / "frames")
            shutil.copytree(tmp_path / "other", out / "frames")

    report = simulate(scene, out, control=other, render=FIT)
    assert "video" not in report and len(pictures(out / "frames")) == 2
    assert same(pictures(out / "frames"), pictures(tmp_path / "other"))


def test_a_picture_without_an_end_is_drawn_again(drawn, tmp_path):
    paths = render_run(ls.Run(drawn), FIT, out=tmp_path, jobs=1)
    whole = [path.read_bytes() for path in paths]
    paths[0].write_bytes(whole[0][:1000])
    paths[1].write_bytes(b"")
    render_run(ls.Run(drawn), FIT, out=tmp_path, jobs=1)
    assert [path.read_bytes() for path in paths] == whole


def test_automatic_colours_are_one_range_for_the_whole_run(scene, drawn, tmp_path):
    run, look = ls.Run(drawn), FIT.replace(color_by="cloth+stretch")
    paths = render_run(run, look, out=tmp_path / "all", jobs=1)
    renderer = ls.pictures.Renderer(run.topology, look)
    values = np.array([renderer.value_ranges(frame)[1] for frame in run])
    low, high = values[:, 0].min(), values[:, 1].max()
    assert high > values[0, 1], "the range of the first frame is too small"
    render_run(run, look.replace(color_low=low, color_high=high), out=tmp_path / "given", jobs=1)
    assert same(pictures(tmp_path / "all"), pictures(tmp_path / "given"))
    fitted = look.replace(camera=fitted_camera(run, look))
    render_run(run, fitted, out=tmp_path / "single", frames=[1], jobs=1)
    assert np.array_equal(
        pictures(tmp_path / "single")[paths[1].name], pictures(tmp_path / "all")[paths[1].name]
    )
    simulate(scene, tmp_path / "run", render=look)
    assert same(pictures(tmp_path / "run" / "frames"), pictures(tmp_path / "all"))
    before = pictures(tmp_path / "run" / "frames")
    # The new frames extend the range of the stretch, so all pictures are redrawn.
    simulate(scene, tmp_path / "run", duration=0.32, resume=True, render=True)
    after = pictures(tmp_path / "run" / "frames")
    fresh = render_run(ls.Run(tmp_path / "run"), look, out=tmp_path / "fresh", jobs=1)
    assert len(fresh) == 9 and same(after, pictures(tmp_path / "fresh"))
    assert not np.array_equal(after["frame-00001.png"], before["frame-00001.png"])


def test_a_signal_ends_drawing_and_resuming_goes_on(scene, drawn, tmp_path):
    simulate(scene, tmp_path / "run")
    asked = itertools.count()
    paths = render_run(ls.Run(tmp_path / "run"), FIT, jobs=1, stop=lambda: next(asked) >= 2)
    assert [path.exists() for path in paths] == [True, True, False, False, False]
    simulate(scene, tmp_path / "run", resume=True, render=True)
    assert same(pictures(tmp_path / "run" / "frames"), pictures(drawn / "frames"))


def test_overwriting_a_run_takes_its_pictures_with_it(scene, copied):
    simulate(scene, copied, duration=0.04, overwrite=True, render=PLAIN)
    assert len(pictures(copied / "frames")) == 2 and drawn_with(copied / "frames") == PLAIN


def test_a_file_in_the_place_of_pictures_is_one_clear_error(copied):
    (copied / "file").write_text("")
    code, said = render(copied, "--out", copied / "file")
    assert code == 1 and "must be a directory" in said
