"""Small versions of the benchmark of faults (tests/benchmarks/faults.py)."""

import loomstone as ls
import pytest

pytest.importorskip("hypothesis", reason="hypothesis is not installed")
from fault_scenes import try_scene
from fault_trials import READERS, Whole, full_disk, in_child, killed, originals, together


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return Whole(tmp_path_factory.mktemp("whole"))


def test_a_run_killed_at_10_random_moments_ends_in_the_same_bits(whole, tmp_path):
    killed(whole, tmp_path / "out", 1, kills=10)


@pytest.mark.parametrize("seed", range(5))
def test_a_run_on_a_full_disk_is_one_sentence_and_ends_in_the_same_bits(whole, tmp_path, seed):
    full_disk(whole, tmp_path / "out", seed)


@pytest.mark.parametrize("reader", READERS)
def test_a_damaged_file_is_refused_in_one_line_or_read(whole, tmp_path, reader):
    for name, content in originals(whole).items():
        (tmp_path / name).write_bytes(content)
    found = dict(in_child([str(tmp_path), reader], list(range(30)), 60.0))
    assert len(found) == 30 and set(found.values()) <= {"read", "refused"}, found


@pytest.mark.parametrize("text", [b"v 0 0 \xff\x80\nf 1 1 1\n", b"v \x1b[2J 0 0\n"])
def test_a_message_quotes_bytes_that_are_no_text(tmp_path, text):
    (tmp_path / "a.obj").write_bytes(text)
    with pytest.raises(ls.CacheError, match="line 1"):
        ls.meshes.read(tmp_path / "a.obj")


@pytest.mark.parametrize("number", range(2))
def test_a_mutated_scene_is_refused_in_one_line_or_simulated(number):
    try_scene(number, count=50)


def test_two_simulations_in_two_threads_have_the_bits_of_two_in_turn():
    def make(which):
        height = 0.05 + 0.01 * which
        mesh = ls.grid(size=(0.2, 0.2), cells=(10, 10)).moved((0, 0, height))
        ball = ls.RigidBody(
            name="ball",
            mesh=ls.sphere(radius=0.02, subdivisions=1).mesh,
            position=(0, 0, height + 0.03),
        )
        scene = ls.Scene(
            cloths=[ls.Cloth(mesh=mesh)], bodies=[ball], obstacles=[ls.sphere(radius=0.04)]
        )
        return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3), threads=2)

    alone, found = together(make, 40)
    assert alone == found
