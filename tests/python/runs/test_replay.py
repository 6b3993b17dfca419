"""Recorded motions of a run, and the predicted times of collision searches on many ranks."""

import csv
import itertools
import subprocess
import sys

import loomstone as ls
import numpy as np
import pytest
from loomstone._core import CollisionReplay
from loomstone.runs.motions import motion_files, read_motion
from loomstone.runs.replay import REPLAYED, Network, parse_ranks, replay


def loomstone(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "loomstone", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded") / "run"
    sheet = ls.grid(size=(0.3, 0.3), cells=(30, 30))
    cloths = [ls.Cloth(mesh=sheet), ls.Cloth(mesh=sheet.moved((0.01, 0.01, 0.01)))]
    scene = ls.Scene(cloths=cloths, obstacles=[ls.sphere(radius=0.06, centre=(0, 0, -0.065))])
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3))
    sim.run(out=out, duration=0.1, rate=50, record_tasks=10)
    return out


def test_a_run_records_the_motion_of_every_tenth_step(recorded):
    assert [path.name for path in motion_files(recorded)] == [
        "step-0000000010.npz",
        "step-0000000020.npz",
    ]
    assert not list(recorded.rglob("unfinished-*"))
    motion = read_motion(motion_files(recorded)[1])
    assert len(motion.surfaces) == 3 and list(motion.surfaces[:, 0]) == [0, 0, 2]
    assert len(motion.triangles) > 2 * 1800
    assert np.abs(motion.x1 - motion.x0).max() < 0.1
    assert motion.x1[:900, 2].max() < motion.x0[:900, 2].max()  # the cloth falls
    starts = [*motion.earlier, motion.x0]
    moved = [np.abs(end - start).max() for start, end in itertools.pairwise(starts)]
    assert len(moved) == 16 and min(moved) > 0 and max(moved) < 0.1
    assert 9 <= len(read_motion(motion_files(recorded)[0]).earlier) < 16  # parts are motions, too


def test_a_kept_motion_counts_as_memory_and_is_released():
    cloth = ls.Cloth(mesh=ls.grid(cells=(4, 4)))
    sim = ls.Simulation(ls.Scene(cloths=[cloth]), integrator=ls.SemiImplicitEuler(step=4e-3))

    def kept() -> int:
        return sim.memory_bytes["recorded_motion"]

    assert kept() == 0
    sim.keep_collision_motion(True)
    for _ in range(30):
        sim.step()
    assert len(sim.collision_motion().earlier) == 16
    of_positions = 25 * 3 * 8
    assert 18 * of_positions <= kept() < 20 * of_positions
    sim.keep_collision_motion(False)
    assert kept() == 0 and len(sim.collision_motion().x0) == 0


@pytest.mark.parametrize(("more", "steps"), [((), [5, 10]), (("--record-tasks", 4), [4, 8])])
def test_a_resumed_run_goes_on_recording(tmp_path, more, steps):
    (tmp_path / "scene.py").write_text(
        "import loomstone as ls\n"
        "integrator = ls.SemiImplicitEuler(step=4e-3)\n"
        "def scene():\n"
        "    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)), pins=[0])])\n"
    )
    out = tmp_path / "out"
    first = ("run", tmp_path / "scene.py", "--out", out, "--record-tasks", 5, "--duration", 0.04)
    assert loomstone(*first).returncode == 0
    for path in [*motion_files(out), *out.glob("checkpoint-*")]:
        path.unlink()  # the run starts again from its first step
    done = loomstone("resume", out, *more)
    assert done.returncode == 0, done.stderr
    assert [int(path.stem.split("-")[1]) for path in motion_files(out)] == steps


def test_predicted_searches_cut_lists_by_the_costs_of_a_step_before(recorded):
    motion = CollisionReplay(read_motion(motion_files(recorded)[1]))
    contacts, impacts = motion.lists(repetitions=1)
    assert len(contacts) == len(impacts) > 0 and contacts.work > 0 and impacts.work > 0
    alone, eight = (contacts.replay(n, latency=1e-6, bandwidth=1e15, overhead=0) for n in (1, 8))
    assert alone.exchange == 0 and alone.seconds == pytest.approx(contacts.work)
    assert eight.mean_busy == pytest.approx(contacts.work / 8)
    assert contacts.work / 8 < eight.most_busy < contacts.work
    # One exchange among eight ranks takes three rounds of 1 us each. The transfer of the results
    # takes less than 1 ns.
    assert eight.exchange == pytest.approx(3e-6, abs=1e-9)
    with pytest.raises(ls.InvalidInput, match="ranks must be at least 1"):
        contacts.replay(0)
    with pytest.raises(ls.InvalidInput, match="repetitions must be at least 1"):
        motion.lists(repetitions=0)
    with pytest.raises(ls.InvalidInput, match="repetitions must be at least 1"):
        motion.perform(impacts=True, repetitions=0)


def test_more_ranks_take_less_time_and_exchange_results(recorded):
    found = {
        (each.ranks, each.decomposition): each
        for each in replay(recorded, [1, 4, 16], REPLAYED, Network(latency=1e-6))
    }
    for name in REPLAYED:
        assert found[1, name].exchange == 0 < found[4, name].exchange < found[4, name].seconds
        assert found[4, name].seconds < found[1, name].seconds
    assert found[16, "dynamic"].transfers > 0
    assert found[16, "static"].transfers == 0


