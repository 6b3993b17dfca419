"""Runs in directories: frames, checkpoints, tables, pictures, and resuming."""

import json
import os
import shutil
import signal

import loomstone as ls
import matplotlib.figure
import numpy as np
import pytest
from loomstone import _core
from loomstone.cli import inspection
from loomstone.integrators import with_method
from loomstone.pictures import plots
from loomstone.pictures.directory import options_from_dict
from loomstone.runs import checkpoints, execution, progress, signals
from loomstone.runs.execution import execute
from loomstone.runs.options import RunOptions
from loomstone.runs.parameters import parse_parameters
from loomstone.runs.scene_file import SceneFile
from loomstone.runs.steps import read_steps


@pytest.fixture
def run(hanging, euler, tmp_path):
    """The directory of a finished run of 0.12 s."""
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=tmp_path / "run", duration=0.12)
    return tmp_path / "run"


def test_a_run_leaves_frames_checkpoints_steps_and_a_report(run):
    frames = ls.Run(run)
    assert (
        len(frames) == 4
        and frames.times == pytest.approx([0, 0.04, 0.08, 0.12])
        and frames.metadata["rate"] == 25.0
    )
    assert (
        len(list(frames)) == 4
        and frames[-1].time == pytest.approx(0.12)
        and repr(frames).endswith("4 frames, to 0.12 s)")
    )
    assert frames.topology.triangles.shape == (128, 3)
    assert frames.intersecting_pairs() == [] and frames.surface()[1].shape == (128, 3)
    with pytest.raises(IndexError):
        frames[4]
    assert len(checkpoints.checkpoint_files(run)) == 2
    steps = read_steps(run)
    assert list(steps["step"]) == list(range(1, 31)) and steps["solver.linear_iterations"].min() > 0
    report = json.loads((run / "report.json").read_text())
    assert report["steps"] == 30 and set(report["seconds_per_stage"]) >= {"integrate", "certify"}


def test_a_run_says_once_that_cloth_was_pinched_and_records_every_step_of_it(
    pressed, tmp_path, capsys
):
    sim = ls.Simulation(pressed, integrator=ls.SemiImplicitEuler(step=0.01), threads=1)
    report = execute(sim, RunOptions(duration=0.08), tmp_path, observer=progress.Lines())
    lines = [
        line
        for line in capsys.readouterr().out.splitlines()
        if "impacts remain at 1/64 of the step" in line
    ]
    steps = read_steps(tmp_path)
    first = int(np.flatnonzero(steps["contacts.unresolved"])[0])
    assert lines[0].startswith(
        f"step {first + 1} (t 0.0{first + 1}0 s):"
        f" {int(steps['contacts.unresolved'][first])} impacts"
    )
    troubled = (steps["contacts.unresolved"] > 0) | (steps["contacts.intersections"] > 0)
    assert len(lines) == 1 and troubled[first:].any() and not troubled[:first].any()
    assert report["unresolved_steps"] == (steps["contacts.unresolved"] > 0).sum() > 0
    assert report["steps_in_parts"] == (steps["parts"] > 1).sum() > 0 and steps["parts"].max() <= 64
    assert report["most_intersections"] == steps["contacts.intersections"].max()
    assert "steps left impacts" in inspection.report_text(report)


def test_frames_in_the_file_are_those_of_the_simulation(run, hanging, euler):
    sim = ls.Simulation(hanging, integrator=euler, threads=1)
    for stored, live in zip(ls.Run(run), sim.frames(duration=0.12), strict=True):
        assert np.array_equal(stored.positions, live.positions) and np.array_equal(
            stored.velocities, live.velocities
        )
        assert (
            stored.report.contacts.near == live.report.contacts.near
            and stored.report.energy.kinetic == live.report.energy.kinetic
        )


def test_vtk_reads_the_frames_bit_for_bit(run):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(run / "run.vtkhdf"))
    reader.UpdateInformation()
    for index, frame in enumerate(ls.Run(run)):
        reader.SetStep(index)
        reader.Update()
        data = reader.GetOutput()
        assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), frame.positions)
        assert data.GetNumberOfPolys() == 128


def test_a_run_is_not_overwritten_unless_asked(run, hanging, euler):
    sim = ls.Simulation(hanging, integrator=euler)
    with pytest.raises(ls.CacheError, match="must hold no run yet"):
        sim.run(out=run, duration=0.04)
    sim.run(out=run, duration=0.04, overwrite=True)
    assert len(ls.Run(run)) == 2


