"""The annotation of a parameter of scene() decides which values `-p name=value` may give."""

import json

import loomstone as ls
import pytest
from loomstone.runs.parameters import given_parameters
from loomstone.runs.scene_file import SceneFile

PARAMETERS = """
from __future__ import annotations
from typing import Any, Literal, Optional
from pathlib import Path
import loomstone as ls
duration = 0.04
def scene(x: float = 3, label: str = "1", xs: list = [1, 2], size: tuple = (0.5, 0.5),
          pair: tuple[float, float] = (1.0, 2.0), names: list[str] = [], flip: bool = False,
          mode: Literal["a", "b", "1"] = "a", level: Literal[1, 2] = 1, count: int = 4,
          maybe: Optional[float] = None, auto: float | str = "auto", bound: float = None,
          path: Path = Path("x"), other: Absent = 3, free: Any = 3, plain=4, shape=(1, 2),
          untyped=None, number: int | float = 1):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)), pins=[0])])
"""


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.py").write_text(PARAMETERS)
    return tmp_path / "scene.py"


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ("x=2.5", 2.5),
        ("x=2", 2.0),
        ("label=2", "2"),
        ("label=1.50", "1.50"),
        ("label='2'", "2"),
        ("label={1}", "{1}"),
        ("label={{1}}", "{{1}}"),
        ("label={[]: 1}", "{[]: 1}"),
        ("xs=3,4", [3, 4]),
        ("xs=[3]", [3]),
        ("size=0.3,0.4", (0.3, 0.4)),
        ("size=[0.3,0.4]", (0.3, 0.4)),
        ("pair=3,4", (3.0, 4.0)),
        ("names=['a','b']", ["a", "b"]),
        ("flip=true", True),
        ("mode=b", "b"),
        ("mode=1", "1"),
        ("level=2", 2),
        ("count=5e3", 5000),
        ("count=100.0", 100),
        ("number=2.0", 2.0),
        ("number=2", 2),
        ("maybe=2", 2.0),
        ("maybe=None", None),
        ("auto=2", 2.0),
        ("auto=none", "none"),
        ("bound=None", None),
        ("path=figure", "figure"),
        ("other=5", 5),
        ("free=text", "text"),
        ("shape=[3,4]", (3, 4)),
        ("shape=3", 3),
        ("untyped=[3]", [3]),
    ],
)
def test_an_annotation_decides_what_a_value_becomes(scene, given, value):
    found = SceneFile.open(scene, given_parameters([given])).parameters
    assert list(found.values()) == [value] and type(*found.values()) is type(value)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("x=fast", "parameter x must be a float like 3.0, got 'fast'"),
        ("xs=3", r"parameter xs must be a list like \[1, 2\], got 3"),
        ("size=3", r"parameter size must be a tuple like \(0.5, 0.5\), got 3"),
        ("pair=1,2,3", r"must be a tuple\[float, float\] like \(1.0, 2.0\), got \(1, 2, 3\)"),
        ("names=[1]", r"must be a list\[str\] like \[\], got \[1\]"),
        ("flip=1", "must be a bool like False, got 1"),
        ("mode=c", "must be 'a' or 'b' or '1', got 'c'"),
        ("level=3", "must be 1 or 2, got 3"),
        ("count=4.5", "must be an int like 4, got 4.5"),
        ("count=true", "must be an int like 4, got 'true'"),
        ("maybe=x", "must be a float or None, got 'x'"),
        ("other=x", "must be an int like 3, got 'x'"),
        ("plain=4.5", "must be an int like 4, got 4.5"),
        ("free={1}", "-p free must be a number, text, list or dict"),
        ("free=1e400", "-p free must be .* without infinite numbers, got 1e400"),
        ("free=[1e400]", "-p free must be .* without infinite numbers"),
    ],
)
def test_a_value_that_an_annotation_excludes_is_refused(scene, given, said):
    with pytest.raises(ls.InvalidInput, match=said):
        SceneFile.open(scene, given_parameters([given]))


def test_a_sweep_passes_texts_as_they_are_given(loomstone, scene, tmp_path):
    out = tmp_path / "out"
    code, said = loomstone("sweep", scene, "-p", "label=1.50,2", "-p", "mode=1,b", "--out", out)
    assert code == 0, said.err
    names = sorted(path.parent.name for path in out.glob("*/run.vtkhdf"))
    assert names == [f"label-{label}_mode-{mode}" for label in ("1.50", "2") for mode in "1b"]
    with ls.Run(out / "label-1.50_mode-1") as run:
        assert run.metadata["scene_file"]["parameters"] == {"label": "1.50", "mode": "1"}
    assert json.loads((out / "label-2_mode-b" / "report.json").read_text())["frames"] == 2


EXACT = """
import loomstone as ls
duration = 0.04
def scene(size: tuple = (0.5, 0.5), corners=None, levels=None, rows: list = []):
    cells = {(0.5, 0.5): 2, (0.3, 0.4): 3}[size]
    assert corners == ((0, 1), (2, 3)) and levels == {1: 2} and rows == [1, 2]
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=size, cells=(cells, cells)), pins=[0])])
def check(run):
    assert len(run) == 2
"""


def test_a_resumed_scene_gets_the_parameters_of_the_first_process(loomstone, tmp_path):
    path, out = tmp_path / "exact.py", tmp_path / "out"
    path.write_text(EXACT)
    words = ["size=0.3,0.4", "corners=((0,1),(2,3))", "levels={1:2}", "rows=1,2"]
    given = [word for each in words for word in ("-p", each)]
    assert loomstone("run", path, "--out", out, "--quiet", *given)[0] == 0
    for again in (["resume", out, "--quiet"], ["check", out]):
        code, said = loomstone(*again)
        assert code == 0, said.err
    assert ls.Run(out).scene().cloths[0].mesh.n_triangles == 18


def test_lists_stored_by_an_older_version_become_tuples_again(loomstone, tmp_path, monkeypatch):
    path, out = tmp_path / "exact.py", tmp_path / "out"
    path.write_text(EXACT.replace("    assert corners", "    corners  # assert "))
    monkeypatch.setattr("loomstone.runs.scene_file.literals", lambda parameters: {})
    assert loomstone("run", path, "--out", out, "--quiet", "-p", "size=0.3,0.4")[0] == 0
    assert ls.Run(out).scene().cloths[0].mesh.n_triangles == 18
