"""Cloth intersects neither itself nor other surfaces if its initial coordinates are perturbed by up
to a micrometre.

tests/benchmarks/certify.py tests the same with finer meshes.
"""

from pathlib import Path

import loomstone as ls
import pytest
from certify import perturbed
from loomstone.runs.scene_file import SceneFile
from loomstone.runs.verification import count_intersections

ROOT = Path(__file__).parents[3]
SMALL = {
    "drape": ({"triangles": 242}, 0.6),
    "fold": ({"triangles": 200, "layers": 4}, 0.5),
    "ribbon": ({"triangles": 400}, 0.6),
    "twist": ({"triangles": 288}, 1.2),
    "uneven": ({"triangles": 400}, 0.44),
}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", sorted(SMALL))
def test_no_cloth_intersects_from_a_perturbed_start(name, seed):
    parameters, duration = SMALL[name]
    file = SceneFile.open(ROOT / "scenes" / f"{name}.py", parameters)
    sim = ls.Simulation(perturbed(file.scene(), seed), integrator=file.integrator, threads=1)
    contacts = 0
    for frame in sim.frames(duration=duration, rate=file.rate):
        assert count_intersections(sim.topology, frame).cloth == 0, f"frame at {frame.time:.2f} s"
        contacts = max(contacts, frame.report.contacts.near)
    assert contacts > 0, "the scene shows contact"


@pytest.mark.parametrize("interval", [1e-3, 2.5e-3])
@pytest.mark.parametrize("schedule", ["nested", "queue"])
def test_no_ribbon_intersects_in_asynchronous_steps_from_a_perturbed_start(schedule, interval):
    file = SceneFile.open(ROOT / "scenes" / "ribbon.py", {"triangles": 200})
    steps = ls.Asynchronous(step=interval, schedule=schedule)
    sim = ls.Simulation(perturbed(file.scene(), 1), integrator=steps, threads=1)
    impulses = 0
    for frame in sim.frames(duration=0.8, rate=file.rate):
        assert count_intersections(sim.topology, frame).cloth == 0, f"frame at {frame.time:.2f} s"
        impulses += frame.report.contacts.event_impulses
    assert impulses > 0, "the ribbon collides"
