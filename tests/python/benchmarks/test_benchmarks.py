"""Every benchmark in tests/benchmarks runs to completion at a tiny size. It is skipped if something
that it needs is missing.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
BENCHMARKS = ROOT / "tests" / "benchmarks"
# Modules that programs or tests import. They are not benchmarks themselves.
MODULES = (
    "smoke.py",
    "extreme_scenes.py",
    "fault_trials.py",
    "fault_scenes.py",
)
# Folders of modules that programs import, and of programs that run inside Blender.
HELPERS = tuple(BENCHMARKS / name for name in ("peer_helpers", "random_parts", "inside_blender"))
PROGRAMS = sorted(
    p for p in BENCHMARKS.rglob("*.py") if p.name not in MODULES and p.parent not in HELPERS
)
BUILT = [
    f"{p.parent.name}/{p.stem}" for p in sorted(BENCHMARKS.glob("*/benchmark_*.cpp"))
]  # each file is a program of its own


def smoke(command: list[str], directory: Path) -> None:
    environment = {**os.environ, "OMP_WAIT_POLICY": "passive", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [*command, "--smoke"], cwd=directory, env=environment, capture_output=True, text=True
    )
    if done.returncode == 77:  # something that the program needs is missing
        pytest.skip(done.stderr.strip().splitlines()[-1])
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip() or list(directory.iterdir()), "it has printed or written something"


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda p: p.relative_to(BENCHMARKS).as_posix())
def test_a_benchmark_runs_in_a_tiny_size(program, tmp_path):
    smoke([sys.executable, str(program)], tmp_path)


@pytest.mark.parametrize("name", BUILT)
def test_a_benchmark_in_cpp_runs_in_a_tiny_size(name, tmp_path):
    built = sorted(
        ROOT.glob(f"build/*/tests/benchmarks/{name}"), key=lambda path: path.stat().st_mtime
    )
    if not built:
        pytest.skip("not built; configure with -DLOOMSTONE_BENCHMARKS=ON")
    smoke([str(built[-1])], tmp_path)
