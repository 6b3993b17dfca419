"""Settings of how soon idle threads of OpenMP and OpenBLAS sleep, while `_core` loads and after."""

import os
import subprocess
import sys

import pytest

NAMES = ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "OPENBLAS_THREAD_TIMEOUT")

# Prints the settings at the moment when Python searches for `_core`, the settings after the import,
# and WAITING.
PROGRAM = f"""
import os, sys
{{before}}
class Witness:
    def find_spec(self, name, path=None, target=None):
        if name.endswith("._core"):
            print([os.environ.get(name) for name in {NAMES}])
sys.meta_path.insert(0, Witness())
import loomstone.base.waiting
print([os.environ.get(name) for name in {NAMES}])
print(loomstone.base.waiting.WAITING)
"""


def settings(before: str = "", **given: str) -> list[str]:
    environment = {name: value for name, value in os.environ.items() if name not in NAMES}
    program = PROGRAM.format(before=before)
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        env=environment | given,
    )
    during, *_, after, waiting = done.stdout.splitlines()
    return [during, after, waiting]


def test_threads_sleep_soon_by_default() -> None:
    during, after, waiting = settings()
    assert during == "[None, '30000', '16']"
    assert after == "[None, None, None]"
    assert waiting == "GOMP_SPINCOUNT=30000 (loomstone's)"


@pytest.mark.parametrize(
    ("name", "value", "during"),
    [
        ("OMP_WAIT_POLICY", "passive", "['passive', None, '16']"),
        ("GOMP_SPINCOUNT", "7", "[None, '7', '16']"),
    ],
)
def test_settings_of_the_user_are_kept(name: str, value: str, during: str) -> None:
    lines = settings(**{name: value})
    assert lines[0] == during
    assert lines[2] == f"{name}={value} (environment)"


def test_the_time_after_which_blas_sleeps_can_be_set() -> None:
    lines = settings(OPENBLAS_THREAD_TIMEOUT="26")
    assert lines[:2] == ["[None, '30000', '26']", "[None, None, '26']"]


def test_a_library_that_is_loaded_first_keeps_its_setting() -> None:
    lines = settings(before="import ctypes; ctypes.CDLL('libgomp.so.1')")
    assert lines[0] == "[None, None, '16']"
    assert "another package loaded libgomp first" in lines[2]
