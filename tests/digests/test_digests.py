"""On the machine of the record, one thread, two threads and two ranks reproduce the recorded
digests. All scenes have digests.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from launcher import ENVIRONMENT, needs_mpirun, ranks

PROGRAM = Path(__file__).with_name("digests.py")
SCENES = Path(__file__).parents[2] / "scenes"


def equal(done):
    if done.returncode == 77 or "recorded on another machine" in done.stderr:
        pytest.skip(done.stderr.strip().splitlines()[0])
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("threads", [1, 2])
def test_the_digests_of_threads_are_those_on_record(threads):
    command = [sys.executable, str(PROGRAM), "--compare", "--threads", str(threads)]
    equal(subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT))


@needs_mpirun
def test_the_digests_of_two_ranks_are_those_on_record():
    equal(ranks(2, PROGRAM, "--compare", timeout=600))


def test_every_scene_is_on_record():
    kept = json.loads(PROGRAM.with_name("digests.json").read_text())["digests"]
    assert {p.stem for p in SCENES.glob("*.py")} <= {name.split(":")[0] for name in kept}
