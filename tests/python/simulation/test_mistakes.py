"""Mistakes of a user are reported in one clear sentence each."""

import decimal
import fractions
import os

import loomstone as ls
import numpy as np
import pytest
from loomstone import cli
from loomstone.runs.scene_file import SceneFile
from loomstone.sweeps.plan import claim

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
FACES = [[0, 1, 2], [1, 3, 2]]
NAN = float("nan")


def simulation(**scene):
    return ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)))], **scene))


def assign(name, value):
    return setattr(simulation(), name, value)


BOX = ls.meshes.box(size=(0.1, 0.1, 0.1))


def attached_twice(integrator):
    bodies = [
        ls.RigidBody(name=f"box{i}", mesh=BOX, shape="box", position=(2, i, 0)) for i in range(2)
    ]
    ties = [ls.Attachment(cloth="sheet", body=body.name, vertices=[3]) for body in bodies]
    sheet = ls.Cloth(name="sheet", mesh=ls.grid(cells=(4, 4)))
    scene = ls.Scene(cloths=[sheet], bodies=bodies, attachments=ties)
    return ls.Simulation(scene, integrator=integrator)


def with_magnet_on(name):
    sheet = ls.Cloth(name="sheet", mesh=ls.grid(cells=(4, 4)))
    magnet = ls.Magnet(body=name, source=ls.magnetics.sphere(radius=0.01, polarization=(0, 0, 1)))
    return ls.Simulation(ls.Scene(cloths=[sheet], magnets=[magnet]))


