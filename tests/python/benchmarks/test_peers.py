"""The comparison with other programs runs their scripts and evaluates the files that they write."""

import json
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).resolve().parents[3] / "tests" / "benchmarks"
# Stands in for the script of another program. It writes two frames of a square of two triangles,
# which is stretched by 20 % along x in the second frame.
SCRIPT = """
import json, os, sys
import numpy as np
from energy import lumped_mass
faces = np.array([[0, 1, 2], [1, 3, 2]])
uv = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
rest = np.c_[uv, np.zeros(4)]
meta = {"wall_per_25hz_frame": 2.0, "arguments": sys.argv[1:]}
print(lumped_mass(uv, faces, 0.3))
np.savez(os.path.join(os.environ["PEERS_OUT"], "made.npz"), uv=uv, faces=faces,
         X=np.stack([rest, rest * (1.2, 1, 1)]), t=np.array([0.0, 0.04]), meta=json.dumps(meta))
with open(NOTE, "w") as file:
    json.dump(sys.argv[1:], file)
"""


@pytest.mark.parametrize(
    "program, script, given",
    [
        ("newton", "run_newton.py", ["W1", "vbd", "--T", "0.08"]),
        ("pypbd", "run_pbd.py", ["W1", "--T", "0.08"]),
        ("mujoco", "run_mujoco.py", ["W1", "--T", "0.08"]),
        ("blender", "run_blender.py", ["W1", "--quality", "10", "--cq", "4", "--T", "0.08"]),
    ],
)
def test_a_program_is_run_and_evaluated(program, script, given, tmp_path):
    (tmp_path / "peers").mkdir()
    note = tmp_path / "arguments.json"
    (tmp_path / "peers" / script).write_text(f"NOTE = {str(note)!r}\n{SCRIPT}")
    command = [sys.executable, BENCHMARKS / "peers.py", "--smoke", "--shared", tmp_path]
    done = subprocess.run(
        [*command, "--peer-python", sys.executable, "--programs", program],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    ours, other = done.stdout.splitlines()
    assert ours.startswith("loomstone  ")
    assert other.startswith(f"{program:9s}  2.000 s a frame, stretch 1.200, intersecting pairs 0;")
    assert json.loads(note.read_text()) == given


def test_a_program_without_a_script_is_named(tmp_path):
    command = [sys.executable, BENCHMARKS / "peers.py", "--smoke", "--shared", tmp_path]
    done = subprocess.run([*command, "--programs", "pypbd"], capture_output=True, text=True)
    assert "pypbd: left out, run_pbd.py is not in the shared folder" in done.stdout


def test_masses_of_vertices_add_up_to_that_of_the_cloth():
    masses = runpy.run_path(str(BENCHMARKS / "peer_helpers" / "energy.py"))["lumped_mass"]
    uv = np.array([[0.0, 0.0], [0.4, 0.0], [0.0, 0.3], [0.5, 0.6]])
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    first, second = 0.06, 0.5 * abs(0.1 * 0.3 - 0.6 * -0.4)
    assert masses(uv, faces, 0.3) == pytest.approx(
        [0.1 * first, 0.1 * (first + second), 0.1 * (first + second), 0.1 * second]
    )
