"""A signal ends a run in Python by a KeyboardInterrupt, which `except Exception` does not catch."""

import pickle
import signal
import subprocess
import sys

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


def test_a_signal_that_ended_a_run_passes_between_processes():
    again = pickle.loads(pickle.dumps(Interrupted(signal.SIGTERM)))
    assert again.signal == signal.SIGTERM and str(again) == "SIGTERM"