def test_a_run_is_not_removed_for_one_whose_pictures_have_no_room(run, hanging, euler):
    shutil.rmtree(run / "frames", ignore_errors=True)
    (run / "frames").write_text("a file of the user")
    before = sorted(path.name for path in run.iterdir())
    with pytest.raises(ls.CacheError, match="frames must be a directory that can be written"):
        ls.Simulation(hanging, integrator=euler).run(
            out=run, duration=0.04, render=SMALL, overwrite=True
        )
    assert sorted(path.name for path in run.iterdir()) == before


@pytest.mark.parametrize("cut", [0, 1, 2])
def test_a_resumed_run_ends_in_the_same_bits(run, hanging, euler, cut):
    whole = ls.Run(run)[-1].positions.copy()
    digest = json.loads((run / "report.json").read_text())["digest"]
    # Removes the `cut` newest checkpoints, as if the run had been killed before writing them.
    for path in checkpoints.checkpoint_files(run)[2 - cut :]:
        path.unlink()
    report = ls.Simulation(hanging, integrator=euler).run(out=run, duration=0.12, resume=True)
    assert (
        report["digest"] == digest
        and np.array_equal(ls.Run(run)[-1].positions, whole)
        and len(ls.Run(run)) == 4
    )
    assert list(read_steps(run)["step"]) == list(range(1, 31))


def test_a_box_rides_on_an_obstacle_that_deforms_and_a_prolonged_run_ends_in_the_same_bits(
    tmp_path,
):
    floor = ls.meshes.floor(size=1.0, cells=4)
    times = np.linspace(0.0, 0.4, 41)
    waves = np.repeat(np.asarray(floor.vertices)[None], len(times), axis=0)
    # The surface tilts while it rises with an acceleration of 4 m/s^2 at x = 0.
    waves[:, :, 2] = 2.0 * times[:, None] ** 2 * (1.0 + waves[:, :, 0])
    scene = ls.Scene(
        bodies=[
            ls.RigidBody(
                mesh=ls.meshes.box(size=(0.1, 0.1, 0.1)),
                shape="box",
                position=(0, 0, 0.05),
                friction=0.9,
            )
        ],
        obstacles=[
            ls.Obstacle(
                name="floor",
                mesh=floor,
                times=times,
                vertex_positions=waves.reshape(-1, 3),
                friction=0.9,
            )
        ],
    )
    euler = ls.SemiImplicitEuler(step=2e-3)
    straight = ls.Simulation(scene, integrator=euler)
    for _ in range(200):
        straight.step()
    x, _, z = straight.body_centres[0]
    slope = 2.0 * 0.4**2
    # The body lies flat on the slope.
    assert z == pytest.approx(slope * (1.0 + x) + 0.05 * np.hypot(1.0, slope), abs=1e-3)
    assert straight.state.body_velocities[0][2] == pytest.approx(4.0 * 0.4 * (1.0 + x), rel=0.1)
    ls.Simulation(scene, integrator=euler).run(out=tmp_path / "a", duration=0.2)
    report = ls.Simulation(scene, integrator=euler).run(
        out=tmp_path / "a", duration=0.4, resume=True
    )
    assert report["digest"] == straight.digest()
    magnet = ls.magnetics.sphere(radius=0.01, polarization=(0, 0, 1))
    magnetic = ls.Scene(
        bodies=scene.bodies,
        obstacles=scene.obstacles,
        magnets=[ls.Magnet(body="floor", source=magnet)],
    )
    coiled = ls.Scene(
        bodies=scene.bodies,
        obstacles=scene.obstacles,
        coils=[ls.Coil(body="floor", source=ls.magnetics.loop(radius=0.01), currents=[1.0])],
    )
    for refused in (magnetic, coiled):
        with pytest.raises(ls.Unsupported, match="must keep its shape"):
            ls.Simulation(refused)


def test_a_run_can_be_prolonged(run, hanging, euler):
    report = ls.Simulation(hanging, integrator=euler).run(out=run, duration=0.2, resume=True)
    straight = ls.Simulation(hanging, integrator=euler)
    for _ in range(50):
        straight.step()
    assert report["digest"] == straight.digest() and len(ls.Run(run)) == 6
    again = ls.Simulation(hanging, integrator=euler).run(out=run, duration=0.08, resume=True)
    assert again["frames"] == 6 == len(ls.Run(run)), "a shorter duration removes no frames"


