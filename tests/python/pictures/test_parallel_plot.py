"""The plot of parallel work shows means of runs on equally many ranks, and separate lines for
measured and for replayed speed-ups.
"""

import csv
import json
import math
import shutil

import loomstone as ls
import matplotlib.figure
import numpy as np
import pytest
from loomstone.cli import app
from loomstone.pictures.parallel import ParallelRun, Replayed, plot_parallel
from loomstone.runs.parallel import read_parallel
from loomstone.runs.steps import read_steps
from typer.testing import CliRunner

FRAMES = np.array([0.1, 0.2])


def made(ranks, collision, waiting=0.0, decomposition="predicted", **changed):
    """A run of two frames. For each frame, collision handling takes `collision` [s], of which
    `waiting` [s] are waiting; both are means over the ranks.
    """
    values = {
        "name": f"{ranks}",
        "ranks": ranks,
        "decomposition": decomposition,
        "frames": FRAMES,
        "collision": np.full(2, collision),
        "collision_waiting": np.full(2, waiting),
        "parts": (1.0, 2.0, 2 * collision, 0.5),
        "waiting": 0.25,
    }
    return ParallelRun(**values | changed)


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


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


def test_runs_on_equally_many_ranks_are_averaged(drawn, tmp_path):
    runs = [made(1, 4.0), *(made(4, 2.0, waiting) for waiting in (0.2, 0.4, 0.6))]
    plot_parallel(runs, tmp_path / "parallel.png", title="three runs")
    used, times, faster, parts, communication, _ = drawn[-1].axes
    assert lines(used)["4 ranks, predicted"].get_ydata() == pytest.approx([80, 80])
    assert lines(times)["4 ranks, predicted"].get_ydata() == pytest.approx([2000, 2000])
    assert lines(faster).keys() == {"4 ranks, predicted"}
    assert lines(faster)["4 ranks, predicted"].get_ydata() == pytest.approx([2, 2])
    assert "mean of 3 runs" in parts.get_title()
    preprocessing = parts.containers[0]
    assert [bar.get_height() for bar in preprocessing] == [1, 1]
    whole, collision = communication.containers
    assert [bar.get_height() for bar in whole] == [25, 25]
    assert [bar.get_height() for bar in collision] == pytest.approx([0, 20])
    assert drawn[-1].get_suptitle() == "three runs"


def test_measured_and_replayed_points_are_drawn_apart(drawn, tmp_path):
    replayed = (Replayed("predicted", [1, 2, 64], [1.0, 1.9, 40.0]),)
    runs = [made(1, 4.0, replayed=replayed), made(2, 2.5)]
    plot_parallel(runs, tmp_path / "parallel.png")
    found = lines(drawn[-1].axes[5])
    measured, predicted = found["predicted, measured"], found["predicted, replayed"]
    assert list(measured.get_ydata()) == pytest.approx([1, 1.6])
    assert list(predicted.get_xdata()) == [1, 2, 64]
    assert measured.get_linestyle() == "-" and predicted.get_linestyle() == "--"
    assert measured.get_markerfacecolor() != "w" == predicted.get_markerfacecolor()
    assert list(found["ideal"].get_xdata()) == [1, 64]


def test_frames_without_collision_handling_have_no_utilization(drawn, tmp_path):
    run = made(2, 0.0)
    plot_parallel([run], tmp_path / "parallel.png")
    assert np.isnan(drawn[-1].axes[0].lines[0].get_ydata()).all()
    assert "needs runs on one" in drawn[-1].axes[2].texts[0].get_text()


