"""Output of the command `loomstone`, example files that it writes, and directories of its runs."""

import json
import shutil
import signal
import subprocess
from pathlib import Path

import loomstone as ls
import numpy as np
import pytest
from loomstone import cli
from loomstone.cli.estimate import memory_of, memory_text
from loomstone.cli.options import one_of
from loomstone.cli.scenes import scene_files
from loomstone.runs import progress, progress_lines
from loomstone.runs.execution import execute
from loomstone.runs.options import RunOptions
from loomstone.runs.scene_file import SceneFile
from loomstone.runs.signals import Interrupted
from loomstone.runs.stored_scene import read_scene, write_scene

SCENES = Path(__file__).parents[3] / "scenes"
SMALL = """
import loomstone as ls
duration = 0.08
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene(cells: int = 4):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(cells, cells)), pins=[0])])
"""


@pytest.fixture
def loomstone(tmp_path, monkeypatch, capsys):
    """Function that runs loomstone in this process and returns its exit code and output."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.py").write_text(SMALL)

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.app([str(a) for a in arguments], prog_name="loomstone")
        return end.value.code, capsys.readouterr()

    return call


def test_the_version_is_printed(loomstone):
    code, said = loomstone("--version")
    assert code == 0 and said.out == f"loomstone {ls.__version__}\n"


def test_a_run_says_what_it_does_before_it_builds_the_scene(loomstone):
    code, said = loomstone("run", "scene.py", "--out", "out")
    assert code == 0
    assert said.out.splitlines()[:2] == [
        "reading scene.py",
        "building 32 triangles of cloth: about 60 MB of memory",
    ]


def test_quiet_prints_nothing_but_warnings_and_errors(loomstone, tmp_path):
    code, said = loomstone("run", "scene.py", "--out", "out", "--quiet")
    assert code == 0 and said.out == said.err == ""
    assert len(ls.Run("out")) == 3
    assert loomstone("resume", "out", "--quiet") == (0, ("", ""))
    heavy = SMALL.replace("pins=", "material=ls.ClothMaterial(density=150), pins=")
    (tmp_path / "heavy.py").write_text(heavy)
    code, said = loomstone("run", "heavy.py", "--quiet")
    assert code == 0 and said.out == ""
    assert said.err.startswith("loomstone: warning: cloths[0]: its density is 150 kg/m^2")
    assert said.err.count("\n") == 1


def test_check_tells_what_looks_like_a_mistake(loomstone, tmp_path):
    heavy = SMALL.replace("pins=", "material=ls.ClothMaterial(density=150), pins=")
    (tmp_path / "heavy.py").write_text(heavy)
    code, said = loomstone("check", "heavy.py")
    assert code == 0 and "if 150 g/m^2 is meant, give 0.15" in said.err
    assert loomstone("check", "scene.py")[1].err == ""


def test_json_is_one_object_for_programs(loomstone):
    code, said = loomstone("run", "scene.py", "--out", "out", "--json")
    report = json.loads(said.out)
    assert code == 0 and said.err == ""
    assert report["frames"] == 3 and report["run"] == "out/run.vtkhdf"
    assert report["digest"] == json.loads(Path("out/report.json").read_text())["digest"]
    again = json.loads(loomstone("resume", "out", "--json")[1].out)
    assert again["digest"] == report["digest"]
    code, said = loomstone("run", "scene.py", "--out", "other", "--json", "--quiet")
    assert code == 2 and "--quiet and --json must not be given together" in said.err


def test_json_is_not_mixed_with_what_a_scene_file_prints(loomstone, tmp_path):
    prints = "print('module')\ndef control(sim):\n    print('control')\n"
    noisy = prints + SMALL.replace("    return", "    print('scene')\n    return")
    (tmp_path / "noisy.py").write_text(noisy)
    for command in (("run", "noisy.py", "--out", "out"), ("resume", "out"), ("info", "noisy.py")):
        code, said = loomstone(*command, "--json")
        assert code == 0 and isinstance(json.loads(said.out), dict), command
        assert said.err.startswith("module\n"), command
        assert ("control\n" in said.err) == (command[0] == "run")
    assert "module\n" in loomstone("info", "noisy.py")[1].out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("check", "out", "-p", "nonsense=1"), "-p is an option for scene files, but out is a run"),
        (("check", "out", "--render", "a.png"), "--render is an option for scene files"),
        (("plot", "out", "--mesh", "a.obj"), "--mesh is an option for the magnets of `plot force`"),
        (("plot", "out", "--axis", "1,0,0"), "--axis is an option for the magnets"),
        (("plot", "force", "out", "--mesh", "a.obj"), "given by --mesh, and nothing else, got"),
        (("plot", "force", "torque", "--mesh", "a.obj"), "got also torque; leave out torque"),
        (("plot", "torque", "--mesh", "a.obj", "--reach", "1"), "--reach is an option for `plot f"),
    ],
)
def test_an_option_that_would_have_no_effect_is_refused(loomstone, tmp_path, arguments, said):
    (tmp_path / "out").mkdir()
    code, told = loomstone(*arguments)
    assert code == 2 and said in told.err and told.err.count("\n") == 1


def test_info_describes_every_kind_of_file_as_json(loomstone, tmp_path):
    loomstone("run", "scene.py", "--out", "out", "-p", "cells=3", "--quiet")
    ls.meshes.write("mesh.obj", ls.grid(cells=(2, 2)))

    def facts(path):
        code, said = loomstone("info", path, "--json")
        assert code == 0, said.err
        return json.loads(said.out)

    run = facts("out")
    assert (run["kind"], run["frames"], run["triangles"]) == ("run", 3, 18)
    assert run["parameters"] == {"cells": 3} and run["steps"]["largest_stretch"] >= 1.0
    scene = facts("scene.py")
    assert scene["duration"] == 0.08 and scene["parameters"] == {"cells": 4}
    assert scene["integrator"]["step"] == 4e-3
    assert facts("mesh.obj")["vertices"] == 9
    stored = facts(next(Path("out").glob("checkpoint-*")))
    assert stored["arrays"]["cloth.x"] == [16, 3]
    assert loomstone("info", "absent", "--json")[0] == 1


def test_scenes_are_listed_and_copied(loomstone):
    assert {path.name for path in scene_files().values()} == {
        path.name for path in SCENES.glob("*.py")
    }
    listed = loomstone("scenes")[1].out.splitlines()
    assert "drape              A square cloth falls onto a sphere and comes to rest in folds" in (
        listed
    )
    assert loomstone("scenes", "drape")[0] == 0
    assert Path("drape.py").read_text() == (SCENES / "drape.py").read_text()
    for arguments, said in [
        (["scenes", "drape"], "drape.py must not exist yet"),
        (["scenes", "drap"], "there is no scene 'drap'; did you mean drape?"),
        (["scenes", "drape", "--out", "no/such/place.py"], "cannot be written: No such file"),
    ]:
        code, told = loomstone(*arguments)
        assert code == 1 and said in told.err and told.err.count("\n") == 1


def test_a_new_scene_file_runs_and_keeps_its_claims(loomstone):
    assert "loomstone run 'my scene.py'" in loomstone("new", "my scene.py")[1].out
    assert loomstone("new", "mine.py")[0] == 0
    code, said = loomstone("run", "mine.py", "--out", "out", "-p", "triangles=200", "--quiet")
    assert code == 0 and said.err == ""
    code, said = loomstone("check", "out")
    assert code == 0 and "the scene's claims hold" in said.out
    code, said = loomstone("new", "mine.py")
    assert code == 1 and "mine.py must not exist yet" in said.err


def test_the_demo_simulates_the_drape_and_draws_it(loomstone, tmp_path, monkeypatch):
    drape = SMALL.replace("cells: int = 4", "triangles: int = 32").replace(
        "(cells, cells)", "(4, 4)"
    )
    (tmp_path / "drape.py").write_text(drape)
    monkeypatch.setattr("loomstone.cli.demo.scene_files", lambda: {"drape": tmp_path / "drape.py"})
    code, said = loomstone("demo")
    assert code == 0 and "video: out/demo/video.mp4" in said.out
    assert ls.Run("out/demo").metadata["scene_file"]["parameters"] == {"triangles": 3600}
    assert len(list(Path("out/demo/frames").glob("*.png"))) == 3
    code, said = loomstone("demo")
    assert code == 1 and "out/demo" in said.err and said.err.count("\n") == 1
    assert loomstone("demo", "--overwrite")[0] == 0


def test_a_shell_completes_commands_and_names(loomstone, monkeypatch):
    def completed(words, number):
        monkeypatch.setenv("_LOOMSTONE_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", words)
        monkeypatch.setenv("COMP_CWORD", str(number))
        return loomstone()[1].out.split()

    assert completed("loomstone re", 1) == ["resume", "render", "replay", "report"]
    assert completed("loomstone run --integrator b", 3) == ["backward-euler", "bdf2"]
    assert completed("loomstone plot --what st", 3) == ["stages", "step", "strain", "stretch"]
    assert completed("loomstone render --color-by stre", 3) == ["stretch"]
    assert completed("loomstone render --pass d", 3) == ["depth"]
    assert completed("loomstone export --to u", 3) == ["usd"]
    assert completed("loomstone scenes dr", 2) == ["dragon", "drape", "dress"]
    assert one_of(["b", "ab", "aa"])("a") == ["aa", "ab"]


def test_a_duration_that_is_no_whole_number_of_frames_is_told(loomstone):
    code, said = loomstone("run", "scene.py", "--out", "out", "--duration", 0.02)
    assert code == 0
    assert "duration 0.02 s is 0.5 frames at 25 frames/s, so no step is taken" in said.out
    assert "frames at" not in loomstone("run", "scene.py", "--out", "whole")[1].out
    code, said = loomstone("run", "scene.py", "--out", "quiet", "--duration", 0.02, "--quiet")
    assert said.out == "" and "so no step is taken" in said.err


def test_a_directory_that_holds_no_run_is_not_written_into(loomstone, tmp_path):
    thesis = tmp_path / "thesis"
    thesis.mkdir()
    (thesis / "chapter.tex").write_text("text")
    (thesis / "frames").mkdir()
    code, said = loomstone("run", "scene.py", "--out", "thesis")
    assert code == 1 and "building" not in said.out
    assert said.err == (
        "loomstone: thesis must be empty or absent, but contains chapter.tex and 1 more, which no"
        " run has written; give another directory, or overwrite, which replaces"
        " only files that have the names of files of a run\n"
    )
    assert {path.name for path in thesis.iterdir()} == {"chapter.tex", "frames"}
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)))]))
    with pytest.raises(ls.CacheError, match="contains chapter.tex"):
        sim.run(out=thesis, duration=0.04)
    assert loomstone("run", "scene.py", "--out", "thesis", "--overwrite")[0] == 0
    assert (thesis / "chapter.tex").read_text() == "text" and len(ls.Run(thesis)) == 3
    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / ".gitkeep").touch()
    assert loomstone("run", "scene.py", "--out", "hidden", "--quiet")[0] == 0


def test_memory_is_estimated_from_the_sizes_of_a_scene(monkeypatch):
    def scene(cells, **fields):
        return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(cells, cells)))], **fields)

    euler = ls.SemiImplicitEuler()
    small, large = memory_of(scene(10), euler), memory_of(scene(100), euler)
    # The estimate is 60 MB for the program and 4.1 kB for each of the 200 or 20,000 triangles:
    # 61 MB and 142 MB.
    assert small < 62e6 and 130e6 < large < 150e6
    assert memory_of(scene(100), ls.BackwardEuler()) > large
    assert memory_of(scene(100), ls.SemiImplicitEuler(linear_solver="direct")) > large
    assert memory_of(scene(100, obstacles=[ls.sphere(radius=1.0)]), euler) > large
    monkeypatch.setattr("loomstone.cli.estimate._available", lambda: 1e8)
    assert memory_text(scene(100), euler) == (
        "building 20000 triangles of cloth: about 142 MB of memory, more than the 100 MB that are"
        " free"
    )


def test_a_frame_that_takes_long_shows_signs_of_life(monkeypatch, capsys):
    monkeypatch.setattr(progress_lines, "LONGEST_SILENCE", -1.0)
    lines = progress_lines.Lines()
    lines.start(2, 0)
    lines.step(ls.StepReport())
    assert capsys.readouterr().out.startswith("step 0  t 0.000 s")


def test_a_terminal_gets_a_progress_bar(monkeypatch, capsys):
    monkeypatch.delenv("OMPI_COMM_WORLD_SIZE", raising=False)
    monkeypatch.delenv("PMI_SIZE", raising=False)
    assert isinstance(progress.observer(), progress_lines.Lines)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    bar = progress.observer()
    bar.start(2, 0)
    bar.step(ls.StepReport())
    bar.frame(0, simulation().frame())
    bar.end()
    assert "1/2" in capsys.readouterr().out


def test_progress_shows_the_times_of_frames(tmp_path, capsys):
    sim = simulation()
    options = RunOptions(duration=0.1, rate=30.0)  # a frame every 33 ms, between steps of 4 ms
    execute(sim, options, tmp_path, observer=progress_lines.Lines())
    lines = capsys.readouterr().out.splitlines()
    shown = [line.split("  ")[:2] for line in lines if line.startswith("frame")]
    assert shown == [[f"frame {k + 1}/4", f"t {k / 30:.3f} s"] for k in range(4)]


def simulation(kind=ls.Simulation):
    mesh = ls.grid(size=(0.2, 0.2), cells=(6, 6)).moved((0, 0, 0.12))
    described = ls.Scene(
        cloths=[ls.Cloth(name="sheet", mesh=mesh, material=ls.fabrics["silk"])],
        obstacles=[ls.sphere(radius=0.1, subdivisions=2)],
    )
    return kind(described, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)


class Stopped(ls.Simulation):
    """A simulation that is stopped by a signal after its twentieth step."""

    def step(self):
        super().step()
        if self.step_index == 20:
            signal.raise_signal(signal.SIGTERM)


def test_a_run_begun_in_python_is_resumed_by_the_command(loomstone):
    whole = simulation().run(out="whole", duration=0.2)
    with pytest.raises(Interrupted):
        simulation(Stopped).run(out="stopped", duration=0.2)
    assert len(ls.Run("stopped")) == 3
    code, said = loomstone("resume", "stopped", "--quiet")
    assert code == 0, said.err
    assert json.loads(Path("stopped/report.json").read_text())["digest"] == whole["digest"]
    assert ls.Run("stopped").scene() == simulation().scene
    assert "from Python" in loomstone("info", "stopped")[1].out
    code, said = loomstone("check", "stopped")
    assert code == 0 and "was begun in Python" in said.out


def test_a_run_that_needs_python_says_so_before_it_starts(loomstone):
    simulation().run(out="driven", duration=0.04, control=lambda sim: None)
    code, told = loomstone("resume", "driven")
    assert code == 1 and "was run with a control function in Python" in told.err
    assert told.err.count("\n") == 1 and "building" not in told.out
    simulation().run(out="plain", duration=0.04)
    for name, change, said in [
        ("noise", lambda out: (out / "scene.npz").write_bytes(b"noise"), "cannot be read"),
        ("absent", lambda out: (out / "scene.npz").unlink(), "neither a scene file nor scene.npz"),
        (
            "begun",
            lambda out: [path.unlink() for path in out.glob("checkpoint-*")],
            "has no checkpoint to resume from",
        ),
    ]:
        shutil.copytree("plain", name)
        change(Path(name))
        code, told = loomstone("resume", name)
        assert code == 1 and said in told.err and told.err.count("\n") == 1, told.err


def test_the_scenes_are_installed_with_the_package(tmp_path):
    root = SCENES.parent
    noted = root / ".venv" / "build-directory"
    if not noted.exists() or not shutil.which("cmake"):
        pytest.skip("needs the build directory of scripts/setup and cmake")
    install = ["cmake", "--install", root / noted.read_text().strip()]
    install += ["--component", "python", "--prefix", tmp_path]
    subprocess.run(install, check=True, capture_output=True)
    installed = {path.name for path in (tmp_path / "loomstone" / "scenes").iterdir()}
    assert installed == {path.name for path in SCENES.glob("*.py")}


@pytest.mark.parametrize("name", ["clasp", "levitation", "toy_magnets", "voice_coil", "twist"])
def test_a_stored_scene_is_equal_to_the_scene(name, tmp_path):
    parameters = {"triangles": 50} if name in ("clasp", "twist", "voice_coil") else {}
    described = SceneFile.open(SCENES / f"{name}.py", parameters).scene()
    write_scene(tmp_path, described)
    assert read_scene(tmp_path) == described
    assert [path.name for path in tmp_path.iterdir()] == ["scene.npz"]


def test_a_damaged_stored_scene_is_an_error_in_one_sentence(tmp_path):
    write_scene(tmp_path, simulation().scene)
    whole = (tmp_path / "scene.npz").read_bytes()
    random, refused = np.random.default_rng(3), 0
    for number in range(100):
        damaged = bytearray(whole)
        if number % 2:
            damaged = damaged[: random.integers(len(whole))]
        else:
            for place in random.integers(len(whole), size=20):
                damaged[place] = random.integers(256)
        (tmp_path / "scene.npz").write_bytes(damaged)
        try:
            read_scene(tmp_path)
        except ls.CacheError as error:
            refused += 1
            assert "the scene cannot be read" in str(error) and "\n" not in str(error)
    assert refused > 90  # damage to dates, for example, has no effect
    for text in ("[]", '{"description": "Scene", "fields": []}', '{"source": "os", "state": 1}'):
        np.savez(tmp_path / "scene.npz", scene=np.array(text))
        with pytest.raises(ls.CacheError):
            read_scene(tmp_path)


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("view out --paused", "--paused"),
        ("view out -p cells=3", "--parameter"),
        ("view out --html page.html --port 9", "--port"),
        ("render out --frame 1 --again", "--again"),
        ("render out --pass id --jobs 2", "--jobs"),
        ("plot force --what step", "--what"),
        ("plot out --reach 1", "--reach"),
        ("field magnet.obj --plane xy", "--plane"),
        ("info out --source --json", "--json"),
    ],
)
def test_options_without_effect_are_refused(loomstone, command, option):
    loomstone("run", "scene.py", "--out", "out", "--quiet")
    code, said = loomstone(*command.split())
    assert code == 2 and said.err.startswith(f"loomstone: {option} ")
    assert said.err.endswith("; leave it out\n")
