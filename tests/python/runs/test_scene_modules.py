"""Scene files can import modules beside them and use relative paths. Misspelt names of global
variables and functions cause a warning with a hint.
"""

import json
import os
import pickle
import threading
from pathlib import Path

import loomstone as ls
import pytest
from loomstone.runs.scene_file import SceneFile

USES_FILES = """
from __future__ import annotations
from dataclasses import dataclass
from typing import ClassVar
import loomstone as ls
from cells_of_scene import CELLS

duration = 0.08
integrator = ls.SemiImplicitEuler(step=4e-3)

@dataclass
class Size:
    kinds: ClassVar[int] = 1
    length: float = 0.2

def scene(mesh: str = "cloth.obj"):
    assert CELLS == 3
    read = ls.meshes.read(mesh)
    return ls.Scene(cloths=[ls.Cloth(mesh=read, pins=[0])])

def control(sim):
    assert open("cloth.obj").read()

def check(run):
    assert len(run.steps["time"]) == 20
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A directory with a scene file, a module and a mesh, outside the working directory."""
    home, elsewhere = tmp_path / "project", tmp_path / "elsewhere"
    home.mkdir()
    elsewhere.mkdir()
    (home / "files.py").write_text(USES_FILES)
    (home / "cells_of_scene.py").write_text("CELLS = 3\n")
    ls.meshes.write(home / "cloth.obj", ls.grid(size=(0.2, 0.2), cells=(3, 3)))
    monkeypatch.chdir(elsewhere)
    return home


def test_a_scene_file_imports_and_reads_what_lies_beside_it(loomstone, project):
    code, said = loomstone("run", project / "files.py", "--out", "out", "--quiet")
    assert code == 0, said.err
    assert Path.cwd().name == "elsewhere"
    # "out" is relative to the working directory of the command, although the check() of a scene
    # file runs in the directory of that file.
    code, said = loomstone("check", "out")
    assert code == 0 and "the scene's claims hold" in said.out


def test_a_run_is_resumed_from_another_directory(loomstone, project, tmp_path, monkeypatch):
    monkeypatch.chdir(project)
    arguments = ["run", "files.py", "-p", "mesh=cloth.obj", "--quiet"]
    assert loomstone(*arguments, "--out", "whole")[0] == 0
    assert loomstone(*arguments, "--out", "part", "--duration", 0.04)[0] == 0
    monkeypatch.chdir(tmp_path)
    code, said = loomstone("resume", "project/part", "--quiet")
    assert code == 0, said.err
    assert ls.Run("project/part").scene() == ls.Run("project/whole").scene()


def test_a_file_named_on_the_command_line_is_relative_to_the_working_directory(loomstone, project):
    ls.meshes.write("mine.obj", ls.grid(cells=(2, 2)))
    arguments = ["run", project / "files.py", "-p", "mesh=mine.obj", "--out", "out", "--quiet"]
    code, said = loomstone(*arguments)
    assert code == 0, said.err
    assert len(ls.Run("out").topology.triangles) == 8


def test_objects_of_a_scene_file_can_be_pickled(project):
    file = SceneFile.open(project / "files.py", {})
    size = file._module.Size(0.3)
    assert pickle.loads(pickle.dumps(size)) == size


def test_a_scene_file_that_fails_leaves_the_working_directory(loomstone, project):
    (project / "bad.py").write_text("def scene():\n    open('absent')\n")
    code, said = loomstone("run", project / "bad.py")
    assert code == 1 and "line 2: FileNotFoundError" in said.err
    assert Path.cwd().name == "elsewhere"


GOOD = """
import loomstone as ls
def scene(): return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)))])
"""


@pytest.mark.parametrize(
    "text, said",
    [
        ("durration = 0.5", "line 4: 'durration' has no effect; did you mean 'duration'?"),
        ("durration = 0.5\nduration = 1.0", "'durration' has no effect; did you mean 'duration'?"),
        ("step = 1e-3", "'step' has no effect; give integrator = ls.SemiImplicitEuler(step=...)"),
        ("fps = 30", "'fps' has no effect; give rate"),
        ("Duration = 0.5", "'Duration' has no effect; did you mean 'duration'?"),
        ("rates: float = 30", "'rates' has no effect; did you mean 'rate'?"),
        ("def controll(sim): pass", "'controll' has no effect; did you mean 'control'?"),
        ("renderer = integrater = 3", "'integrater' has no effect; did you mean 'integrator'?"),
        ("duration, rte = 1.0, 25", "'rte' has no effect; did you mean 'rate'?"),
    ],
)
def test_a_misspelt_global_gets_a_hint(tmp_path, text, said):
    (tmp_path / "typo.py").write_text(GOOD + text)
    with pytest.warns(ls.SceneWarning) as caught:
        SceneFile.open(tmp_path / "typo.py", {})
    assert any(said in str(each.message) for each in caught)


@pytest.mark.filterwarnings("error::loomstone.SceneWarning")
@pytest.mark.parametrize(
    "text",
    [
        "rate = 30\nrates = [1, 2]",
        "durations = [1.0, 2.0]\nduration = durations[0]",
        "scenes = 3\nprint(scenes)",
        "_check = 3",
        "RADIUS = 0.1\ndef balance(): pass",
        "from pathlib import Path as Scene",
    ],
)
def test_other_globals_get_none(tmp_path, text):
    (tmp_path / "fine.py").write_text(GOOD + text)
    SceneFile.open(tmp_path / "fine.py", {})


