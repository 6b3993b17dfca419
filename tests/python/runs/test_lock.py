"""While a process writes a run, other writers are refused, but readers are not."""

import errno
import fcntl
import json
import os
import signal
import subprocess
import sys
import threading
import time

import loomstone as ls
import pytest
from loomstone.runs.lock import DirectoryLock

SCENE = """
import os
import time
import loomstone as ls
duration = 0.4
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene():
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.2, 0.2), cells=(6, 6)), pins=[0])])
def control(sim):
    while sim.step_index == 25 and not os.path.exists("go"):  # three frames are written
        time.sleep(0.01)
"""
# Program that, during a run, starts a child process and then kills itself with SIGKILL. The child
# survives.
MORTAL = """
import os, signal, time
import loomstone as ls
def die(sim):
    if sim.step_index == 25:
        if os.fork() == 0:
            os.closerange(0, 3)
            time.sleep(60)
            os._exit(0)
        os.kill(os.getpid(), signal.SIGKILL)
mesh = ls.grid(size=(0.2, 0.2), cells=(8, 8))
scene = ls.Scene(cloths=[ls.Cloth(name="cloth", mesh=mesh, pins=[0, 8])])
sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
sim.run(out="out", duration=0.2, control=die)
"""


def command(*arguments):
    return [sys.executable, "-m", "loomstone", *map(str, arguments)]


def call(*arguments):
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=60)


def made(scene, euler):
    return ls.Simulation(scene, integrator=euler, threads=1)


def idle(_):
    """A control function that does nothing, for resuming runs that have had a control function."""


def names(directory):
    return sorted(path.name for path in directory.iterdir())


def test_a_run_that_a_process_writes_is_refused_to_others_and_shown_to_readers(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.py").write_text(SCENE)
    (tmp_path / "other.py").write_text(SCENE.replace("duration = 0.4", "duration = 0.08"))
    first = subprocess.Popen(command("run", "scene.py", "--out", "out"), stdout=subprocess.PIPE)
    while not list(tmp_path.glob("out/checkpoint-*")):
        assert first.poll() is None
        time.sleep(0.02)
    for arguments in (
        ("resume", "out"),
        ("run", "other.py", "--out", "out", "--overwrite"),
        ("run", "other.py", "--out", "out"),
    ):
        refused = call(*arguments)
        assert refused.returncode == 1 and "building" not in refused.stdout
        assert refused.stderr == (
            "loomstone: out must be written by one process at a time, but process"
            f" {first.pid} on host {os.uname().nodename} is writing it; wait until that ends, or"
            " give another directory\n"
        )
    assert call("info", "out").returncode == 0
    (tmp_path / "go").touch()
    first.communicate(timeout=60)
    assert first.returncode == 0
    assert call("run", "scene.py", "--out", "whole").returncode == 0
    digests = [json.loads((tmp_path / o / "report.json").read_text())["digest"]
               for o in ("out", "whole")]  # fmt: skip
    assert digests[0] == digests[1] and len(ls.Run("out")) == 11
    assert names(tmp_path / "out") == names(tmp_path / "whole")
    assert not [name for name in names(tmp_path / "out") if name.startswith(".")]
    again = call("run", "other.py", "--out", "out", "--overwrite")
    assert again.returncode == 0, again.stderr


def test_a_run_in_python_is_refused_until_the_first_has_ended(tmp_path, hanging, euler):
    out, refused = tmp_path / "out", []

    def second(_):
        for options in ({"resume": True}, {"overwrite": True}, {}):
            with pytest.raises(ls.CacheError, match=f"process {os.getpid()} on host") as error:
                made(hanging, euler).run(out=out, duration=0.04, **options)
            refused.append(str(error.value))

    made(hanging, euler).run(out=out, duration=0.08, control=second)
    assert len(refused) >= 3 and all(text.startswith(f"{out} must be") for text in refused)
    resumed = made(hanging, euler).run(out=out, duration=0.2, resume=True, control=idle)
    whole = made(hanging, euler).run(out=tmp_path / "whole", duration=0.2)
    assert resumed["digest"] == whole["digest"]
    assert names(out) == sorted([*names(tmp_path / "whole"), "extension.json"])


def test_a_run_that_failed_can_be_resumed_in_the_same_process(tmp_path, hanging, euler):
    def fail(sim):
        if sim.step_index == 15:
            raise RuntimeError("by the test")

    with pytest.raises(RuntimeError):
        made(hanging, euler).run(out=tmp_path / "out", duration=0.08, control=fail)
    made(hanging, euler).run(out=tmp_path / "out", duration=0.08, resume=True, control=idle)


def test_a_killed_process_hinders_nobody_even_if_its_children_live(
    tmp_path, hanging, euler, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    writer = subprocess.Popen([sys.executable, "-c", MORTAL], start_new_session=True)
    try:
        assert writer.wait(timeout=60) == -signal.SIGKILL
        resumed = made(hanging, euler).run(out="out", duration=0.2, resume=True, control=idle)
    finally:
        os.killpg(writer.pid, signal.SIGKILL)  # fails if the child has not outlived its parent
    whole = made(hanging, euler).run(out="whole", duration=0.2)
    assert resumed["digest"] == whole["digest"]
    assert names(tmp_path / "out") == names(tmp_path / "whole")


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS])
def test_a_file_system_without_locks_is_written_all_the_same(
    tmp_path, hanging, euler, monkeypatch, number
):
    def fail(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", fail)
    made(hanging, euler).run(out=tmp_path / "out", duration=0.04)
    made(hanging, euler).run(out=tmp_path / "out", duration=0.08, resume=True)
    assert not (tmp_path / "out" / ".lock").exists()


def test_a_refused_run_leaves_its_directory_as_it_was(tmp_path, hanging, euler):
    (tmp_path / "chapter.tex").write_text("text")
    with pytest.raises(ls.CacheError, match="must be empty or absent"):
        made(hanging, euler).run(out=tmp_path, duration=0.04)
    assert names(tmp_path) == ["chapter.tex"]
    with pytest.raises(ls.Error):
        made(hanging, euler).run(out=tmp_path / "absent", duration=0.04, resume=True)
    assert names(tmp_path) == ["chapter.tex"]


def test_one_of_those_that_wait_for_a_lock_gets_it_although_its_file_is_removed(tmp_path):
    taken, order = threading.Event(), []

    def wait():
        with DirectoryLock(tmp_path) as second:
            second.take(wait=True)
            order.append("second")
            with DirectoryLock(tmp_path) as third, pytest.raises(ls.CacheError):
                third.take()
            taken.set()

    with DirectoryLock(tmp_path) as first:
        first.take()
        thread = threading.Thread(target=wait)
        thread.start()
        time.sleep(0.1)  # long enough to open the file that will be removed
        order.append("first")
    assert taken.wait(10)
    thread.join()
    assert order == ["first", "second"] and names(tmp_path) == []
