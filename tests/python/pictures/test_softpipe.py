"""Pictures by softpipe agree with those by llvmpipe. Both are software renderers of Mesa. Wheels
use softpipe on machines that have neither OSMesa nor EGL.
"""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[2] / "wheel" / "softpipe.py"
SOFTPIPE = runpy.run_path(str(PROGRAM))


def draw(path, **environment):
    environment = os.environ | {"LOOMSTONE_GL": "osmesa"} | environment
    done = subprocess.run(
        [sys.executable, PROGRAM, path], env=environment, capture_output=True, text=True
    )
    if "could not be loaded" in done.stderr:
        pytest.skip("OSMesa is not installed here")
    assert done.returncode == 0, done.stderr
    return path


def test_softpipe_draws_what_llvmpipe_draws_up_to_rounding(tmp_path):
    usual = draw(tmp_path / "usual.npz")
    softpipe = draw(tmp_path / "softpipe.npz", GALLIUM_DRIVER="softpipe")
    differing = SOFTPIPE["differences"](usual, softpipe)
    assert len(differing) == 2 and max(differing.values()) <= SOFTPIPE["ROUNDED"], differing
