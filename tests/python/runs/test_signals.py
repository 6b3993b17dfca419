"""A signal ends a run in Python by a KeyboardInterrupt, which `except Exception` does not catch."""

import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import loomstone as ls
import pytest
from loomstone.runs.signals import Interrupted

BATCH = """
import signal, sys
import loomstone as ls
def made():
    mesh = ls.grid(size=(0.2, 0.2), cells=(8, 8))
    return ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=[0, 8])]), threads=1)
def stop(sim):
    if sim.step_index == 2:
        signal.raise_signal(signal.SIGINT)
for name in ("first", "second"):
    try:
        made().run(out=name, duration=0.08, control=stop)
    except Exception as error:
        print("failed:", error)
"""


def made(scene, euler):
    return ls.Simulation(scene, integrator=euler, threads=1)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
def test_a_signal_ends_a_run_by_a_keyboard_interrupt(tmp_path, hanging, euler, number):
    def stop(sim):
        if sim.step_index == 15:
            signal.raise_signal(number)

    with pytest.raises(KeyboardInterrupt, match=number.name) as end:
        made(hanging, euler).run(out=tmp_path / "out", duration=0.2, control=stop)
    assert end.value.signal == number and not isinstance(end.value, Exception)
    assert (tmp_path / "out" / "checkpoint-0000000016.h5").exists()
    with pytest.raises(ls.CacheError, match="out: was run with a control function; give the same"):
        made(hanging, euler).run(out=tmp_path / "out", duration=0.2, resume=True)
    resumed = made(hanging, euler).run(
        out=tmp_path / "out", duration=0.2, resume=True, control=stop
    )
    whole = made(hanging, euler).run(out=tmp_path / "whole", duration=0.2)
    assert resumed["digest"] == whole["digest"]


def test_a_batch_that_continues_after_errors_ends_after_control_c(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", BATCH], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.returncode != 0 and "failed" not in done.stdout
    assert done.stderr.count("Traceback") == 1 and done.stderr.endswith("Interrupted: SIGINT\n")
    assert (tmp_path / "first").exists() and not (tmp_path / "second").exists()


SLOW = """
import time
import loomstone as ls
def scene():
    print("making", flush=True)
    time.sleep(30)
"""


def heed_control_c():
    """Restores the default action of SIGINT, which shells make background programs ignore."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def loaded(process):
    """Returns whether a process of loomstone has loaded `_core`. It does so before any command."""
    return "_core" in Path(f"/proc/{process.pid}/maps").read_text()


@pytest.mark.parametrize("late", [False, True])
def test_control_c_before_the_first_step_is_one_line(tmp_path, late):
    (tmp_path / "slow.py").write_text(SLOW)
    process = subprocess.Popen(
        [sys.executable, "-m", "loomstone", "run", "slow.py"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_control_c,
    )
    while not late and not loaded(process):
        time.sleep(1e-3)
    while late and process.stdout.readline() != "making\n":
        pass
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and said == "loomstone: interrupted\n"


def test_other_programs_keep_their_handling_of_control_c():
    program = "import signal, loomstone\n"
    program += "assert signal.getsignal(signal.SIGINT) is signal.default_int_handler"
    command = [sys.executable, "-c", program, "-m", "loomstone"]
    subprocess.run(command, check=True, timeout=60, preexec_fn=heed_control_c)


def test_a_signal_that_ended_a_run_passes_between_processes():
    again = pickle.loads(pickle.dumps(Interrupted(signal.SIGTERM)))
    assert again.signal == signal.SIGTERM and str(again) == "SIGTERM"
