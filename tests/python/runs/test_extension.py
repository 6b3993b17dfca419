"""Runs that are extended: to a longer duration, or with a control function."""

import json
import shutil

import loomstone as ls
import numpy as np
import pytest


def made(scene, euler):
    return ls.Simulation(scene, integrator=euler, threads=1)


def stopped_at(time):
    """Returns a control function that interrupts the run as soon as its time exceeds `time` [s]."""

    def stop(sim):
        if sim.time > time:
            raise KeyboardInterrupt

    return stop


class Interrupted(ls.Simulation):
    """A simulation that is interrupted after 35 steps."""

    def step(self):
        if self.step_index == 35:
            raise KeyboardInterrupt
        super().step()


@pytest.fixture
def interrupted(hanging, euler, tmp_path):
    """A finished run of 0.08 s whose extension to 0.2 s was interrupted at 0.14 s."""
    out = tmp_path / "run"
    made(hanging, euler).run(out=out, duration=0.08)
    extended = Interrupted(hanging, integrator=euler, threads=1)
    with pytest.raises(KeyboardInterrupt):
        extended.run(out=out, duration=0.2, resume=True)
    return out


def test_an_interrupted_extension_has_no_report_and_is_resumed_to_its_end(
    interrupted, hanging, euler, loomstone, tmp_path
):
    assert not (interrupted / "report.json").exists()
    assert ls.Run(interrupted).metadata["duration"] == 0.2
    code, _ = loomstone("resume", interrupted)
    assert code == 0 and len(ls.Run(interrupted)) == 6
    whole = made(hanging, euler).run(out=tmp_path / "whole", duration=0.2)
    report = json.loads((interrupted / "report.json").read_text())
    assert report["digest"] == whole["digest"] and report["frames"] == 6


def test_an_extension_has_the_frames_within_the_step_that_passed_the_former_end(hanging, tmp_path):
    def run(out, duration, **more):
        sim = ls.Simulation(hanging, threads=1)
        return sim.run(out=tmp_path / out, duration=duration, rate=500.0, verify=True, **more)

    assert run("extended", 0.1)["time"] > 0.1 + 1 / 500
    run("extended", 0.2, resume=True)
    run("whole", 0.2)
    extended, whole = ls.Run(tmp_path / "extended"), ls.Run(tmp_path / "whole")
    assert np.array_equal(extended.times, whole.times)
    assert all(
        np.array_equal(a.positions, b.positions) for a, b in zip(extended, whole, strict=True)
    )
    checks = [(tmp_path / out / "frames.csv").read_text() for out in ("extended", "whole")]
    assert checks[0] == checks[1]


@pytest.mark.parametrize("finished", [True, False])
def test_the_command_line_extends_a_run(hanging, euler, loomstone, tmp_path, finished):
    out = tmp_path / "run"
    if finished:
        made(hanging, euler).run(out=out, duration=0.08)
    else:
        with pytest.raises(KeyboardInterrupt):
            Interrupted(hanging, integrator=euler, threads=1).run(out=out, duration=0.16)
    code, _ = loomstone("resume", out, "--duration", "0.2")
    whole = made(hanging, euler).run(out=tmp_path / "whole", duration=0.2)
    assert code == 0 and ls.Run(out).metadata["duration"] == 0.2
    report = json.loads((out / "report.json").read_text())
    assert report["digest"] == whole["digest"] and report["frames"] == 6


def test_an_extension_shorter_than_the_run_is_refused(hanging, euler, loomstone, tmp_path):
    out = tmp_path / "run"
    made(hanging, euler).run(out=out, duration=0.08)
    for given, wanted in (("0.04", 1), ("nan", 2), ("-1", 2)):
        code, said = loomstone("resume", out, "--duration", given)
        assert code == wanted and "duration must be" in said.err
    for same in ("0.08", "0.07999999"):
        code, _ = loomstone("resume", out, "--duration", same)
        assert code == 0 and len(ls.Run(out)) == 3 and ls.Run(out).metadata["duration"] == 0.08


def test_the_wall_time_of_a_run_survives_an_interrupted_extension(hanging, euler, tmp_path):
    out = tmp_path / "run"
    first = made(hanging, euler).run(out=out, duration=0.08)
    with pytest.raises(KeyboardInterrupt):
        made(hanging, euler).run(out=out, duration=0.2, resume=True, control=stopped_at(0.07))
    noted = json.loads((out / "wall_time.json").read_text())["wall_seconds"]
    assert noted >= first["wall_seconds"]


