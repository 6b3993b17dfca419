"""Tests of what notebooks show."""

import loomstone as ls
from loomstone import garments

SIGNATURE = b"\x89PNG\r\n"


def test_scenes_frames_runs_and_garments_have_pictures(hanging, tmp_path):
    sim = ls.Simulation(hanging, threads=1)
    sim.run(out=tmp_path / "run", duration=0.04, rate=25)
    run = ls.Run(tmp_path / "run")
    shirt = garments.tshirt(600)
    pictures = {
        "scene": hanging._repr_png_(),
        "frame": sim.frame()._repr_png_(),
        "stored frame": run[0]._repr_png_(),
        "run": run._repr_png_(),
        "garment": shirt._repr_png_(),
    }
    for name, picture in pictures.items():
        assert picture.startswith(SIGNATURE), name
    assert pictures["stored frame"] == pictures["scene"]
    assert pictures["stored frame"] != pictures["run"]


def test_a_scene_that_cannot_be_simulated_has_no_picture():
    assert ls.Scene()._repr_png_() is None


def test_texts_are_short(hanging):
    shirt = garments.tshirt(600)
    sim = ls.Simulation(hanging, threads=1)
    sim.step()
    ball = ls.magnetics.sphere(radius=0.01, polarization=(0, 0, 1))
    for thing in (shirt, shirt.cut, hanging, hanging.cloths[0], sim, sim.frame(), sim.state,
                  sim.topology, sim.checkpoint(), sim.report, shirt.mesh, ball,
                  ls.magnetics.field_lines(ball, 20), ls.fabrics):  # fmt: skip
        text = repr(thing)
        assert text.count("\n") < 10 and len(text) < 2000, type(thing)
