"""Runs on several ranks: the same bits as on one rank, output of rank 0 only, reports of waiting,
resumption on another number of ranks, errors, and communicators of mpi4py.
"""

import json
import platform
import textwrap
from pathlib import Path

import pytest
from launcher import needs_mpirun, ranks
from loomstone.runs.steps import read_steps

pytestmark = needs_mpirun

SCENE = """
import loomstone as ls
duration = 0.12
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene(cells: int = 16):
    mesh = ls.grid(size=(0.3, 0.3), cells=(cells, cells)).moved((0, 0, 0.102))
    obstacles = [ls.sphere(radius=0.1, subdivisions=2), ls.floor(height=-0.2)]
    return ls.Scene(cloths=[ls.Cloth(mesh=mesh)], obstacles=obstacles)
"""


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE)
    return tmp_path / "scene.py"


def digest(out):
    return json.loads((out / "report.json").read_text())["digest"]


def test_ranks_and_threads_change_no_bit_and_only_rank_0_speaks(scene, tmp_path):
    digests = set()
    for n, threads in [(1, 1), (2, 1), (2, 2), (3, 1)]:
        out = tmp_path / f"{n}x{threads}"
        done = ranks(n, "-m", "loomstone", "run", scene, "--out", out, "--threads", threads)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stdout.count("frame 4/4") == 1 and f"{n} ranks" in done.stdout
        digests.add(digest(out))
    assert len(digests) == 1


def test_a_run_tells_where_its_ranks_are_and_how_long_they_wait(scene, tmp_path):
    for n in (1, 2):
        out = tmp_path / str(n)
        done = ranks(n, "-m", "loomstone", "run", scene, "--out", out, "--threads", 1)
        assert done.returncode == 0, done.stdout + done.stderr
        for rank in range(2):
            told = f"rank {rank}: host {platform.node()}, 1 threads, " in done.stdout
            assert told == (n == 2)
        steps = read_steps(out)
        rows = 17 * 17
        for i in range(1, len(steps["step"])):
            stages = sum(steps[name][i] for name in steps if name.startswith("seconds."))
            # The stages are parts of the step of rank 0, which takes at most `wall`. The margin
            # allows for rounding.
            wall = steps["ranks.most_computing"][i] + steps["ranks.most_waiting"][i]
            assert wall > stages * (1 - 1e-9)
            assert steps["ranks.most_computing"][i] >= steps["ranks.computing"][i] > 0
            assert (steps["ranks.waiting"][i] > 0) == (n == 2)
            parts = [steps[f"ranks.collision_{name}"][i] for name in ("computing", "waiting")]
            assert parts[0] <= steps["ranks.computing"][i] and parts[1] <= steps["ranks.waiting"][i]
            assert (steps["ranks.operations"][i] > 10) == (n == 2)
            # Each of two ranks sends on average at least the positions of half of the rows.
            assert (steps["ranks.bytes"][i] >= 3 * 8 * rows // 2) == (n == 2)


PRESS = """
import loomstone as ls
duration = 0.08
integrator = ls.SemiImplicitEuler(step=0.02)
def plate(name, side):
    return ls.Obstacle(name=name, mesh=ls.floor(size=0.3).mesh, thickness=2e-3, times=[0.0, 0.02],
                       positions=[(0, 0, 0.05 * side), (0, 0, 5e-5 * side)],
                       axis_angles=[(0, 0, 0), (0, 0, 0.4 * side)])
def scene():
    mesh = ls.grid(size=(0.1, 0.1), cells=(16, 16)).moved((0, 0, 0.02))
    cloth = ls.Cloth(mesh=mesh, thickness=2e-3)
    return ls.Scene(cloths=[cloth], obstacles=[plate("upper", 1), plate("lower", -1)])
"""


def test_a_step_taken_in_parts_has_the_same_bits_on_all_ranks(tmp_path):
    (tmp_path / "press.py").write_text(PRESS)
    digests = set()
    for n in (1, 3):
        done = ranks(
            n,
            "-m",
            "loomstone",
            "run",
            tmp_path / "press.py",
            "--out",
            tmp_path / str(n),
            "--threads",
            1,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        assert json.loads((tmp_path / str(n) / "report.json").read_text())["steps_in_parts"] > 0
        digests.add(digest(tmp_path / str(n)))
    assert len(digests) == 1


def test_a_run_of_two_ranks_resumes_on_one_and_vice_versa(scene, tmp_path):
    for first, second in [(2, 1), (1, 2)]:
        out = tmp_path / f"{first}then{second}"
        assert ranks(first, "-m", "loomstone", "run", scene, "--out", out).returncode == 0
        whole = digest(out)
        sorted(Path(out).glob("checkpoint-*"))[-1].unlink()
        done = ranks(second, "-m", "loomstone", "resume", out)
        assert done.returncode == 0, done.stdout + done.stderr
        assert digest(out) == whole


def test_a_refused_scene_ends_all_ranks_with_one_sentence(scene):
    done = ranks(2, "-m", "loomstone", "run", scene, "-p", "cells=-3")
    assert done.returncode != 0 and done.stderr.count("loomstone:") == 1


def test_a_communicator_of_mpi4py_is_accepted(tmp_path):
    pytest.importorskip("mpi4py")
    (tmp_path / "program.py").write_text(
        textwrap.dedent("""
        from mpi4py import MPI
        import loomstone as ls
        scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(12, 12)), pins=[0])])
        sim = ls.Simulation(scene, communicator=MPI.COMM_WORLD, threads=1)
        for _ in range(5):
            sim.step()
        digests = MPI.COMM_WORLD.gather(sim.digest())
        if sim.rank == 0:
            assert sim.ranks == 2 and len(set(digests)) == 1
            print("agreed")
        """)
    )
    done = ranks(2, "-m", "mpi4py", tmp_path / "program.py")
    assert done.returncode == 0 and done.stdout.count("agreed") == 1, done.stdout + done.stderr


def test_a_part_of_a_communicator_of_mpi4py_is_accepted(tmp_path):
    pytest.importorskip("mpi4py")
    (tmp_path / "program.py").write_text(
        textwrap.dedent("""
        from mpi4py import MPI
        import loomstone as ls
        world = MPI.COMM_WORLD
        part = world.Split(color=world.rank // 2, key=-world.rank)  # two ranks, and one
        scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(12, 12)), pins=[0])])
        sim = ls.Simulation(scene, communicator=part, threads=1)
        for _ in range(5 + world.rank // 2):  # the parts do not wait for each other
            sim.step()
        told = world.gather((sim.ranks, sim.rank, sim.step_index))
        if world.rank == 0:
            assert told == [(2, 1, 5), (2, 0, 5), (1, 0, 6)], told
            print("agreed")
        """)
    )
    done = ranks(3, "-m", "mpi4py", tmp_path / "program.py")
    assert done.returncode == 0 and done.stdout.count("agreed") == 1, done.stdout + done.stderr