@pytest.mark.parametrize(
    "mistake, said",
    [
        (lambda: ls.Simulation(None), "scene must be Scene, got a NoneType"),
        (
            lambda: simulation(
                obstacles=[ls.sphere(radius=0.1, centre=(0, 0, -1))],
                attachments=[ls.Attachment(cloth="cloth", body="sphere", vertices=[0])],
            ),
            r'attachments\[0\].body "sphere" is an obstacle; pin the vertices',
        ),
        (
            lambda: simulation(
                bodies=[ls.RigidBody(name="box", mesh=BOX, shape="box", position=(2, 0, 0))],
                attachments=[ls.Attachment(cloth="", body="box")],
            ),
            r"attachments\[0\].vertices must name at least one vertex, got none",
        ),
        (lambda: ls.BDF2(tolerance=2.0), r"tolerance must be in \(0, 0.1\] \[1\], got 2"),
        (
            lambda: ls.NonlinearMidpoint(newton_tolerance=1.0),
            r"newton_tolerance must be in \(0, 0.1\] \[1\], got 1",
        ),
        (lambda: with_magnet_on("sheet"), r'magnets\[0\].body "sheet" is a cloth; put the magnet'),
        (lambda: ls.Simulation(ls.Cloth()), "scene must be Scene, got a Cloth"),
        (
            lambda: ls.Simulation(ls.Scene(), integrator="bdf2"),
            "integrator must be Integrator, .* got a str",
        ),
        (
            lambda: ls.Simulation(ls.Scene(), integrator=ls.BDF2),
            "integrator must be Integrator,",
        ),
        (lambda: ls.Asynchronous(schedule="heap"), "schedule must be .*nested.*queue.*refill"),
        (lambda: ls.Asynchronous(limiting="springs"), "limiting must be .*potential.*impulses"),
        (
            lambda: simulation(integrator=ls.Asynchronous(predicted=-0.1)),
            r"Asynchronous.predicted must be > 0 \[1\], got -0.1",
        ),
        (
            lambda: simulation(integrator=ls.Asynchronous(safety=2.0)),
            r"Asynchronous.safety must be in \(0, 1\] \[1\], got 2",
        ),
        (
            lambda: attached_twice(ls.Asynchronous()),
            "attachments must tie a vertex to one body .* got vertex 3 .* tied to box0 and box1",
        ),
        (
            lambda: attached_twice(ls.SymplecticEuler(step=1e-4)),
            "attachments require an implicit or asynchronous integrator, got symplectic-euler",
        ),
        (
            lambda: ls.Simulation(
                ls.Scene(
                    cloths=[ls.Cloth(mesh=ls.grid(size=(1, 1), cells=(10, 10)), thickness=0.08)]
                )
            ),
            (
                r"cloths\[0\].thickness must be at most the smallest height of a triangle,"
                r" 0.0707107 m, got 0.08 m"
            ),
        ),
        (
            lambda: ls.Simulation(
                ls.Scene(
                    cloths=[
                        ls.Cloth(
                            mesh=ls.grid(size=(1, 1), cells=(4, 4)),
                            pins=[0],
                            script_times=[0, 1],
                            script_positions=[[5, 0, 0], [5, 0, 1]],
                        )
                    ]
                )
            ),
            (
                r"script_positions must begin where the vertices are \(within the mean edge, .*\),"
                r" but vertex 0 begins 5.* m away"
            ),
        ),
        (lambda: ls.Simulation(ls.Scene(), threads="two"), "threads must be int, got a str"),
        (lambda: ls.Simulation(ls.Scene(), threads=10**6), r"threads must be in \[0, 1024\]"),
        (lambda: ls.Simulation(ls.Scene()), "nothing to simulate"),
        (
            lambda: ls.TriangleMesh(SQUARE, [[0, 1, 2.5], [1, 3, 2]]),
            "triangles must be whole numbers, got fractions",
        ),
        (
            lambda: ls.TriangleMesh("abc", FACES),
            "vertices must be an array of numbers, got an array of <U3",
        ),
        (
            lambda: ls.TriangleMesh(None, FACES),
            "vertices must be an array of numbers, got a NoneType",
        ),
        (
            lambda: ls.TriangleMesh(SQUARE[:, :2], FACES),
            r"vertices must have shape \(n, 3\), got \(4, 2\)",
        ),
        (
            lambda: ls.TriangleMesh(SQUARE * 1j, FACES),
            "vertices must be an array of numbers, got an array of complex128",
        ),
        (lambda: ls.TriangleMesh(SQUARE * NAN, FACES), "vertex 0 must have finite coordinates"),
        (
            lambda: ls.TriangleMesh(SQUARE, [[0, 1, 9], [1, 3, 2]]),
            "must refer to vertices 0 to 3, got 9",
        ),
        (
            lambda: ls.TriangleMesh(SQUARE, [[0, 1, 2**32 + 2], [1, 3, 2]]),
            r"triangles must be whole numbers in \[-2147483648, 2147483647\], got 4294967298",
        ),
        (
            lambda: ls.TriangleMesh(SQUARE, [[0, 1, 2.0**40], [1, 3, 2]]),
            r"triangles must be whole numbers in \[-2147483648, 2147483647\], got 1099511627776",
        ),
        (
            lambda: ls.TriangleMesh(SQUARE, [[0, 1, NAN], [1, 3, 2]]),
            r"triangles must be whole numbers in \[-2147483648, 2147483647\], got nan",
        ),
        (
            lambda: ls.Simulation(
                ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)), pins=np.arange(9) < 3)])
            ),
            "pins must be vertex indices, got a truth value for each of 9",
        ),
        (
            lambda: ls.meshes.write("mesh.glb", BOX),
            "mesh.glb: must end in .obj, .ply or a format of meshio, such as",
        ),
        (
            lambda: ls.meshes.write("no/such/mesh.stl", BOX),
            "no/such/mesh.stl: cannot be written: No such file",
        ),
        (lambda: ls.grid(size=1, cells=(2, 2)), "size must be 2 finite numbers, got 1"),
        (lambda: ls.grid(size=(1, NAN), cells=(2, 2)), "size must be 2 finite numbers"),
        (lambda: ls.grid(cells=(2.5, 2)), "cells must be a whole number, got 2.5"),
        (lambda: ls.grid(cells=(0, 2)), r"cells must be in \[1, 20000\], got 0"),
        (lambda: ls.grid(triangles=10**12), r"triangles must be in \[2, 100000000\]"),
        (lambda: ls.grid(triangles="many"), "triangles must be a whole number, got 'many'"),
        (lambda: ls.meshes.disc(radius="big", triangles=9), "radius must be > 0"),
        (lambda: ls.meshes.irregular(triangles=1), r"triangles must be in \[2"),
        (lambda: BOX.moved((0, 0)), r"translation must have shape \(3,\), got \(2,\)"),
        (lambda: BOX.moved((0, 0, 0), rotation=[1, 2, 3]), r"rotation must have shape \(3, 3\)"),
        (
            lambda: ls.sphere(radius=1, centre=(0, 0)),
            r"centre must be 3 finite numbers, got \(0, 0\)",
        ),
        (
            lambda: ls.sphere(radius=1, positions=[[0, 0, 0]]),
            "positions and axis_angles require times",
        ),
        (lambda: ls.capsule(radius=1, length=1, axis=(0, 0, 0)), "axis must have a direction"),
        (lambda: ls.meshes.SpatialQuery(BOX).closest((0, 0), 1), r"point must have shape \(3,\)"),
        (
            lambda: ls.collision.intersecting_pairs(SQUARE, [[0, 1, 9]]),
            r"triangles must hold point indices in \[0, 4\), got 0 to 9",
        ),
        (lambda: ls.fabrics["coton"], "there is no fabric 'coton'; did you mean 'cotton'"),
        (
            lambda: simulation(bodies=[ls.RigidBody(mesh=BOX, position=(NAN, 0, 0))]),
            r"bodies\[0\].position must be finite",
        ),
        (
            lambda: simulation(bodies=[ls.RigidBody(mesh=BOX, velocity=(NAN, 0, 0))]),
            r"bodies\[0\].velocity must be finite",
        ),
        (lambda: simulation().set_obstacle_pose(0, (0, 0, 0)), "but has none"),
        (
            lambda: simulation(obstacles=[ls.floor(height=-1)]).set_obstacle_pose(3, (0, 0, 0)),
            r"obstacle must be in \[0, 0\]",
        ),
        (
            lambda: simulation(obstacles=[ls.floor(height=-1)]).set_obstacle_pose(0, (0, 0)),
            r"position must have shape \(3,\)",
        ),
        (lambda: simulation().set_pin_targets(np.full((25, 3), NAN)), "must be finite"),
        (lambda: simulation().restore(None), "checkpoint must be Checkpoint, got a NoneType"),
        (
            lambda: assign("positions", None),
            "positions must be an array of numbers, got a NoneType",
        ),
        (lambda: assign("positions", [[1, 2], [3]]), "positions must be an array of numbers"),
        (
            lambda: assign("positions", np.zeros((25, 3), complex)),
            "positions must be an array of numbers",
        ),
        (
            lambda: simulation().run(out="/proc/none", duration=0.04),
            "must be a directory that can be written",
        ),
        (
            lambda: simulation().run(out="unused", duration=0.04, render="yes"),
            "render must be RenderOptions, True or False",
        ),
        (lambda: list(simulation().frames(duration=1.0, rate=1e12)), "at most 1000000 frames"),
    ],
)
def test_a_mistake_in_python_is_one_sentence(mistake, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ls.InvalidInput, ls.CacheError, ls.Unsupported), match=said) as told:
        mistake()
    assert "\n" not in str(told.value)