def test_a_run_that_begins_after_the_first_steps_can_be_prolonged(hanging, euler, tmp_path):
    sim, out = ls.Simulation(hanging, integrator=euler), tmp_path / "late"
    for _ in range(15):  # up to 0.06 s
        sim.step()
    report = sim.run(out=out, duration=0.2, rate=25)
    # Frames 0 and 1, at 0 and 0.04 s, precede the run.
    assert ls.Run(out).times == pytest.approx([0.08, 0.12, 0.16, 0.2])
    steps = read_steps(out)
    mean = steps["length"].sum() / steps["parts"].sum()
    assert report["frames"] == 4 and report["mean_part"] == pytest.approx(mean)
    longer = ls.Simulation(hanging, integrator=euler).run(
        out=out, duration=0.32, rate=25, resume=True
    )
    assert longer["frames"] == len(ls.Run(out)) == 7
    straight = ls.Simulation(hanging, integrator=euler)
    for _ in range(80):
        straight.step()
    assert longer["digest"] == straight.digest()
    with pytest.raises(ls.CacheError, match="rate must be that of the run, 25 frames/s, got 50"):
        ls.Simulation(hanging, integrator=euler).run(out=out, duration=0.4, rate=50.0, resume=True)


def test_a_run_is_not_continued_as_another(run, hanging, euler):
    stiff = hanging.cloths[0].replace(material=ls.ClothMaterial(weft_stiffness=500.0))
    for scene, integrator, differ in [
        (hanging.replace(gravity=(0, 0, 9.81)), euler, "scene.gravity"),
        (hanging.replace(cloths=[stiff]), euler, "scene.cloths"),
        (hanging, with_method(euler, "bdf2"), "integrator.method"),
    ]:
        with pytest.raises(
            ls.CacheError,
            match=(
                f"of another scene or integrator .these differ: {differ}.; continue with the scene"
                " and integrator of the run"
            ),
        ):
            ls.Simulation(scene, integrator=integrator).run(out=run, duration=0.2, resume=True)
    with pytest.raises(ls.CacheError, match="rate must be that of the run, 25 frames/s, got 50"):
        ls.Simulation(hanging, integrator=euler).run(out=run, duration=0.2, rate=50.0, resume=True)
    assert len(ls.Run(run)) == 4


def test_a_truncated_checkpoint_is_skipped_for_the_previous_one(run):
    newest = checkpoints.checkpoint_files(run)[-1]
    newest.write_bytes(newest.read_bytes()[:200])
    assert checkpoints.latest_checkpoint(run) is not None
    for path in checkpoints.checkpoint_files(run):
        path.write_bytes(b"noise")
    with pytest.raises(
        ls.CacheError, match="none of its checkpoints can be read.*Run the scene again"
    ):
        checkpoints.latest_checkpoint(run)


def test_files_that_are_no_runs_are_refused(tmp_path):
    with pytest.raises(ls.CacheError):
        ls.Run(tmp_path / "absent")
    (tmp_path / "run.vtkhdf").write_bytes(b"noise" * 100)
    with pytest.raises(ls.CacheError, match="run.vtkhdf"):
        ls.Run(tmp_path)
    with pytest.raises(ls.CacheError, match="steps.csv"):
        read_steps(tmp_path)


def test_frame_writer_refuses_an_impossible_directory(tmp_path, hanging):
    sim = ls.Simulation(hanging)
    (tmp_path / "file").write_text("")
    with pytest.raises(ls.CacheError):
        _core.FrameWriter(str(tmp_path / "file"), sim.topology, "")


def test_checkpoints_keep_arrays_integers_bytes_and_texts(falling, euler, tmp_path):
    kept = ls.Simulation(falling, integrator=euler).checkpoint()
    _core.write_checkpoint(str(tmp_path / "c.h5"), kept)
    again = _core.read_checkpoint(str(tmp_path / "c.h5"))
    assert kept.arrays.keys() == again.arrays.keys() and kept.integers == again.integers
    assert kept.bytes == again.bytes and kept.texts == again.texts
    assert all(np.array_equal(kept.arrays[name], again.arrays[name]) for name in kept.arrays)


@pytest.mark.parametrize("kind", plots.KINDS)
def test_every_plot_can_be_drawn(run, kind):
    assert plots.plot_steps(read_steps(run), run / f"{kind}.png", kind=kind).stat().st_size > 5000


