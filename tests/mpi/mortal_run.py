"""A run in which a rank sends itself a signal or sleeps after step 25, and its resumption."""

import json
import subprocess
import sys

import loomstone as ls
from launcher import ENVIRONMENT

SCENE = """
import os
import signal
import time
import loomstone as ls
duration = 0.4
integrator = ls.SemiImplicitEuler(step=4e-3)
rank = int(os.environ.get("OMPI_COMM_WORLD_RANK", "0"))
def scene(fault: str = "", by: int = 0):
    global death
    death = fault, by
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.3, 0.3), cells=(16, 16)), pins=[0])])
def control(sim):
    if sim.step_index == 25 and rank == death[1] and "RESUMED" not in os.environ:
        if death[0] == "slow":
            time.sleep(60)
        elif death[0]:
            os.kill(os.getpid(), getattr(signal, death[0]))
"""


def arguments(scene, out, fault, by=0):
    return [
        *("-m", "loomstone", "run", scene, "--out", out, "--threads", "1"),
        *("-p", f"fault={fault}", "-p", f"by={by}"),
    ]


def straight():
    scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.3, 0.3), cells=(16, 16)), pins=[0])])
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
    for _ in range(100):
        sim.step()
    return sim.digest()


def resumes(out, command=(sys.executable,)):
    """Resumes the run. Returns whether its final state has the bits of a run without the fault.

    The run continues from a checkpoint before the fault. The fault does not occur again.
    """
    done = subprocess.run(
        [*command, "-m", "loomstone", "resume", str(out)],
        capture_output=True,
        text=True,
        timeout=60,
        env=ENVIRONMENT | {"RESUMED": "1"},
    )
    assert done.returncode == 0, done.stderr
    return json.loads((out / "report.json").read_text())["digest"] == straight()