def test_the_command_prints_and_writes_the_predictions(recorded):
    done = loomstone("replay", recorded, "--ranks", "1:4", "--latency", "1e-6")
    assert done.returncode == 0, done.stderr
    assert "2 recorded steps" in done.stdout
    with (recorded / "replay.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["ranks"], row["decomposition"]) for row in rows] == [
        (n, name) for n in "124" for name in REPLAYED
    ]
    assert all(float(row["seconds"]) > 0 for row in rows)


@pytest.mark.parametrize(
    ("text", "numbers"),
    [("1:4096", [2**k for k in range(13)]), ("12", [12]), ("1,12,64:200", [1, 12, 64, 128])],
)
def test_numbers_of_ranks_are_lists_and_doubling_ranges(text, numbers):
    assert parse_ranks(text) == numbers


@pytest.mark.parametrize("text", ["", "0", "4:2", "1:2:3", "a", "-1:4", "70000", "1:1000000"])
def test_other_numbers_of_ranks_are_refused(text):
    with pytest.raises(ls.InvalidInput, match="ranks must be"):
        parse_ranks(text)


def test_bad_input_of_the_command_gets_one_sentence(recorded, tmp_path):
    for arguments, sentence in [
        (["--decomposition", "guessed"], "--decomposition must be predicted, static or dynamic"),
        (["--ranks", "0"], "ranks must be whole numbers >= 1"),
        (["--bandwidth", "0"], "--bandwidth must be above 0"),
    ]:
        done = loomstone("replay", recorded, *arguments)
        assert done.returncode == 2 and sentence in done.stderr
    done = loomstone("replay", tmp_path)
    assert done.returncode == 1 and "--record-tasks" in done.stderr


def test_a_motion_without_earlier_positions_is_read(recorded, tmp_path):
    path = motion_files(recorded)[0]
    with np.load(path) as arrays:
        kept = {name: arrays[name] for name in arrays if name != "earlier"}
    (tmp_path / "tasks").mkdir()
    np.savez(tmp_path / "tasks" / path.name, **kept)
    motion = read_motion(tmp_path / "tasks" / path.name)
    assert list(motion.earlier) == []
    assert np.array_equal(motion.x0, read_motion(path).x0)
    assert replay(tmp_path, [1], ["predicted"])


@pytest.mark.parametrize("content", [b"nothing", b"", b"PK\x03\x04", b"\x93NUMPY"])
def test_a_file_that_is_no_motion_is_refused(tmp_path, content):
    folder = tmp_path / "tasks"
    folder.mkdir()
    (folder / "step-0000000010.npz").write_bytes(content)
    with pytest.raises(ls.CacheError, match="is not a recorded motion"):
        replay(tmp_path, [1], ["static"])
    done = loomstone("replay", tmp_path)
    assert done.returncode == 1 and "step-0000000010.npz: is not a recorded" in done.stderr


def test_inconsistent_motions_are_refused():
    def record(**changed):
        values = {
            "surfaces": [[0, 0, 3, 0, 1, 1]],
            "thickness": [1e-3],
            "triangles": [[0, 1, 2]],
            "gap_floor": 1e-5,
            "x0": np.eye(3),
            "x1": np.eye(3),
        }
        return ls._core.CollisionRecord(**values | changed)

    CollisionReplay(record())
    with pytest.raises(ls.InvalidInput, match="must contain all 3 vertices and 1 triangles.*got 4"):
        CollisionReplay(record(surfaces=[[0, 0, 4, 0, 1, 1]]))
    with pytest.raises(ls.InvalidInput, match="surface 0 must begin with vertex 0 and triangle 0"):
        CollisionReplay(record(surfaces=[[0, 1, 2, 0, 1, 1]]))
    with pytest.raises(ls.InvalidInput, match="kind of a surface"):
        record(surfaces=[[3, 0, 3, 0, 1, 1]])
    with pytest.raises(ls.InvalidInput, match="thickness must have one entry"):
        record(thickness=[])
    with pytest.raises(ls.InvalidInput, match="as many rows"):
        CollisionReplay(record(x1=np.zeros((2, 3))))
    with pytest.raises(ls.InvalidInput, match="as many rows"):
        CollisionReplay(record(earlier=[np.zeros((2, 3))]))
    with pytest.raises(ls.InvalidInput, match="positions must be finite"):
        CollisionReplay(record(earlier=[np.full((3, 3), np.nan)]))
    with pytest.raises(ls.InvalidInput, match="ranks must be at least 1"):
        CollisionReplay(record()).contacts(0)


def test_a_simulation_refuses_an_unknown_decomposition():
    scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)))])
    with pytest.raises(ls.InvalidInput, match="decomposition must be"):
        ls.Simulation(scene, decomposition="dynmic")
    with pytest.raises(ls.InvalidInput, match="decomposition must be str"):
        ls.Simulation(scene, decomposition=3)
    sim = ls.Simulation(scene, decomposition="dynamic")
    for record_tasks in (-1, 2.5):
        with pytest.raises(ls.InvalidInput, match="record_tasks must be"):
            sim.run(out="unused", duration=0.1, record_tasks=record_tasks)