def test_arguments_of_the_wrong_kind_are_reported_in_one_line():
    for mistake in (
        lambda: ls.sphere(radius="big"),
        lambda: ls.floor(cells="many"),
        lambda: ls.meshes.capsule(radius=1, length=None),
    ):
        with pytest.raises(TypeError, match="an argument has the wrong type, got .*=") as told:
            mistake()
        assert "\n" not in str(told.value)


def test_a_long_value_is_cut_between_two_characters():
    with pytest.raises(TypeError, match="\u00e4" * 199 + ";"):
        ls.Cloth(mesh="\u00e4" * 300)


def test_a_misspelt_attribute_of_a_simulation_is_an_error():
    with pytest.raises(AttributeError):
        assign("position", np.zeros((25, 3)))


def test_names_of_fabrics_behave_as_in_a_dictionary():
    assert "silk" in ls.fabrics and "coton" not in ls.fabrics and ls.fabrics.get("coton") is None
    assert ls.fabrics.get("silk") == ls.fabrics["silk"] and repr(ls.fabrics).startswith(
        "fabrics(cotton"
    )


GOOD = """
import loomstone as ls
duration = 0.04
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene(cells: int = 4, fabric: str = "silk"):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(cells, cells)), pins=[0])])
"""


@pytest.fixture
def loomstone(tmp_path, monkeypatch, capsys):
    """Function that runs loomstone in this process and returns its exit code and output."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.py").write_text(GOOD)

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.app([str(a) for a in arguments], prog_name="loomstone")
        return end.value.code, capsys.readouterr()

    return call


@pytest.mark.parametrize(
    "arguments, said, expected",
    [
        ("-p cells=abc", "parameter cells must be an int like 4, got 'abc'", 1),
        ("-p cell=3", "did you mean cells", 1),
        ("-p cells", "-p must be name=value", 2),
        ("-p cells=3 -p cells=4", "-p cells must be given once", 2),
        ("-p cells={1,2}", "-p cells must be a number, text, list or dict", 1),
        ("-p cells=0", "cells must be in [1, 20000], got 0", 1),
        ("--duration -1", "duration must be finite and >= 0", 2),
        ("--duration inf", "duration must be finite and >= 0", 2),
        ("--rate 0", "rate must be finite and > 0", 2),
        ("--rate 1e12", "at most 1000000 frames", 1),
        ("--step 0", "step must be > 0", 2),
        ("--step foo", "--step must be a time [s] or auto", 2),
        ("--step 1000", "shorten integrator.step", 1),
        ("--integrator bdf", "--integrator must be one of", 2),
        ("--decomposition foo", "decomposition must be one of predicted | static | dynamic", 2),
        ("--threads 5000", "threads must be in [0, 1024]", 1),
        ("--out /proc/none", "must be a directory that can be written", 1),
        ("--out scene.py", "must be a directory that can be written", 1),
    ],
)
def test_a_mistake_on_the_command_line_is_one_sentence(loomstone, arguments, said, expected):
    code, told = loomstone("run", "scene.py", *arguments.split(" "))
    assert (
        code == expected
        and told.err.startswith("loomstone: ")
        and told.err.count("\n") == 1
        and said in told.err
    )


@pytest.mark.parametrize(
    "text, said",
    [
        ("x = ", "broken.py, line 1: invalid syntax"),
        ("import nosuch", "broken.py, line 1: ModuleNotFoundError: No module named 'nosuch'"),
        ("def scene():\n    return foo", "broken.py, line 2: NameError: name 'foo' is not defined"),
        ("def scene():\n    return 3", "scene() must return a Scene, got a int"),
        ("scene = 4", "must define a function scene()"),
        ("def scene(n):\n    return n", "scene() needs a value for n; give -p n=..."),
        (GOOD + "duration = 'long'", "duration must be a number, got 'long'"),
        (GOOD + "rate = None", "rate must be a number, got None"),
        (GOOD + "integrator = 'bdf2'", "integrator must be an Integrator"),
        (GOOD + "control = 3", "control must be a function"),
        (
            GOOD + "def control(sim): sim.positions = sim.positions * float('nan')",
            "positions must be finite, but row 0 is not",
        ),
        (GOOD + "def control(sim): undefined", "broken.py, line 7: NameError"),
        (GOOD + "def control(): pass", "TypeError: control() takes 0 positional arguments"),
        (
            "import loomstone as ls\ndef scene():\n    return ls.Scene(cloths=[ls.Cloth(mash=1)])",
            "did you mean 'mesh'?",
        ),
    ],
)
def test_a_mistake_in_a_scene_file_is_reported_with_its_line(loomstone, tmp_path, text, said):
    (tmp_path / "broken.py").write_text(text)
    code, told = loomstone("run", "broken.py")
    assert (
        code == 1
        and told.err.startswith("loomstone: ")
        and told.err.count("\n") == 1
        and said in told.err
    )


def test_files_that_are_something_else_are_refused(loomstone, tmp_path):
    (tmp_path / "noise.py").write_bytes(os.urandom(4000))
    (tmp_path / "empty").mkdir()
    (tmp_path / "foreign.h5").write_bytes(b"noise" * 1000)
    for arguments, said in [
        (["run", "noise.py"], "scene file cannot be read"),
        (["run", "absent.py"], "scene file cannot be read: No such file"),
        (["run", tmp_path], "scene file cannot be read: Is a directory"),
        (["resume", "empty"], "holds no run"),
        (["resume", "absent"], "No such file"),
        (["resume", "scene.py"], "not an HDF5 file"),
        (["render", "empty"], "holds no run"),
        (["check", "empty"], "holds no run"),
        (["plot", "empty"], "no table of steps"),
        (["info", "foreign.h5"], "not a loomstone checkpoint"),
        (["info", "absent"], "no such file"),
    ]:
        code, told = loomstone(*arguments)
        assert code == 1 and told.err.count("\n") == 1 and said in told.err, told.err


def test_commands_for_runs_refuse_the_directory_of_a_sweep_and_name_a_run(loomstone, tmp_path):
    sweep = tmp_path / "sweep"
    claim(sweep, {"scene": ""})
    for command in ("info", "render", "plot", "check", "resume", "export"):
        code, told = loomstone(command, sweep)
        assert code == 1 and told.err == (
            f"loomstone: {sweep}: holds a sweep; give the directory of one of its runs\n"
        )
    run = sweep / "size-0.1"
    run.mkdir()
    (run / "run.vtkhdf").write_bytes(b"")
    assert loomstone("info", sweep)[1].err.endswith(f"one of its runs, such as {run}\n")


def test_mistakes_about_a_run_are_reported(loomstone, tmp_path):
    assert loomstone("run", "scene.py", "--out", "out", "--threads", 1)[0] == 0
    for arguments, said in [
        (["run", "scene.py", "--out", "out"], "must hold no run yet"),
        (["render", "out", "--frame", 99], "--frame must be in [0, 1]"),
        (["render", "out", "--color-by", "mood"], "color_by must be"),
        (["plot", "out", "--out", "/nowhere/a.png"], "the plot cannot be written"),
    ]:
        code, told = loomstone(*arguments)
        assert code == 1 and told.err.count("\n") == 1 and said in told.err, told.err
    code, told = loomstone("plot", "out", "--what", "mood")
    assert code == 2 and "--what must be one of" in told.err
    assert len(ls.Run("out")[:1]) == 1 and ls.Run("out")[np.int64(1)].step == 10


def test_a_scene_may_take_any_name(tmp_path):
    (tmp_path / "any.py").write_text("def scene(**given): return given")
    assert SceneFile.open(tmp_path / "any.py", {"zz": 3}).parameters == {"zz": 3}


def test_a_pose_that_is_not_finite_is_refused(falling):
    sim = ls.Simulation(falling, threads=1)
    for orientation in ((float("nan"), 0, 0, 0), (1, 0, 0, float("inf"))):
        with pytest.raises(ls.InvalidInput, match="a finite position"):
            sim.set_obstacle_pose(0, (0, 0, 0), orientation)
    sim.step()
    assert np.isfinite(sim.frame().body_vertices).all()


def test_a_step_that_fails_leaves_the_report_of_the_last_step(hanging):
    sim = ls.Simulation(hanging, threads=1)
    sim.step()
    before = sim.report.numbers()
    sim.external_forces = np.full_like(sim.positions, 1e160)
    with pytest.raises(ls.SolverFailure, match="step 2"):
        sim.step()
    assert sim.report.numbers() == before and sim.step_index == 1


@pytest.mark.parametrize(
    "number", [np.float32(20.7), decimal.Decimal("20.7"), fractions.Fraction(7, 2), np.array(20.7)]
)
def test_whole_numbers_are_not_cut_from_fractions(number, falling):
    with pytest.raises(TypeError):
        ls.Scene(rigid_iterations=number)
    with pytest.raises(TypeError, match=r"pins\[1\] must be a whole number"):
        ls.Cloth(mesh=ls.grid(cells=(4, 4)), pins=[0, number])
    with pytest.raises(TypeError):
        ls.Simulation(falling, threads=1).set_obstacle_pose(number, (0, 0, 0))
    assert ls.Scene(rigid_iterations=np.int32(20)).rigid_iterations == 20