@pytest.fixture
def drawn(monkeypatch):
    """Returns a list to which new matplotlib figures are added."""
    figures = []

    class Kept(matplotlib.figure.Figure):
        def __init__(self, *arguments, **keywords):
            super().__init__(*arguments, **keywords)
            figures.append(self)

    monkeypatch.setattr("matplotlib.figure.Figure", Kept)
    return figures


def legends(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_a_plot_has_a_title_and_words_and_no_series_that_is_always_0(run, drawn):
    steps = read_steps(run)
    steps["account.withheld"] = np.full_like(steps["time"], 1e-17)  # a rounding error
    plots.plot_steps(steps, run / "energy.png", kind="energy", title="out/a: b.py (cells=3)")
    assert drawn[-1].get_suptitle() == "out/a: b.py (cells=3)"
    words = legends(drawn[-1])
    assert "kinetic energy of cloth" in words and "sum of energies" in words
    assert not any(each in word for each in ("bodies", "magnetic", "withheld") for word in words)
    plots.plot_steps(steps, run / "iterations.png", kind="iterations")
    assert legends(drawn[-1]) == ["linear iterations", "Newton iterations"]
    plots.plot_steps(steps, run / "contacts.png", kind="contacts")
    assert [text.get_text() for text in drawn[-1].axes[0].texts] == ["all values are 0"]
    plots.plot_steps(steps, run / "stages.png", kind="stages")
    assert "integration of cloth" in legends(drawn[-1])


@pytest.mark.parametrize("kind", ["energy", "stages", "strain"])
def test_a_legend_covers_no_curve(run, drawn, kind):
    plots.plot_steps(read_steps(run), run / f"{kind}.png", kind=kind, title="title")
    (figure,) = drawn
    figure.canvas.draw()
    legend, axes = (part.get_window_extent() for part in (figure.legends[0], figure.axes[0]))
    assert len(legends(figure)) >= 2 and legend.y1 < axes.y0, "the legend is below the axes"
    assert legend.y0 >= 0 and axes.height >= 3 * figure.dpi


def test_words_of_legends_belong_to_columns_of_steps(run):
    assert plots.WORDS.keys() <= read_steps(run).keys()
    assert all(f"energy.{name}" in plots.WORDS for name in ls.StepReport().energy.to_dict())


def test_an_unknown_plot_is_refused(run):
    with pytest.raises(ls.InvalidInput, match="energy, stages"):
        plots.plot_steps(read_steps(run), run / "weather.png", kind="weather")


SMALL = ls.RenderOptions(width=160, height=90, samples=1)


def test_a_picture_shows_the_cloth(hanging, tmp_path):
    sim = ls.Simulation(hanging)
    renderer = ls.pictures.Renderer(sim.topology, SMALL)
    image = renderer.render(sim.frame())
    assert renderer.backend in ("osmesa", "egl")
    assert image.shape == (90, 160, 3) and image.dtype == np.uint8 and image.std() > 5
    ls.pictures.write_png(str(tmp_path / "a.png"), image)
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(
        ls.InvalidInput, match=r"image must have shape \(height, width, 3 or 4\), got \(90, 160\)"
    ):
        ls.pictures.write_png(str(tmp_path / "b.png"), image[:, :, 0])


def test_render_options_survive_json():
    options = SMALL.replace(camera=ls.Camera(eye=(1, 2, 3), fit=False))
    assert options_from_dict(json.loads(json.dumps(options.to_dict()))) == options


def test_parameters_are_read_as_python_literals_or_text():
    assert parse_parameters(["n=5000", "x=1.5", "name=silk", "m=5e3"]) == {
        "n": 5000,
        "x": 1.5,
        "name": "silk",
        "m": 5000,
    }
    with pytest.raises(ls.InvalidInput, match="name=value"):
        parse_parameters(["triangles"])


SCENE = """
import loomstone as ls
duration = 0.5
def integrator(cells=4): return ls.SemiImplicitEuler(step=0.01 / cells)
def scene(cells: int = 4, height: float = 0.0, fabric: str = "silk"):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(cells, cells)).moved((0, 0, height)))])
"""


def test_a_scene_file_gives_scene_and_options_for_its_parameters(tmp_path):
    (tmp_path / "s.py").write_text(SCENE)
    file = SceneFile.open(tmp_path / "s.py", {"cells": 5, "height": 1})
    assert file.scene().cloths[0].mesh.n_triangles == 50 and file.parameters["height"] == 1.0
    assert (file.duration, file.rate, file.integrator.step) == (0.5, 25.0, 0.002)
    assert file.control is None and file.check is None and file.render == ls.RenderOptions()


@pytest.mark.parametrize(
    "parameters, message",
    [
        ({"cell": 5}, "did you mean cells"),
        ({"cells": 5.5}, "must be an int like 4, got 5.5"),
        ({"zz": 1}, "known: cells"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(tmp_path, parameters, message):
    (tmp_path / "s.py").write_text(SCENE)
    with pytest.raises(ls.InvalidInput, match=message):
        SceneFile.open(tmp_path / "s.py", parameters)


def test_a_scene_file_must_define_a_scene(tmp_path):
    (tmp_path / "s.py").write_text("x = 1")
    with pytest.raises(ls.InvalidInput, match=r"must define a function scene\(\)"):
        SceneFile.open(tmp_path / "s.py", {})
    (tmp_path / "t.py").write_text("def scene(): return 3\nintegrator = 4\nrender = 5")
    file = SceneFile.open(tmp_path / "t.py", {})
    for wrong in (file.scene, lambda: file.integrator, lambda: file.render):
        with pytest.raises(ls.InvalidInput, match="must"):
            wrong()
    with pytest.raises(ls.CacheError, match="cannot be read"):
        SceneFile.open(tmp_path / "absent.py", {})


def test_a_signal_does_not_wait_long_for_a_step_that_can_be_saved(tmp_path, monkeypatch):
    ball = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.02, subdivisions=1),
        shape="sphere",
        position=(0, 0, 0.1),
    )
    scene = ls.Scene(bodies=[ball], obstacles=[ls.floor()], rigid_rebuild_interval=1000)
    settings = {"integrator": ls.SemiImplicitEuler(step=4e-3), "threads": 1}
    monkeypatch.setattr(execution, "LONGEST_WAIT", 0.0)

    def stop(sim):
        if sim.step_index == 15:
            os.kill(os.getpid(), signal.SIGTERM)

    interrupted = ls.Simulation(scene, **settings)
    with pytest.raises(signals.Interrupted):
        interrupted.run(out=tmp_path / "a", duration=0.2, control=stop)
    assert interrupted.step_index < 20
    resumed = ls.Simulation(scene, **settings).run(
        out=tmp_path / "a", duration=0.2, resume=True, control=lambda _: None
    )
    whole = ls.Simulation(scene, **settings).run(out=tmp_path / "b", duration=0.2)
    assert resumed["digest"] == whole["digest"] and len(ls.Run(tmp_path / "a")) == 6
    with pytest.raises(ls.InvalidInput, match=r"rigid_rebuild_interval must be in \[1, 1000\]"):
        ls.Scene(bodies=[ball], rigid_rebuild_interval=100_000)


def test_a_controlled_run_whose_end_was_not_saved_needs_its_control_function(tmp_path):
    ball = ls.RigidBody(mesh=ls.meshes.sphere(radius=0.1), shape="sphere", position=(0, 0, 0.3))
    scene = ls.Scene(bodies=[ball], obstacles=[ls.floor()])

    def run(**options):
        sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
        sim.run(out=tmp_path / "run", duration=0.2, **options)

    run(control=lambda _: None)
    # All frames exist, but the steps after the last checkpoint must be taken again.
    with pytest.raises(ls.CacheError, match="was run with a control function"):
        run(resume=True)
    run(resume=True, control=lambda _: None)


def test_a_run_with_bodies_may_end_between_the_steps_that_can_be_saved(tmp_path):
    ball = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.02, subdivisions=1),
        shape="sphere",
        position=(0, 0, 0.1),
    )
    scene = ls.Scene(bodies=[ball], obstacles=[ls.floor()])
    settings = {"integrator": ls.SemiImplicitEuler(step=4e-3), "threads": 1}
    # The run has 50 steps, with checkpoints at multiples of 40.
    report = ls.Simulation(scene, **settings).run(out=tmp_path / "b", duration=0.2)
    assert len(ls.Run(tmp_path / "b")) == 6 and report["steps"] == 50
    again = ls.Simulation(scene, **settings).run(out=tmp_path / "c", duration=0.2)
    assert report["digest"] == again["digest"]
    # The run resumes at step 40.
    prolonged = ls.Simulation(scene, **settings).run(out=tmp_path / "b", duration=0.32, resume=True)
    whole = ls.Simulation(scene, **settings).run(out=tmp_path / "d", duration=0.32)
    assert prolonged["digest"] == whole["digest"] and len(ls.Run(tmp_path / "b")) == 9
