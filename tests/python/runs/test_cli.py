"""The command `loomstone` as a user runs it."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import loomstone as ls
import numpy as np
import pytest

SCENES = Path(__file__).parents[3] / "scenes"
SCENE = """
import loomstone as ls
duration = 0.6
rate = 25.0
integrator = ls.SemiImplicitEuler(step=2e-3)
render = ls.RenderOptions(width=160, height=90, samples=1)
def scene(cells: int = 12):
    mesh = ls.grid(size=(0.3, 0.3), cells=(cells, cells)).moved((0, 0, 0.105))
    obstacles = [ls.sphere(radius=0.1, subdivisions=2), ls.floor(height=-0.2)]
    return ls.Scene(cloths=[ls.Cloth(mesh=mesh)], obstacles=obstacles)
def check(run):
    assert run[-1].positions[:, 2].min() < 0.1, "it has fallen"
"""


def command(*arguments, check=True, **options):
    done = subprocess.run(
        [sys.executable, "-m", "loomstone", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=240,
        **options,
    )
    if check:
        assert done.returncode == 0, done.stdout + done.stderr
    return done


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE)
    return tmp_path / "scene.py"


def test_help_gives_an_example_of_every_command():
    listed = {
        line.split()[0]
        for line in command("--help").stdout.splitlines()
        if line.startswith("  ") and line.split()
    }
    names = {"demo", "new", "scenes", "run", "resume", "render", "check", "info", "plot"}
    assert names | {"field", "fabrics", "report", "versions"} <= listed
    for name in names:  # each help text has an example
        assert any(
            line.strip().startswith(f"loomstone {name}")
            for line in command(name, "--help").stdout.splitlines()
        )


def test_run_render_info_plot_and_check_work_on_one_another(scene, tmp_path):
    out = tmp_path / "out"
    done = command(
        "run",
        scene,
        "--out",
        out,
        "-p",
        "cells=6",
        "--duration",
        0.2,
        "--step",
        4e-3,
        "--threads",
        1,
        "--render",
    )
    assert "frame 6/6" in done.stdout and "steps/s" in done.stdout and "left 0:00" in done.stdout
    assert len(list((out / "frames").glob("*.png"))) == 6 and (out / "video.mp4").exists()
    kept = ls.Run(out).metadata
    assert (
        kept["scene_file"]["parameters"] == {"cells": 6}
        and kept["duration"] == 0.2
        and kept["integrator"]["step"] == 4e-3
    )
    assert "72 cloth triangles" in command("info", out).stdout
    assert "positions" in command("info", sorted(out.glob("checkpoint-*"))[0]).stdout
    assert "-p cells=12" in command("info", scene).stdout
    assert "pictures" in command("render", out, "--color-by", "stretch", "--frame", -1).stdout
    assert "video" in command("render", out, "--jobs", 2).stdout
    assert (out / "stages.png").exists() if command("plot", out, "--what", "stages") else False
    assert "the scene's claims hold" in command("check", out).stdout
    done = command("check", scene, "--render", tmp_path / "start.png")
    assert "0 intersecting pairs" in done.stdout and (tmp_path / "start.png").exists()


def test_mistakes_are_one_sentence_and_exit_code_1_or_2(scene, tmp_path):
    for arguments, message, code in [
        (["run", scene, "-p", "cell=3"], "did you mean cells", 1),
        (["run", scene, "--integrator", "rk4"], "--integrator must be one of", 2),
        (["run", scene, "--step", "-1"], "step must be > 0", 2),
        (["run", tmp_path / "absent.py"], "cannot be read", 1),
        (["resume", tmp_path], "run.vtkhdf", 1),
        (["resume", tmp_path, "--decomposition", "any"], "decomposition must be one of", 2),
        (["check", scene, "-p", "cells"], "-p must be name=value", 2),
        (["view", scene, "-p", "cells"], "-p must be name=value", 2),
        (["export", tmp_path, "--to", "any"], "to must be one of", 2),
        (["info", tmp_path / "absent"], "no such file", 1),
        (["plot", tmp_path], "steps.csv", 1),
    ]:
        done = command(*arguments, check=False, cwd=tmp_path)
        assert done.returncode == code and message in done.stderr, done.stderr
        assert "Traceback" not in done.stderr


def test_a_tangled_start_is_refused_with_its_pairs_and_drawn(tmp_path):
    (tmp_path / "tangled.py").write_text(
        "import loomstone as ls\ndef scene():\n    flat = ls.grid(size=(0.2, 0.2), cells=(4, 4))\n "
        "   upright = flat.moved((0.013, 0.007, 0), rotation=[[1, 0, 0], [0, 0, -1], [0, 1, 0]])\n "
        "   return ls.Scene(cloths=[ls.Cloth(name='a', mesh=flat), ls.Cloth(name='b',"
        " mesh=upright)])\n"
    )
    done = command(
        "check", tmp_path / "tangled.py", "--render", tmp_path / "start.png", check=False
    )
    assert done.returncode == 1 and "refused" in done.stdout and "intersecting pairs" in done.stdout
    assert (tmp_path / "start.png").exists()


def start(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "loomstone", *map(str, arguments)], stdout=subprocess.PIPE, text=True
    )


def wait_for_frame(process, number):
    for line in process.stdout:
        if line.startswith(f"frame {number}/"):
            return
    raise AssertionError("the run ended early")


def digest(out):
    return json.loads((out / "report.json").read_text())["digest"]


@pytest.mark.parametrize("moment", [1, 4, 9])
def test_a_run_killed_at_any_moment_resumes_to_the_same_bits(scene, tmp_path, moment):
    command("run", scene, "--out", tmp_path / "whole")
    process = start("run", scene, "--out", tmp_path / "killed")
    wait_for_frame(process, moment)
    time.sleep(0.013 * moment)
    process.kill()
    process.wait()
    readable = len(ls.Run(tmp_path / "killed"))
    assert readable >= moment
    command("resume", tmp_path / "killed", "--threads", 1)
    assert digest(tmp_path / "killed") == digest(tmp_path / "whole")
    for a, b in zip(ls.Run(tmp_path / "killed"), ls.Run(tmp_path / "whole"), strict=True):
        assert (a.positions == b.positions).all()


@pytest.mark.parametrize("schedule", ["nested", "queue", "refill"])
def test_an_asynchronous_run_that_is_killed_resumes_to_the_same_bits(tmp_path, schedule):
    damped = "material=ls.ClothMaterial(viscosity_shear=1e-4, bending_damping=1e-3)"
    text = SCENE.replace("ls.Cloth(mesh=mesh)", f"ls.Cloth(mesh=mesh, {damped})").replace(
        "ls.SemiImplicitEuler(step=2e-3)", f'ls.Asynchronous(schedule="{schedule}")'
    )
    assert "bending_damping" in text and schedule in text
    (tmp_path / "scene.py").write_text(text)
    command("run", tmp_path / "scene.py", "--out", tmp_path / "whole")
    process = start("run", tmp_path / "scene.py", "--out", tmp_path / "killed")
    wait_for_frame(process, 3)
    process.kill()
    process.wait()
    assert len(ls.Run(tmp_path / "killed")) < len(ls.Run(tmp_path / "whole"))
    command("resume", tmp_path / "killed", "--threads", 1)
    assert digest(tmp_path / "killed") == digest(tmp_path / "whole")
    text = command("info", tmp_path / "whole").stdout
    assert re.search(r"steps: \d+ events of triangles, instead of \d+ if all", text)
    classes = re.findall(r"longest step .* ms: (\d+) triangles", text)
    assert sum(map(int, classes)) == 288


@pytest.mark.slow
def test_a_run_killed_at_20_random_moments_resumes_to_the_same_bits_each_time(scene, tmp_path):
    process = start("run", scene, "--out", tmp_path / "whole", "--threads", 1)
    wait_for_frame(process, 1)
    began = time.perf_counter()
    process.communicate()
    length = time.perf_counter() - began
    for number, moment in enumerate(np.random.default_rng(7).uniform(0.0, length, 20)):
        out = tmp_path / f"killed{number}"
        process = start("run", scene, "--out", out, "--threads", 1)
        wait_for_frame(process, 1)
        time.sleep(moment)
        process.kill()
        process.communicate()
        assert len(ls.Run(out)) > 0
        command("resume", out, "--threads", 1)
        assert digest(out) == digest(tmp_path / "whole"), (
            f"killed after {moment:.3f} s of {length:.3f} s"
        )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
def test_a_signal_leaves_a_resumable_run(scene, tmp_path, number):
    process = start("run", scene, "--out", tmp_path / "out")
    wait_for_frame(process, 3)
    process.send_signal(number)
    rest = process.communicate()[0]
    assert process.returncode == 128 + number and "continue with: loomstone resume" in rest
    command("resume", tmp_path / "out")
    assert len(ls.Run(tmp_path / "out")) == 16


def test_resuming_a_trusted_run_needs_nothing_but_the_directory(scene, tmp_path):
    command("run", scene, "--out", tmp_path / "out", "-p", "cells=5", "--duration", 0.08)
    os.remove(scene)
    (tmp_path / "out").rename(tmp_path / "moved")
    for path in (tmp_path / "moved").glob("checkpoint-*"):
        path.unlink()
    resumed = command("resume", tmp_path / "moved", "--trust")
    assert "72" not in resumed.stdout.splitlines()[0]
    assert len(ls.Run(tmp_path / "moved")) == 3


@pytest.mark.parametrize(
    "name, small",
    [
        ("hanging", ["triangles=200"]),
        ("drape", ["triangles=800"]),
        ("swing", ["columns=8", "rows=10"]),
        ("flag", ["triangles=300"]),
        ("bending", ["triangles=200"]),
        ("funnel", ["triangles=400"]),
    ],
)
def test_every_scene_runs_small_and_short_without_intersections(tmp_path, name, small):
    parameters = [word for item in small for word in ("-p", item)]
    command(
        "run",
        SCENES / f"{name}.py",
        "--out",
        tmp_path,
        "--duration",
        0.12,
        "--overwrite",
        *parameters,
    )
    run = ls.Run(tmp_path)
    assert len(run) >= 4 and run.intersecting_pairs() == []


def test_the_first_scene_keeps_its_claims(tmp_path):
    command("run", SCENES / "hanging.py", "--out", tmp_path, "-p", "triangles=400")
    assert "claims hold" in command("check", tmp_path).stdout
