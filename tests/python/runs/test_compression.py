"""Tests of compressed runs."""

import loomstone as ls
import numpy as np
import pytest


def test_a_compressed_run_has_the_same_frames_and_stays_compressed_when_resumed(
    hanging, euler, tmp_path
):
    run, out = tmp_path / "plain", tmp_path / "compressed"
    ls.Simulation(hanging, integrator=euler).run(out=run, duration=0.12)
    ls.Simulation(hanging, integrator=euler).run(out=out, duration=0.08, compression=1)
    ls.Simulation(hanging, integrator=euler).run(out=out, duration=0.12, resume=True)
    plain, compressed = ls.Run(run), ls.Run(out)
    assert np.array_equal(plain.positions, compressed.positions)
    assert np.array_equal(plain.velocities, compressed.velocities)
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    with h5py.File(out / "run.vtkhdf") as file:
        assert file["VTKHDF/Points"].compression == "gzip" and len(compressed) == 4


@pytest.mark.parametrize("level", [-1, 10, "high", 0.5])
def test_a_level_of_compression_out_of_range_is_refused(hanging, euler, tmp_path, level):
    sim = ls.Simulation(hanging, integrator=euler)
    with pytest.raises(ls.InvalidInput, match="compression must be"):
        sim.run(out=tmp_path, duration=0.04, compression=level)
    assert not list(tmp_path.iterdir())
