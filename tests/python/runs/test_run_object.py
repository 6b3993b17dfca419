"""Run: stacked arrays of frames, steps as a table, and closing of files."""

import os
import pickle

import loomstone as ls
import numpy as np
import pytest


@pytest.fixture
def run(falling, euler, tmp_path):
    """A finished run of 0.12 s."""
    ls.Simulation(falling, integrator=euler, threads=1).run(out=tmp_path / "run", duration=0.12)
    return ls.Run(tmp_path / "run")


@pytest.mark.parametrize("name", ["positions", "velocities", "strain", "stretch", "body_vertices"])
def test_a_stacked_array_is_that_of_every_frame(run, name):
    stacked, frames = getattr(run, name), [getattr(frame, name) for frame in run]
    assert stacked.shape == (4, *frames[0].shape) and stacked.ndim == frames[0].ndim + 1
    assert np.array_equal(np.asarray(stacked), frames)
    assert np.array_equal(stacked[1:3], frames[1:3]) and np.array_equal(stacked[-1], frames[-1])
    assert np.array_equal(stacked[:, 2], np.array(frames)[:, 2])
    assert np.array_equal(stacked[::2, 1:4], np.array(frames)[::2, 1:4])
    assert np.array_equal(stacked[[0, 3]], [frames[0], frames[3]])
    assert np.array_equal(stacked[..., 0], np.array(frames)[..., 0])
    first = (0,) * frames[1].ndim
    assert stacked[(..., 1, *first)] == frames[1][first]
    assert np.array_equal(stacked[run.times > 0.05], np.array(frames)[run.times > 0.05])
    assert len(list(stacked)) == len(stacked) == 4 and stacked[4:].shape == (0, *frames[0].shape)
    with pytest.raises(IndexError):
        stacked[4]
    assert np.array_equal(2.0 * stacked - stacked, frames) and np.max(stacked) == np.max(frames)


@pytest.mark.parametrize(
    "index",
    [
        (),
        None,
        (None, 1),
        ([0, 3], [2, 5]),
        ([0, 3], slice(None), [1, 2]),
        (2, slice(None), [0, 2]),
        (1, [4, 5], [0, 2]),
        (np.array([[0, 1], [3, 2]]), 7),
        (slice(1, 3), [2, 5], 1),
        ((0, 1), 2),
        ([True, False, False, True], [2, 5]),
        np.int64(-1),
        np.array(2),
        [],
        (0, 1, 2),
        True,
        (..., [0, 2]),
    ],
    ids=repr,
)
def test_a_stacked_array_is_indexed_like_a_numpy_array(run, index):
    wanted = np.asarray(run.positions)[index]
    got = run.positions[index]
    assert np.shape(got) == np.shape(wanted) and np.array_equal(got, wanted)


@pytest.mark.parametrize(
    "index", [(0, 0, 0, 0), 4, [0, 4], ([0, 1], [0, 1, 2]), 1.5, "a", (slice(None), 500)], ids=repr
)
def test_an_index_that_numpy_refuses_is_refused_by_a_stacked_array(run, index):
    with pytest.raises(IndexError):
        np.asarray(run.positions)[index]
    with pytest.raises(IndexError):
        run.positions[index]


def test_a_stacked_array_reads_only_the_frames_that_are_asked_for(run, monkeypatch):
    read = []
    original = ls.Run.__getitem__

    def noted(self, index):
        read.append(index)
        return original(self, index)

    monkeypatch.setattr(ls.Run, "__getitem__", noted)
    run.positions[1:3]
    assert read == [1, 2]


def test_a_run_is_read_after_a_change_of_the_working_directory(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    opened = ls.Run("run")
    assert str(opened.directory) == "run"
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    again = pickle.loads(pickle.dumps(opened))
    for each in (opened, again):
        assert len(each.steps["time"]) == 30 and each[3].positions.shape == (121, 3)
        assert each.directory == run.directory


def test_steps_are_columns_of_numbers(run):
    steps = run.steps
    assert steps["time"] == pytest.approx(0.004 * np.arange(1, 31))
    assert steps["step"].dtype == np.int64 and steps["energy.kinetic"].dtype == np.float64
    assert all(len(column) == 30 for column in steps.values())


def test_a_run_closes_its_files_at_the_end_of_a_with(run):
    with ls.Run(run.directory) as opened:
        frame = opened[0]
    assert frame.positions.shape == (121, 3)
    with pytest.raises(ls.CacheError, match="the run is closed; open it again"):
        opened[0]
    opened.close()


def test_a_closed_run_keeps_no_file_open_for_what_was_read(run):
    def kept():
        with ls.Run(run.directory) as opened:
            frame, topology = opened[0], opened.topology
            return frame, frame.positions, opened.times, topology, topology.triangles

    before = os.listdir("/proc/self/fd")
    frame, positions, times, topology, triangles = kept()
    assert os.listdir("/proc/self/fd") == before
    assert np.array_equal(frame.positions, positions) and np.array_equal(times, run.times)
    assert np.array_equal(topology.triangles, run.topology.triangles) and len(triangles) == 200


def test_times_and_topology_of_a_run_are_read_only(run):
    for array in (run.times, run.topology.triangles):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_a_closed_run_has_a_text_and_no_picture(hanging, tmp_path):
    ls.Simulation(hanging, threads=1).run(out=tmp_path / "run", duration=0.04)
    with ls.Run(tmp_path / "run") as run:
        pass
    assert repr(run) == f"Run({str(tmp_path / 'run')!r}: closed)"
    assert run._repr_png_() is None
