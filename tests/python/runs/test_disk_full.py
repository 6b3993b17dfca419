"""A full disk or a file that cannot grow causes one clear error. Earlier frames stay readable, and
the run can be resumed.
"""

import errno
import json
import os
import resource
import signal
import subprocess
import sys

import loomstone as ls
import numpy as np
import pytest
from loomstone.runs.steps import StepTable

SCENE = """
import loomstone as ls
duration = 1.0  # 26 frames: a file grows by blocks of 16
integrator = ls.SemiImplicitEuler(step=4e-3)
render = ls.RenderOptions(width=160, height=90, samples=1)
def scene():
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.3, 0.3), cells=(32, 32)), pins=[0])])
"""


def loomstone(*arguments, largest_file=None):
    def limit():
        # Makes writing beyond the limit fail instead of ending the process.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        if largest_file:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    return subprocess.run(
        [sys.executable, "-m", "loomstone", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        preexec_fn=limit,
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Directory with a scene file and its run, written without a limit on file sizes."""
    out = tmp_path_factory.mktemp("whole")
    (out / "scene.py").write_text(SCENE)
    done = loomstone("run", out / "scene.py", "--out", out / "out", "--threads", 1)
    assert done.returncode == 0, done.stderr
    return out


def check_failed_and_resume(done, out, whole, more=()):
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert "written so far are kept" in done.stderr and f"loomstone resume {out}" in done.stderr
    stored, good = ls.Run(out), ls.Run(whole / "out")
    assert 10 < len(stored) < len(good)
    for index, frame in enumerate(stored):
        assert np.array_equal(frame.positions, good[index].positions)
    del stored
    resumed = loomstone("resume", out, *more)
    assert resumed.returncode == 0, resumed.stderr
    assert (
        json.loads((out / "report.json").read_text())["digest"]
        == json.loads((whole / "out" / "report.json").read_text())["digest"]
    )
    assert len(ls.Run(out)) == len(good)


@pytest.mark.parametrize("share", [0.7, 0.95])
def test_frames_that_do_not_fit_leave_those_before_them(whole, tmp_path, share):
    size = (whole / "out" / "run.vtkhdf").stat().st_size
    done = loomstone(
        "run",
        whole / "scene.py",
        "--out",
        tmp_path / "out",
        "--threads",
        1,
        largest_file=int(share * size),
    )
    check_failed_and_resume(done, tmp_path / "out", whole)


def test_a_table_of_steps_on_a_full_disk_is_the_same_clear_error(whole, tmp_path, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.3, 0.3), cells=(32, 32)), pins=[0])])
    sims = [
        ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
        for _ in range(2)
    ]
    with monkeypatch.context() as patch:
        patch.setattr(StepTable, "flush", full)
        with pytest.raises(
            ls.CacheError, match="No space left on device.*1 frames written so far are kept"
        ):
            sims[0].run(out=tmp_path / "out", duration=1.0)
    report = sims[1].run(out=tmp_path / "out", duration=1.0, resume=True)
    assert report["digest"] == json.loads((whole / "out" / "report.json").read_text())["digest"]


def test_a_plot_that_does_not_fit_leaves_the_earlier_one(whole, tmp_path):
    picture = tmp_path / "energy.png"
    picture.write_bytes(b"earlier")
    done = loomstone("plot", whole / "out", "--out", picture, largest_file=2000)
    assert done.returncode == 1 and f"{picture}: the plot cannot be written" in done.stderr
    assert picture.read_bytes() == b"earlier"
    done = loomstone("plot", whole / "out", "--out", tmp_path / "new.png", largest_file=2000)
    assert done.returncode == 1 and [path.name for path in tmp_path.iterdir()] == ["energy.png"]


def test_a_table_that_does_not_fit_is_named(tmp_path):
    program = "import pathlib; from loomstone.runs.replay import write_predictions, Prediction;"
    program += "write_predictions(pathlib.Path('replay.csv'), [Prediction(1, 'static', 0.0)] * 99)"

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        preexec_fn=limit,
    )
    assert "CacheError: replay.csv: the table cannot be written: File too large" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_directory_that_cannot_be_made_is_refused_in_one_sentence(whole, tmp_path):
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below", "/proc/none"):
        done = loomstone("run", whole / "scene.py", "--out", out, "--duration", 0.04)
        assert done.returncode == 1 and len(done.stderr.strip().splitlines()) == 1
        assert "must be a directory that can be written" in done.stderr, done.stderr
