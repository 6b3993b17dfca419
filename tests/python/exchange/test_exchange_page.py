"""The blocks of docs/exchange.md run as they are printed."""

import re
import subprocess
import sys
from pathlib import Path

import loomstone as ls
import pytest

PAGE = Path(__file__).parents[3] / "docs" / "exchange.md"


def blocks():
    return re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.M | re.S)


def test_the_python_blocks_of_the_page_run_in_order(tmp_path, monkeypatch, capsys):
    for name in ("pxr", "pygltflib", "trimesh"):
        pytest.importorskip(name)
    monkeypatch.chdir(tmp_path)
    session = {}
    for block in blocks():
        exec(compile(block, str(PAGE), "exec"), session)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out", "scarf.glb", "scarf.usdc"]
    assert "TriangleMesh" in capsys.readouterr().out
    ls.Simulation(session["scene"], threads=1).step()


def test_the_commands_of_the_page_run(tmp_path):
    pytest.importorskip("pxr")
    mesh = ls.grid(size=(0.1, 0.1), cells=(4, 4))
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=[0])]), threads=1)
    sim.run(out=tmp_path / "out" / "mine", duration=0.5, rate=100)  # the page selects frames 10:50
    commands = [line.split() for line in re.findall(r"^loomstone .*$", PAGE.read_text(), re.M)]
    assert len(commands) == 2
    for command in commands:
        done = subprocess.run(
            [sys.executable, "-m", *command], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "mine" / "run.usdc").exists()
    assert len(list((tmp_path / "sequence").glob("*.obj"))) == 20
