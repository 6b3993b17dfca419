"""A run that was killed while it wrote its first file can be started again in its directory."""

import os

import loomstone as ls
import pytest

SCENE = """
import loomstone as ls
duration = 0.04
integrator = ls.SemiImplicitEuler(step=4e-3)
render = ls.RenderOptions(width=64, height=48, samples=1)
def scene(cells: int = 3):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(cells, cells)), pins=[0])])
"""


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.py").write_text(SCENE)
    return "scene.py"


@pytest.fixture
def killed(tmp_path):
    """The directory of a run that was killed while it wrote run.vtkhdf."""
    out = tmp_path / "out"
    out.mkdir()
    for name in (".lock", "run.vtkhdf.part", "bodies.vtkhdf.part"):
        (out / name).write_text("cut off")
    return out


def test_a_run_starts_again_where_nothing_was_saved(loomstone, scene, killed):
    code, said = loomstone("resume", killed)
    assert code == 1 and said.err == (
        f"loomstone: {killed}: nothing was saved yet, because the run ended while it wrote its"
        f" first file; start it again: loomstone run SCENE --out {killed}\n"
    )
    code, said = loomstone("run", scene, "--out", killed, "--quiet")
    assert code == 0, said.err
    assert len(ls.Run(killed)) == 2 and not list(killed.glob("*.part"))


def test_reserved_pictures_are_not_in_the_way(loomstone, scene, killed):
    assert loomstone("run", scene, "--out", "drawn", "--render", "--quiet")[0] == 0
    (killed / "frames").mkdir()
    os.link("drawn/frames/options.json", killed / "frames" / "options.json")
    words = ["run", scene, "-p", "cells=2", "--out", killed, "--render", "--quiet"]
    code, said = loomstone(*words)
    assert code == 0, said.err
    assert len(list((killed / "frames").glob("*.png"))) == 2


def test_other_files_beside_the_leftovers_are_kept(loomstone, scene, killed):
    (killed / "notes.txt").write_text("mine")
    code, said = loomstone("run", scene, "--out", killed)
    assert code == 1 and "contains notes.txt, which no run has written" in said.err
    assert (killed / "run.vtkhdf.part").exists()
    (killed / "frames").mkdir()
    (killed / "frames" / "photograph.png").write_text("mine")
    assert loomstone("run", scene, "--out", killed, "--overwrite", "--quiet")[0] == 0
    assert (killed / "notes.txt").exists() and (killed / "frames" / "photograph.png").exists()