def test_wrong_arguments_in_a_scene_file_are_one_sentence(loomstone, tmp_path):
    for number, (mistake, said) in enumerate(
        [
            ("ls.ClothMaterial(0.3)", "ClothMaterial takes keyword arguments only, as in"),
            ("ls.Cloth(material='cotton')", "Cloth.material must be a ClothMaterial, got the str"),
            (
                "ls.grid(cells=(2, 2)).moved((0, 0, 0), 1)",
                "TypeError: moved((0, 0, 0), 1) has wrong arguments; expected moved(tr",
            ),
        ]
    ):
        path = tmp_path / f"wrong{number}.py"
        path.write_text(f"import loomstone as ls\ndef scene(): return {mistake}\n")
        code, told = loomstone("run", path, "--out", tmp_path / "out")
        assert code == 1 and said in told.err and told.err.count("\n") == 1, told.err
        assert f"wrong{number}.py, line 2: TypeError: " in told.err


def test_the_metadata_name_files_by_their_absolute_path(loomstone, project, monkeypatch):
    monkeypatch.chdir(project)
    loomstone("run", "files.py", "-p", "mesh=cloth.obj", "--out", "out", "--quiet")
    stored = ls.Run("out").metadata["scene_file"]
    assert stored["parameters"] == {"mesh": str(project / "cloth.obj")}
    assert json.loads(ls.Run("out").metadata_text)["scene_file"]["path"] == str(
        project / "files.py"
    )


@pytest.mark.parametrize(
    ("text", "line", "call"),
    [
        ("def scene():\n    sys.exit(3)\n", 3, "sys.exit(3)"),
        ("def scene():\n    sys.exit()\n", 3, "sys.exit()"),
        ("sys.exit('too old')\n", 2, "sys.exit('too old')"),
    ],
)
def test_a_scene_file_cannot_end_the_program(loomstone, tmp_path, text, line, call):
    path = tmp_path / "ends.py"
    path.write_text("import sys\n" + text)
    code, said = loomstone("run", path, "--out", tmp_path / "out")
    assert code == 1 and said.err == (
        f"loomstone: {path}, line {line}: a scene file must not end the program, but calls {call};"
        " raise an error instead\n"
    )


@pytest.mark.parametrize(
    ("error", "told"), [("SyntaxError", "SyntaxError"), ("SyntaxError('no')", "no")]
)
def test_a_syntax_error_that_a_scene_file_raises_is_reported_with_its_line(
    loomstone, tmp_path, error, told
):
    path = tmp_path / "raises.py"
    path.write_text(f"\nraise {error}\n")
    code, said = loomstone("run", path, "--out", tmp_path / "out")
    assert code == 1 and said.err == f"loomstone: {path}, line 2: {told}\n"


def test_wrong_input_in_a_scene_file_is_reported_with_its_line(loomstone, tmp_path):
    path = tmp_path / "wrong.py"
    path.write_text(
        "import loomstone as ls\n\n\ndef scene():\n"
        "    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(1, 1)))])\n"
    )
    code, said = loomstone("check", path)
    assert code == 1 and said.err.count("\n") == 1
    assert said.err.startswith(f"loomstone: {path}, line 5: grid: "), said.err


def test_a_claim_without_a_message_is_reported_with_its_source(loomstone, tmp_path):
    path = tmp_path / "claim.py"
    path.write_text(
        "import loomstone as ls\n\nduration = 0.04\n\n\ndef scene():\n"
        "    mesh = ls.grid(size=(0.1, 0.1), cells=(2, 2))\n"
        "    return ls.Scene(cloths=[ls.Cloth(mesh=mesh)])\n\n\n"
        "def check(run):\n    assert len(run) == 77\n"
    )
    assert loomstone("run", path, "--out", tmp_path / "out", "--quiet")[0] == 0
    code, said = loomstone("check", tmp_path / "out")
    assert code == 1
    expected = f"a claim does not hold: {path}, line 12: assert len(run) == 77\n"
    assert said.err.endswith(expected), said.err


@pytest.mark.parametrize("suffix", [".obj", ".stl", ".glb", ".usdz"])
def test_a_mesh_given_as_a_scene_file_is_named(loomstone, tmp_path, suffix):
    path = (tmp_path / "cape").with_suffix(suffix)
    path.touch()
    code, said = loomstone("run", path, "--out", tmp_path / "out")
    assert code == 1 and said.err.count("\n") == 1
    assert "is a mesh, not a scene file" in said.err


@pytest.mark.parametrize(("text", "value"), [("true", True), ("False", False)])
def test_a_bool_is_given_in_lower_or_upper_case(text, value, tmp_path):
    path = tmp_path / "bools.py"
    path.write_text(f"def scene(flip: bool = {not value}):\n    pass\n")
    parameters = {"flip": text if text.islower() else value}
    assert SceneFile.open(path, parameters).parameters == {"flip": value}


def test_two_threads_that_make_scenes_keep_the_working_directory(tmp_path, monkeypatch):
    """The second thread starts while the first is in scene(), and ends after the first."""
    (tmp_path / "slow.py").write_text(
        "import time\nimport loomstone as ls\n"
        "def scene(first: bool = True):\n"
        "    time.sleep(0.1 if first else 0.3)\n"
        "    return ls.Scene(obstacles=[ls.floor()])\n"
    )
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    before = os.getcwd()
    files = [SceneFile.open(tmp_path / "slow.py", {"first": first}) for first in (True, False)]
    threads = [threading.Thread(target=file.scene) for file in files]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert os.getcwd() == before
