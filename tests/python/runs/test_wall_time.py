"""The wall time of a run is the sum over the processes that began, resumed or extended it."""

import json
import signal

import loomstone as ls
import pytest
from loomstone.runs.signals import Interrupted


def made(scene, euler):
    return ls.Simulation(scene, integrator=euler, threads=1)


def noted(out):
    return json.loads((out / "wall_time.json").read_text())["wall_seconds"]


def test_a_continued_run_adds_the_time_of_earlier_processes(hanging, euler, tmp_path):
    out = tmp_path / "out"

    def stop(sim):
        if sim.step_index == 15:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        made(hanging, euler).run(out=out, duration=0.2, control=stop)
    assert 0.0 < noted(out) < 60.0
    (out / "wall_time.json").write_text(json.dumps({"wall_seconds": 1000.0}))
    report = made(hanging, euler).run(out=out, duration=0.2, resume=True, control=lambda sim: None)
    own = report["wall_seconds_of_this_process"]
    assert 0.0 < own < 1000.0 and report["wall_seconds"] == 1000.0 + own
    assert noted(out) > 1000.0


@pytest.mark.parametrize("noted", ["NaN", "Infinity", '"long"', ""])
def test_a_damaged_note_of_the_time_counts_as_none(hanging, euler, tmp_path, noted):
    out = tmp_path / "out"
    made(hanging, euler).run(out=out, duration=0.04)
    (out / "wall_time.json").write_text(f'{{"wall_seconds": {noted}}}')
    (out / "report.json").unlink()
    report = made(hanging, euler).run(out=out, duration=0.08, resume=True)
    assert report["wall_seconds"] == report["wall_seconds_of_this_process"]


def test_a_resumed_run_that_is_finished_keeps_its_time(hanging, euler, tmp_path):
    out = tmp_path / "out"
    first = made(hanging, euler).run(out=out, duration=0.08)
    (out / "wall_time.json").unlink()  # as if written by an older version
    again = made(hanging, euler).run(out=out, duration=0.08, resume=True)
    assert again["steps_of_this_process"] == 0
    assert again["wall_seconds"] >= first["wall_seconds"]
    new = made(hanging, euler).run(out=out, duration=0.08, overwrite=True)
    assert new["wall_seconds"] == new["wall_seconds_of_this_process"]


def test_a_process_ended_by_a_signal_keeps_its_time(hanging, euler, tmp_path):
    def stop(sim):
        if sim.step_index == 3:
            signal.raise_signal(signal.SIGTERM)

    with pytest.raises(Interrupted):
        made(hanging, euler).run(out=tmp_path / "out", duration=0.2, control=stop)
    assert noted(tmp_path / "out") > 0.0