def test_runs_of_different_lengths_are_refused(tmp_path):
    with pytest.raises(ls.InvalidInput, match="1 has 2 frames and 2 has 1"):
        plot_parallel([made(1, 1.0), made(2, 1.0, frames=FRAMES[:1])], tmp_path / "parallel.png")
    with pytest.raises(ls.InvalidInput, match="at least one run"):
        plot_parallel([], tmp_path / "parallel.png")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Directory of a run of three frames after the initial one, which records the motion of
    surfaces in every fifth step.
    """
    out = tmp_path_factory.mktemp("finished") / "run"
    mesh = ls.grid(size=(0.2, 0.2), cells=(6, 6)).moved((0, 0, 0.104))
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh)], obstacles=[ls.sphere(radius=0.1)])
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
    sim.run(out=out, duration=0.06, rate=50, record_tasks=5)
    return out


def command(*arguments):
    return CliRunner().invoke(app, [str(each) for each in arguments])


def test_the_command_plots_a_run_with_its_replay(finished):
    assert command("replay", finished, "--ranks", "1,4").exit_code == 0
    done = command("plot", finished, "--what", "parallel")
    assert done.exit_code == 0, done.output
    assert (finished / "parallel.png").stat().st_size > 20000
    run, steps = read_parallel(finished), read_steps(finished)
    assert run.frames == pytest.approx([0.02, 0.04, 0.06])
    assert run.collision.sum() == pytest.approx(steps["ranks.collision_computing"].sum())
    assert run.waiting == 0 and not run.collision_waiting.any()
    assert run.parts[0] > 0
    assert [each.decomposition for each in run.replayed] == ["predicted", "static", "dynamic"]
    assert all(each.ranks == [1, 4] for each in run.replayed)


def test_bad_input_gets_one_sentence(finished, tmp_path):
    done = command("plot", finished, finished)
    assert done.exit_code == 2 and "only --what parallel plots several runs, got 2" in done.output
    copied = shutil.copytree(finished, tmp_path / "copied")
    (copied / "replay.csv").write_text("ranks,decomposition\n1,static\n")
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and "is not a table of predictions" in done.output
    report = json.loads((copied / "report.json").read_text())
    del report["preparation_seconds"]
    (copied / "report.json").write_text(json.dumps(report))
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and "has no preparation_seconds; run the scene again" in done.output
    (copied / "report.json").unlink()
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and "has no report.json" in done.output


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ranks", 0),
        ("ranks", "two"),
        ("ranks", True),
        ("decomposition", "slices"),
        ("preparation_seconds", None),
        ("preparation_seconds", math.nan),
    ],
)
def test_unusable_entries_of_a_report_are_named(finished, tmp_path, name, value):
    copied = shutil.copytree(finished, tmp_path / "copied")
    report = json.loads((copied / "report.json").read_text())
    (copied / "report.json").write_text(json.dumps(report | {name: value}))
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and f"report.json: cannot use {name} =" in done.output


def test_a_report_that_is_no_object_is_refused(finished, tmp_path):
    copied = shutil.copytree(finished, tmp_path / "copied")
    (copied / "report.json").write_text("[1]")
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and "must be a JSON object" in done.output


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table[:1], "has no steps"),
        (lambda table: without(table, "seconds.integrate"), "has no column seconds.integrate"),
        (lambda table: without(table, "ranks.waiting"), "has no column ranks.waiting"),
        (lambda table: with_last(table, "ranks.waiting", "nan"), "ranks.waiting must be finite"),
        (lambda table: with_last(table, "time", "0.001"), "time must increase"),
        (lambda table: with_last(table, "time", "1e9"), "must end with the last frame"),
    ],
)
def test_damaged_tables_of_steps_are_refused(finished, tmp_path, change, message):
    copied = shutil.copytree(finished, tmp_path / "copied")
    with (copied / "steps.csv").open(newline="") as file:
        table = list(csv.reader(file))
    with (copied / "steps.csv").open("w", newline="") as file:
        csv.writer(file).writerows(change(table))
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and "steps.csv" in done.output and message in done.output


def without(table, name):
    column = table[0].index(name)
    return [row[:column] + row[column + 1 :] for row in table]


def with_last(table, name, value):
    column = table[0].index(name)
    return [*table[:-1], [value if i == column else cell for i, cell in enumerate(table[-1])]]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("ranks", "-4", "must be finite"),
        ("seconds", "inf", "must be finite"),
        ("decomposition", "slices", "unknown decomposition"),
    ],
)
def test_unusable_predictions_are_refused(finished, tmp_path, name, value, message):
    assert command("replay", finished, "--ranks", "1,4").exit_code == 0
    copied = shutil.copytree(finished, tmp_path / "copied")
    with (copied / "replay.csv").open(newline="") as file:
        table = list(csv.reader(file))
    with (copied / "replay.csv").open("w", newline="") as file:
        csv.writer(file).writerows(with_last(table, name, value))
    done = command("plot", copied, "--what", "parallel")
    assert done.exit_code == 1 and "is not a table of predictions" in done.output
    assert message in done.output


def test_long_titles_stay_inside_the_picture(drawn, tmp_path):
    plot_parallel([made(1, 1.0)], tmp_path / "parallel.png", title="parameters " * 40)
    figure = drawn[-1]
    figure.canvas.draw()
    assert figure._suptitle.get_window_extent().width <= figure.bbox.width