def test_an_extension_with_a_control_function_is_not_continued_without_one(
    hanging, euler, tmp_path, loomstone
):
    out = tmp_path / "run"
    made(hanging, euler).run(out=out, duration=0.08)
    with pytest.raises(KeyboardInterrupt):
        made(hanging, euler).run(out=out, duration=0.2, resume=True, control=stopped_at(0.14))
    with pytest.raises(ls.CacheError, match="was run with a control function"):
        made(hanging, euler).run(out=out, duration=0.2, resume=True)
    code, said = loomstone("resume", out)
    assert code != 0 and "was run with a control function" in said.err
    made(hanging, euler).run(out=out, duration=0.2, resume=True, control=lambda sim: None)
    assert len(ls.Run(out)) == 6


def test_a_run_of_a_scene_file_with_control_is_not_continued_without_it(euler, tmp_path, loomstone):
    scene = tmp_path / "controlled.py"
    scene.write_text(
        "import loomstone as ls\n"
        "duration, integrator = 0.08, ls.SemiImplicitEuler(step=4e-3)\n"
        "def control(sim): pass\n"
        "def scene():\n"
        "    mesh = ls.grid(size=(0.2, 0.2), cells=(4, 4))\n"
        "    return ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=[0])])\n"
    )
    out = tmp_path / "run"
    assert loomstone("run", scene, "--out", out)[0] == 0
    again = ls.Simulation(ls.Run(out).scene(), integrator=euler, threads=1)
    with pytest.raises(ls.CacheError, match="was run with a control function"):
        again.run(out=out, duration=0.2, resume=True)


def test_a_new_run_forgets_the_extension_of_the_one_that_it_replaces(hanging, euler, tmp_path):
    out = tmp_path / "run"
    made(hanging, euler).run(out=out, duration=0.08)
    made(hanging, euler).run(out=out, duration=0.16, resume=True)
    assert ls.Run(out).metadata["duration"] == 0.16
    made(hanging, euler).run(out=out, duration=0.04, overwrite=True)
    assert ls.Run(out).metadata["duration"] == 0.04


def test_a_run_of_a_sweep_is_extended_only_as_a_copy(hanging, euler, loomstone, tmp_path):
    out, copy = tmp_path / "sweep" / "friction-0.1", tmp_path / "copy"
    made(hanging, euler).run(out=out, duration=0.08)
    (out.parent / "sweep.json").write_text("{}")
    code, said = loomstone("resume", out, "--duration", "0.2")
    assert code == 1 and "belongs to a sweep" in said.err
    shutil.copytree(out, copy)
    assert loomstone("resume", copy, "--duration", "0.2")[0] == 0 and len(ls.Run(copy)) == 6


@pytest.mark.parametrize(
    "text",
    ["{", "[]", '{"duration": "long"}', '{"duration": NaN}', '{"control": 1}', '{"rate": 1}'],
)
def test_a_damaged_extension_is_an_error_and_leaves_the_run_as_it_was(
    hanging, euler, tmp_path, text
):
    out = tmp_path / "run"
    made(hanging, euler).run(out=out, duration=0.04)
    before = (out / "report.json").read_text()
    (out / "extension.json").write_text(text)
    for control in (None, lambda sim: None):
        with pytest.raises(ls.CacheError, match="extension.json cannot be read: .*; remove it"):
            made(hanging, euler).run(out=out, duration=0.2, resume=True, control=control)
    (out / "extension.json").unlink()
    assert (out / "report.json").read_text() == before and len(ls.Run(out)) == 2


def test_a_new_run_is_not_continued_from_what_an_interrupted_removal_left(hanging, euler, tmp_path):
    out = tmp_path / "run"
    made(hanging, euler).run(out=out, duration=0.08)
    made(hanging, euler).run(out=out, duration=0.16, resume=True)
    (out / "run.vtkhdf").unlink()
    made(hanging, euler).run(out=out, duration=0.04, overwrite=True)
    assert ls.Run(out).metadata["duration"] == 0.04
    report = made(hanging, euler).run(out=out, duration=0.04, resume=True)
    assert report["frames"] == 2 and report["time"] == pytest.approx(0.04)


def test_a_run_that_is_stopped_while_it_is_reopened_has_no_report(
    hanging, euler, tmp_path, monkeypatch
):
    out = tmp_path / "run"
    first = made(hanging, euler).run(out=out, duration=0.08)

    def full(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("loomstone.runs.writer.StepTable", full)
    with pytest.raises(KeyboardInterrupt):
        made(hanging, euler).run(out=out, duration=0.2, resume=True)
    assert not (out / "report.json").exists()
    assert json.loads((out / "wall_time.json").read_text())["wall_seconds"] >= first["wall_seconds"]
