"""`loomstone sweep` runs all combinations of parameter values, can be interrupted at any moment and
continued later, and writes a table and plots of the results.
"""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
from loomstone import CacheError, InvalidInput
from loomstone.sweeps.plan import claim, first_values, open_with, parse_values, points_of

SCENE = """
import os
import time
import loomstone as ls
duration = 0.2
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene(cells: int = 6, friction: float = 0.3, slow: float = 0.0):
    global pause
    pause = slow
    cloth = ls.Cloth(mesh=ls.grid(size=(0.2, 0.2), cells=(cells, cells)), pins=[0],
                     friction=friction)
    return ls.Scene(cloths=[cloth])
def control(sim):
    time.sleep(pause)
"""


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE)
    return tmp_path / "scene.py"


def command(scene, out, *arguments):
    words = (sys.executable, "-m", "loomstone", "sweep", scene, "--out", out, *arguments)
    return list(map(str, words))


def sweep(scene, out, *arguments):
    return subprocess.run(
        command(scene, out, *arguments), capture_output=True, text=True, timeout=100
    )


def table(out):
    with (out / "table.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_sweep_runs_the_product_of_parameters_and_keeps_finished_runs(scene, tmp_path):
    out = tmp_path / "out"
    done = sweep(scene, out, "-p", "cells=4,6", "-p", "friction=0.1:0.3:2", "--plot", "steps")
    assert done.returncode == 0, done.stdout + done.stderr
    rows = table(out)
    assert [(row["cells"], row["friction"]) for row in rows] == [
        ("4", "0.1"),
        ("4", "0.3"),
        ("6", "0.1"),
        ("6", "0.3"),
    ]
    for row in rows:
        report = json.loads((out / row["run"] / "report.json").read_text())
        assert row["digest"] == report["digest"] and int(row["steps"]) == 50
        assert float(row["energy_at_end.kinetic"]) == report["energy_at_end"]["kinetic"]
    assert len({row["digest"] for row in rows}) >= 2 and (out / "figures.png").stat().st_size > 5000
    before = {path: path.stat().st_mtime_ns for path in out.glob("*/report.json")}
    more = sweep(scene, out, "-p", "cells=4,6", "-p", "friction=0.1,0.2,0.3")
    assert "6 runs" in more.stdout and "4 finished" in more.stdout
    assert len(table(out)) == 6
    assert all(path.stat().st_mtime_ns == when for path, when in before.items())


def test_an_interrupted_sweep_is_continued_to_the_same_bits(scene, tmp_path):
    whole, arguments = tmp_path / "whole", ("-p", "slow=0.0,0.02", "--jobs", "2")
    assert sweep(scene, whole, *arguments).returncode == 0
    for number in (signal.SIGTERM, signal.SIGKILL):
        out = tmp_path / number.name
        process = subprocess.Popen(
            command(scene, out, *arguments), stdout=subprocess.PIPE, text=True
        )
        slow = out / "slow-0.02"
        while not list(slow.glob("checkpoint-0000000010.h5")):
            assert process.poll() is None
            time.sleep(0.02)
        process.send_signal(number)
        said, _ = process.communicate(timeout=30)
        if number == signal.SIGTERM:
            assert process.returncode == 128 + number and "continue with" in said
            assert "stopped by SIGTERM" in (slow / "log.txt").read_text()
            assert not (slow / "report.json").exists()
        done = sweep(scene, out, *arguments)  # waits for a run that has outlived its sweep
        assert done.returncode == 0, done.stdout + done.stderr
        assert [row["digest"] for row in table(out)] == [row["digest"] for row in table(whole)]
        log = (slow / "log.txt").read_text()
        assert log.count("frame 2/") == 1, "the run has continued where it was"


def test_a_run_that_fails_is_named_and_the_others_are_completed(scene, tmp_path):
    out = tmp_path / "out"
    done = sweep(scene, out, "-p", "friction=-1.0,0.5")
    assert done.returncode == 1 and [row["friction"] for row in table(out)] == ["0.5"]
    log = out / "friction--1.0" / "log.txt"
    assert f"failed with exit code 1: {log}" in done.stdout
    assert "friction must be" in log.read_text()


@pytest.mark.parametrize(
    ("arguments", "said", "code"),
    [
        (["-p", "cells"], "-p must be name=value, got 'cells'", 2),
        (["-p", "cels=3,4"], "did you mean cells?", 1),
        (["-p", "cells=3,4.5"], "parameter cells must be an int", 1),
        (["-p", "cells=10:20:4"], "parameter cells must be an int like 6, got 13.3333333333", 1),
        (["-p", "cells=3,4", "-p", "cells=5"], "-p cells must be given once", 2),
        (["-p", "cells=3,3"], "-p cells must have different values", 2),
        (["-p", "friction=0:1:1"], "at least 2 values", 2),
        (["-p", "friction=0:inf:3"], "finite numbers", 2),
        (["-p", "cells=1:200000:200000"], "at most 100000 runs", 2),
        (["--plot", "wall_second"], "did you mean wall_seconds?", 2),
        (["--step", "foo"], "--step must be a time", 2),
        (["--step", "0"], "step must be > 0", 2),
        (["--scheduler", "nowhere"], "--scheduler", 1),
    ],
)
def test_mistakes_are_one_sentence_before_anything_runs(scene, tmp_path, arguments, said, code):
    done = sweep(scene, tmp_path / "out", *arguments)
    assert done.returncode == code and done.stderr.startswith("loomstone: ")
    assert said in done.stderr and done.stderr.count("\n") == 1
    assert not list(tmp_path.glob("out/*/run.vtkhdf"))


def test_a_directory_holds_one_sweep(scene, tmp_path):
    out = tmp_path / "out"
    assert sweep(scene, out, "--duration", "0.04").returncode == 0
    other = sweep(scene, out, "--duration", "0.08")
    assert other.returncode == 1 and "has runs of another duration" in other.stderr
    scene.write_text(SCENE + "# changed\n")
    other = sweep(scene, out, "--duration", "0.04")
    assert other.returncode == 1 and "has runs of another scene" in other.stderr


def test_a_directory_that_holds_no_sweep_is_not_written_into(scene, tmp_path):
    out = tmp_path / "thesis"
    out.mkdir()
    (out / "chapter.tex").write_text("text")
    done = sweep(scene, out, "--duration", "0.04")
    assert done.returncode == 1 and done.stderr == (
        f"loomstone: {out} must be empty or absent, but contains chapter.tex, which no sweep has"
        " written; give another directory by --out\n"
    )
    assert [path.name for path in out.iterdir()] == ["chapter.tex"]
    claim(out, {"scene": ""}, besides="chapter.tex")


def test_a_duration_that_is_no_whole_number_of_frames_is_told_once(scene, tmp_path):
    done = sweep(scene, tmp_path / "out", "--duration", "0.06")
    assert done.returncode == 0
    assert done.stdout.count("duration 0.06 s is 1.5 frames at 25 frames/s") == 1


def test_values_are_lists_ranges_and_literals():
    assert parse_values(["a=1,2.5,x", "b=[1,2],[3]", "c=0:4:3", "d=0.0:1:3"]) == {
        "a": [1, 2.5, "x"],
        "b": [[1, 2], [3]],
        "c": [0, 2, 4],
        "d": [0.0, 0.5, 1.0],
    }
    assert parse_values(["e=[[1,2],[3,4]],[5,[6]]"]) == {"e": [[[1, 2], [3, 4]], [5, [6]]]}
    with pytest.raises(InvalidInput, match="must be given once"):
        parse_values(["a=1", "a=2"])


def test_texts_that_look_like_equal_numbers_or_ranges_are_values(tmp_path):
    (tmp_path / "scene.py").write_text("def scene(label: str, friction: float = 0.3): ...")
    given = ["label=100,1e2,1:2:1", "friction=0.1:0.5:3"]
    file = open_with(tmp_path / "scene.py", first_values(given))
    assert parse_values(given, file.texts) == {
        "label": ["100", "1e2", "1:2:1"],
        "friction": [0.1, 0.3, 0.5],
    }


def test_every_point_has_its_own_directory_whatever_its_values(tmp_path):
    (tmp_path / "scene.py").write_text("def scene(**anything): ...")
    values = {"text": ["a/b", "a b", "ab", "x" * 300], "other": [[1, 2], 3]}
    points = points_of(values, tmp_path / "scene.py", tmp_path)
    names = [point.name for point in points]
    assert len(set(names)) == 8 and all(os.sep not in name and len(name) < 200 for name in names)


def test_texts_that_read_like_other_parameters_do_not_share_a_directory(tmp_path):
    (tmp_path / "scene.py").write_text("def scene(a: str = '', mode: object = 0): ...")
    points = [
        *points_of({"a": ["x_mode-1"]}, tmp_path / "scene.py", tmp_path),
        *points_of({"a": ["x"], "mode": [1, "1", True, "True"]}, tmp_path / "scene.py", tmp_path),
    ]
    assert len({point.name for point in points}) == 5
    assert points_of({"a": ["x"], "mode": [1]}, tmp_path / "scene.py", tmp_path)[0].name == (
        "a-x_mode-1"
    )


def test_a_sweep_without_steps_has_a_table(scene, tmp_path):
    done = sweep(scene, tmp_path / "out", "--duration", "0")
    assert done.returncode == 0, done.stderr
    assert "1/1" in done.stdout and len(table(tmp_path / "out")) == 1


def test_a_damaged_note_of_a_sweep_is_refused(tmp_path):
    (tmp_path / "sweep.json").write_text("[]")
    with pytest.raises(CacheError, match="sweep.json cannot be read: it must contain"):
        claim(tmp_path, {"scene": ""})


def test_the_table_keeps_the_runs_of_earlier_sweeps_with_other_parameters(scene, tmp_path):
    out = tmp_path / "out"
    assert sweep(scene, out, "-p", "cells=3,4", "--duration", "0.04").returncode == 0
    shutil.copytree(out / "cells-3", out / "mine")  # no run of a sweep
    (out / "mine" / "log.txt").unlink()
    done = sweep(scene, out, "-p", "friction=0.1,0.2", "--duration", "0.04", "--plot", "steps")
    assert done.returncode == 0, done.stderr
    assert "2 runs in" in done.stdout and "(4 runs, 2 of them of earlier sweeps)" in done.stdout
    assert [(row["run"], row["cells"], row["friction"]) for row in table(out)] == [
        ("friction-0.1", "6", "0.1"),
        ("friction-0.2", "6", "0.2"),
        ("cells-3", "3", "0.3"),
        ("cells-4", "4", "0.3"),
    ]
    assert (out / "figures.png").stat().st_size > 5000
