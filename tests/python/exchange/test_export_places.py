"""Directories into which a run may be exported."""

import loomstone as ls
import pytest


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of two frames of one cloth."""
    out = tmp_path_factory.mktemp("run") / "out"
    cloth = ls.Cloth(name="sheet", mesh=ls.grid(cells=(2, 2)), pins=[0])
    ls.Simulation(ls.Scene(cloths=[cloth]), threads=1).run(out=out, duration=0.04)
    return ls.Run(out)


@pytest.mark.parametrize("to", ["ply", "pc2"])
@pytest.mark.parametrize("out", [".", ".."])
def test_files_are_exported_into_the_working_directory(run, tmp_path, monkeypatch, out, to):
    here = tmp_path / "here"
    (here / "below").mkdir(parents=True)
    monkeypatch.chdir(here / "below" if out == ".." else here)
    before = here.stat().st_ino
    paths = run.export(out, to=to, overwrite=True)
    assert here.stat().st_ino == before and list(tmp_path.iterdir()) == [here]
    assert {p.name for p in here.iterdir()} == {p.name for p in paths} | {"below"}


def test_an_export_that_was_killed_is_not_in_the_way(run, tmp_path):
    (tmp_path / "x" / "unfinished-export").mkdir(parents=True)
    paths = run.export(tmp_path / "x", to="obj")
    assert sorted(p.name for p in (tmp_path / "x").iterdir()) == sorted(p.name for p in paths)
