"""A failure on one rank is a failure on all: the same error, no deadlock, and files from which the
run can be read and resumed.
"""

import os
import subprocess
import textwrap
import time

import loomstone as ls
import pytest
from launcher import ENVIRONMENT, command, needs_mpirun, ranks
from loomstone.runs.lock import DirectoryLock

pytestmark = needs_mpirun

SCENE = """
import os
import resource
import loomstone as ls
duration = 0.4
integrator = ls.SemiImplicitEuler(step=4e-3)
rank = int(os.environ.get("OMPI_COMM_WORLD_RANK", "0"))
def scene(cells: int = 16, fault: str = ""):
    global wanted
    wanted = fault
    mesh = ls.grid(size=(0.3, 0.3), cells=(cells, cells))
    return ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=[0])])
def control(sim):
    if sim.step_index != 25:
        return
    if wanted == "nan" and rank == 1:
        sim.state.positions[3, 1] = float("nan")
    if wanted == "error" and rank == 1:
        raise ls.SolverFailure("rank 1 has had enough")
    if wanted == "mistake" and rank == 1:
        1 / 0
    if wanted == "claim" and rank == 1:
        assert sim.time < 0.0
    if wanted == "full" and rank == 0:
        size = os.path.getsize(os.path.join(os.environ["OUT"], "run.vtkhdf"))
        resource.setrlimit(resource.RLIMIT_FSIZE, (size // 2, resource.RLIM_INFINITY))
"""


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE)
    return tmp_path / "scene.py"


def run(scene, out, *more, n=2, environment=None):
    arguments = command(n, "-m", "loomstone", "run", scene, "--out", out, "--threads", 1, *more)
    return subprocess.run(
        arguments, capture_output=True, text=True, timeout=60, env=ENVIRONMENT | (environment or {})
    )


def simulation():
    """Returns the simulation of the scene file on one rank, without the fault."""
    scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.3, 0.3), cells=(16, 16)), pins=[0])])
    return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)


def resumed_without_faults(out):
    again = simulation()
    return again.run(out=out, duration=0.4, resume=True, control=lambda _: None)["digest"]


def straight():
    sim = simulation()
    for _ in range(100):
        sim.step()
    return sim.digest()


def sentences(done):
    return [line for line in done.stderr.splitlines() if line.startswith("loomstone:")]


@pytest.mark.parametrize(
    "fault, said",
    [
        ("nan", "must be finite, got ("),
        ("error", "rank 1 has had enough"),
        ("mistake", "line 21: ZeroDivisionError"),
        ("claim", "line 23: assert sim.time < 0.0"),
        ("full", "could not"),
    ],
)
def test_a_failure_of_one_rank_is_one_sentence_and_leaves_a_run_that_resumes(
    scene, tmp_path, fault, said
):
    out = tmp_path / "out"
    done = run(scene, out, "-p", f"fault={fault}", environment={"OUT": str(out)})
    assert done.returncode not in (0, None)
    assert (
        len(sentences(done)) == 1 and said in sentences(done)[0] and "Traceback" not in done.stderr
    ), done.stderr
    frames = ls.Run(out)
    assert 2 <= len(frames) <= 4 and frames[-1].positions.shape == (289, 3)
    del frames
    assert resumed_without_faults(out) == straight()


PROGRAM = """
    import sys
    import numpy as np
    import loomstone as ls
    from loomstone import _core
    ranks = _core.mpi_communicator()
    scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(24, 24)), pins=[0])])
    euler = ls.SemiImplicitEuler(step=2e-3)
    sim = ls.Simulation(scene, integrator=euler, threads=1, communicator=ranks)
    sim.step()
    first, end = sim.owned_rows
    def say(*words):  # lines of several ranks run into one another on their way through mpirun
        with open(f"{sys.argv[1]}{ranks.rank}", "a") as file:
            print(*words, file=file)
"""


def program(tmp_path, body, n=2):
    (tmp_path / "program.py").write_text(textwrap.dedent(PROGRAM) + textwrap.dedent(body))
    done = ranks(n, tmp_path / "program.py", tmp_path / "said", timeout=60)
    return done, [path.read_text().splitlines() for path in sorted(tmp_path.glob("said*"))]


def test_every_rank_gets_the_same_error_and_may_go_on_after_correcting_it(tmp_path):
    done, said = program(tmp_path, """
        kept = sim.state.velocities.copy()
        if ranks.rank == 1:
            sim.state.velocities[first, 2] = np.inf
        try:
            sim.step()
        except ls.InvalidInput as error:
            say("error", error)
        sim.state.velocities[:] = kept
        sim.step()
        say("state", sim.digest(), sim.step_index)
    """)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(said) == 2 and said[0] == said[1]
    assert said[0][0].startswith("error velocities of vertex") and said[0][1].startswith("state")


def test_a_checkpoint_that_one_rank_cannot_restore_is_refused_on_all_ranks(tmp_path):
    done, said = program(tmp_path, """
        small = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(3, 3)))])
        other = ls.Simulation(small, communicator=ranks).checkpoint()
        own = sim.checkpoint()
        try:
            sim.restore(other if ranks.rank == 1 else own)
        except ls.Error as error:
            say("error", error)
        sim.restore(own)
        sim.step()
        say("state", sim.digest())
    """)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(said) == 2 and said[0] == said[1] and said[0][0].startswith("error")


