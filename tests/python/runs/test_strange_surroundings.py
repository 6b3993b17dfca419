"""Commands work in directories with files named like modules, frames of an older state, files of
others, or special characters in names.
"""

import csv
import os
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import loomstone as ls
import pytest
from loomstone.pictures import render_run

SMALL = ls.RenderOptions(width=32, height=24, samples=1)
SCENE = """
import loomstone as ls
duration, rate = 0.04, 50.0
def scene(cells: int = 3):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(cells, cells)))])
"""
needs_safe_path = pytest.mark.skipif(
    sys.version_info < (3, 11), reason="Python 3.10 always searches the working directory"
)


def loomstone(*arguments, cwd):
    # Unlike python -m, the installed script does not search the working directory.
    command = [Path(sys.executable).with_name("loomstone"), *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=100)


@pytest.fixture
def run(tmp_path, hanging, euler):
    ls.Simulation(hanging, integrator=euler, threads=1).run(
        out=tmp_path / "run", duration=0.08, rate=50
    )
    return tmp_path / "run"


@needs_safe_path
def test_pictures_are_drawn_in_a_directory_with_files_named_like_modules(run):
    for name in ("select", "signal"):
        (run / f"{name}.py").write_text("raise SystemExit('imported from the directory')")
    done = loomstone("render", ".", "--width", 32, "--height", 24, "--jobs", 2, cwd=run)
    assert done.returncode == 0 and "imported" not in done.stdout + done.stderr
    assert len(list((run / "frames").glob("*.png"))) == 5


@needs_safe_path
def test_a_scene_named_like_a_module_is_swept(tmp_path):
    (tmp_path / "random.py").write_text(SCENE)
    done = loomstone("sweep", "random.py", "-p", "cells=2,3", "--out", "all", cwd=tmp_path)
    assert done.returncode == 0, (tmp_path / "all" / "cells-2" / "log.txt").read_text()


def test_a_process_that_is_killed_while_it_draws_ends_drawing_with_an_error(run, monkeypatch):
    class Mortal(ProcessPoolExecutor):
        def submit(self, *task):
            return super().submit(os._exit, 1)

    monkeypatch.setattr("concurrent.futures.ProcessPoolExecutor", Mortal)
    with pytest.raises(ls.CacheError, match="a process that draws pictures was ended"):
        render_run(ls.Run(run), SMALL, jobs=2)
    assert "PYTHONSAFEPATH" not in os.environ


def test_resuming_refuses_a_run_whose_last_frames_are_missing(tmp_path, hanging, euler):
    def simulation():
        return ls.Simulation(hanging, integrator=euler, threads=1)

    out = tmp_path / "run"
    simulation().run(out=out, duration=0.08, rate=25)
    older = (out / "run.vtkhdf").read_bytes()
    simulation().run(out=out, duration=0.2, rate=25, resume=True)
    (out / "run.vtkhdf").write_bytes(older)
    with pytest.raises(ls.CacheError, match=r"frames up to 0\.2 s.* but ends at 0\.08 s"):
        simulation().run(out=out, duration=0.28, rate=25, resume=True)


def test_overwriting_a_run_keeps_what_others_put_beside_its_pictures(run, hanging, euler):
    render_run(ls.Run(run), SMALL, jobs=1)
    for name in ("notes.txt", "my-options.json"):
        (run / "frames" / name).write_text("mine")
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=run, duration=0.02, overwrite=True)
    left = {path.name for path in (run / "frames").iterdir()}
    assert left == {"notes.txt", "my-options.json"}


def test_texts_with_dollar_signs_are_no_formulas_in_plots(tmp_path):
    (tmp_path / "dollars.py").write_text(SCENE.replace("3)", "3, name: str = '')"))
    given = ("-p", "name=$5_$6,$\\x$", "-p", "cells=2,3")
    done = loomstone("sweep", "dollars.py", *given, "--out", "$all_$", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "$all_$" / "figures.png").exists()
    first = next((tmp_path / "$all_$").glob("*/run.vtkhdf")).parent
    assert loomstone("plot", first, cwd=tmp_path).returncode == 0


def test_a_parameter_of_a_sweep_may_be_named_run(tmp_path):
    (tmp_path / "named.py").write_text(
        SCENE.replace("cells: int", "run: int").replace("(cells, cells)", "(run, run)")
    )
    done = loomstone("sweep", "named.py", "-p", "run=2,3", "--out", "all", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "all" / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["report.run"] for row in rows] == ["run-2", "run-3"]
    assert [row["run"] for row in rows] == ["2", "3"]


def test_a_scene_file_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "marked.py").write_text(SCENE, encoding="utf-8-sig")
    assert loomstone("info", "marked.py", cwd=tmp_path).returncode == 0


def test_a_finished_run_whose_last_step_passed_its_last_frame_is_resumed(tmp_path, hanging):
    for duration in (0.05, 0.05, 0.06):  # frames after every 1 ms, steps of 4 ms
        sim = ls.Simulation(hanging, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
        sim.run(
            out=tmp_path / "run", duration=duration, rate=1000, resume=(tmp_path / "run").exists()
        )
    assert ls.Run(tmp_path / "run").times[-1] == pytest.approx(0.06)


def runs(pid):
    """Returns whether a process exists and has not ended."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_drawing_processes_end_with_the_process_that_started_them(run):
    code = (
        "import os, signal, sys, loomstone as ls\n"
        "from loomstone.pictures import render_run\n"
        "from multiprocessing import active_children\n"
        "def killed(count):\n"
        "    if count == 0:\n"
        "        return\n"
        "    print(*(child.pid for child in active_children()), flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
        "if __name__ == '__main__':\n"
        "    options = ls.RenderOptions(width=32, height=24, samples=1)\n"
        "    render_run(ls.Run(sys.argv[1]), options, jobs=2, progress=killed)\n"
    )
    (run / "draws.py").write_text(code)
    done = subprocess.run(
        [sys.executable, run / "draws.py", run], stdout=subprocess.PIPE, text=True, timeout=100
    )
    pids = [int(word) for word in done.stdout.split()]
    end = time.monotonic() + 30.0
    while any(map(runs, pids)) and time.monotonic() < end:
        time.sleep(0.05)
    assert len(pids) == 2 and not any(map(runs, pids))