def test_what_a_rank_writes_counts_for_the_rows_it_owns(tmp_path):
    done, said = program(tmp_path, """
        sim.state.positions[first:end, 2] += 0.01 * (ranks.rank + 1)
        sim.state.external_forces[first:end] = [0, 0, ranks.rank]
        sim.gather()
        low, high = sim.state.external_forces[0, 2], sim.state.external_forces[-1, 2]
        say("forces", low, high)
        sim.step()
        say("state", sim.digest())
    """)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(said) == 2 and said[0] == said[1] and said[0][0] == "forces 0.0 1.0"


def test_after_a_step_every_rank_has_the_positions_of_all_vertices(tmp_path):
    done, said = program(tmp_path, """
        sim.step()
        say("state", sim.positions.tolist(), sim.velocities.tolist())
    """)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(said) == 2 and said[0] == said[1]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("list(sim.frames(duration=0.04 * (1 + ranks.rank)))", "frames: duration must be the same"),
        ("list(sim.frames(duration=0.08, rate=25.0 * (1 + ranks.rank)))", "frames: rate must be"),
        ("sim.run(out=out, duration=0.04 * (1 + ranks.rank))", "run: duration must be the same"),
        ("sim.run(out=out, duration=0.04, resume=ranks.rank == 1)", "run: resume must be"),
        (
            "sim.run(out=out, duration=0.04, control=print if ranks.rank else None)",
            "run: control must be",
        ),
        ("sim.run(out=out, duration=0.04, render=ranks.rank == 0)", "run: render must be"),
        (
            "ls.Simulation(sim.scene, communicator=ranks, decomposition='predicted' if ranks.rank"
            " else 'static')",
            "Simulation: decomposition must be",
        ),
    ],
)
def test_calls_with_different_arguments_are_refused_on_all_ranks(tmp_path, call, said):
    done, lines = program(tmp_path, f"""
        out = {str(tmp_path / "out")!r}
        try:
            {call}
        except ls.InvalidInput as error:
            say(error)
        sim.step()
        say("state", sim.digest())
    """)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(lines) == 2 and lines[0] == lines[1]
    assert lines[0][0].startswith(said) and "on rank 0 and" in lines[0][0]
    assert not (tmp_path / "out").exists()


def test_a_rank_that_fails_outside_a_collective_step_ends_the_others(tmp_path):
    began = time.perf_counter()
    done, _ = program(tmp_path, """
        from loomstone.ranks import share_failure
        if ranks.rank == 1:
            share_failure(ranks, ls.Error("only here"))
        ranks.barrier()
    """)  # fmt: skip
    assert done.returncode != 0 and "rank 1: only here" in done.stderr
    assert time.perf_counter() - began < 40


def test_an_error_that_nobody_catches_ends_all_ranks(tmp_path):
    done, _ = program(tmp_path, """
        if ranks.rank == 0:
            raise RuntimeError("my own mistake")
        ranks.barrier()
    """)  # fmt: skip
    assert done.returncode != 0 and "RuntimeError: my own mistake" in done.stderr


def test_all_ranks_are_refused_a_run_that_another_process_writes(scene, tmp_path):
    out = tmp_path / "out"
    assert run(scene, out).returncode == 0
    script = textwrap.dedent("""
        import sys
        import loomstone as ls
        ranks = ls.ranks.mpi_communicator()
        scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(8, 8)), pins=[0])])
        sim = ls.Simulation(scene, communicator=ranks, threads=1)
        for options in ({"overwrite": True}, {"resume": True}):
            try:
                sim.run(out=sys.argv[1], duration=0.04, **options)
            except ls.CacheError as error:
                print(error)
    """)
    with DirectoryLock(out) as lock:
        lock.take()
        for arguments in (["run", scene, "--out", out, "--overwrite"], ["resume", out]):
            done = ranks(2, "-m", "loomstone", *arguments)
            assert done.returncode == 1 and "Traceback" not in done.stderr
            assert done.stderr.count("loomstone: ") == 1, done.stderr
            assert f"{out} must be written by one process at a time" in done.stderr
        done = ranks(2, "-c", script, out)
        said = f"{out} must be written by one process at a time, but process {os.getpid()} on"
        assert done.returncode == 0 and done.stdout.count(said) == 4, done.stdout + done.stderr
    assert ranks(2, "-m", "loomstone", "resume", out).returncode == 0


DIFFERENT = """
import os
import loomstone as ls
rank = int(os.environ["OMPI_COMM_WORLD_RANK"])
cells = 6 + (rank if {what!r} == "mesh" else 0)
gravity = (0, 0, -9.81 - (rank if {what!r} == "gravity" else 0))
step = 4e-3 + (1e-3 * rank if {what!r} == "step" else 0)
mesh = ls.grid(size=(0.3, 0.3), cells=(cells, cells))
scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh)], gravity=gravity)
try:
    ls.Simulation(
        scene,
        integrator=ls.SemiImplicitEuler(step=step),
        communicator=ls.ranks.mpi_communicator(),
        threads=1,
    )
except ls.InvalidInput as error:
    print(rank, error, flush=True)
"""


@pytest.mark.parametrize(
    ("what", "field"),
    [("mesh", "scene.cloths"), ("gravity", "scene.gravity"), ("step", "integrator.step")],
)
def test_ranks_with_different_scenes_are_refused(tmp_path, what, field):
    script = tmp_path / "different.py"
    script.write_text(DIFFERENT.format(what=what))
    done = subprocess.run(
        command(3, script), capture_output=True, text=True, timeout=60, env=ENVIRONMENT
    )
    said = f"those of rank 1 differ from those of rank 0 in {field}; do not let them depend"
    assert done.stdout.count(said) == 3, done.stdout + done.stderr
