"""Small, short versions of all scene files. Cloth intersects nothing in any frame, and its stretch
is bounded. In most scenes of magnets without cloth, the energy is tested. For a few scene files,
their check() is called.
"""

from pathlib import Path

import loomstone as ls
import numpy as np
import pytest
from loomstone.runs.scene_file import SceneFile
from loomstone.runs.verification import count_intersections

SCENES = Path(__file__).parents[3] / "scenes"

# Parameters, simulated time [s] and bound on the stretch of cloth [1]. Most times are long enough
# for the main event of a scene, such as the closing of the knot.
SMALL = {
    "bending": ({"triangles": 128}, 0.4, 1.2),
    "bin": ({"triangles": 96, "towels": 4}, 0.6, 1.3),
    "clasp": ({"triangles": 128}, 0.06, 1.2),
    "card": ({"triangles": 288, "boxes": 3}, 0.48, 1.3),
    "disc": ({"triangles": 240}, 0.4, 2.0),
    "drape": ({"triangles": 450}, 0.6, 1.2),
    "dress": ({"triangles": 900}, 1.3, 1.3),
    "flag": ({"triangles": 200}, 0.2, 1.3),
    "fold": ({"triangles": 240, "layers": 4}, 0.4, 1.3),
    "funnel": ({"triangles": 500}, 0.8, 1.2),
    "hanging": ({"triangles": 128}, 0.2, 1.2),
    "incline": ({"triangles": 32}, 0.4, 1.05),
    "knot": ({"triangles": 500}, 2.0, 1.4),
    "obstacle_walk": ({"triangles": 1000}, 0.2, 1.5),
    "ribbon": ({"triangles": 400}, 0.8, 2.5),
    "sphere_slide": ({"triangles": 450}, 0.8, 1.2),
    "stack": ({"triangles": 98, "sheets": 4}, 1.0, 1.3),
    "swing_limits": ({"triangles": 100}, 0.6, 2.0),
    "table_cloth": ({"triangles": 500}, 0.6, 1.3),
    "uneven": ({"triangles": 400}, 0.4, 1.2),
    "voice_coil": ({"triangles": 200}, 0.1, 1.2),
    "wave_bar": ({"triangles": 450}, 0.6, 1.3),
    "twist": ({"triangles": 450}, 1.2, 1.3 * 1.75),
}

# Like SMALL, but for scenes that disable collisions. test_no_cloth_intersects_in_any_frame enables
# collisions in these scenes.
APART = {
    "limit_scaling": ({"triangles": 200}, 0.6, 1.3),
    "swing": ({"columns": 11, "rows": 14}, 1.0, 1.2),
    "swing_integrators": ({"triangles": 120}, 1.0, 1.4),
}

# Scenes of magnets without cloth: parameters and simulated time [s].
MAGNETIC = {
    "dragon": ({"spheres": 4, "cells": 300}, 0.1),
    "field_lines": ({}, 0.02),
    "figures": ({"figures": 2, "balls": 8, "response": "explicit"}, 0.1),
    "halbach": ({"cubes": 5}, 0.01),
    "levitation": ({}, 0.3),
    "motor": ({}, 0.1),
    "lift": ({"spheres": 4}, 1.5),
    "plunger": ({}, 0.1),
    "pull": ({"cells": 8}, 0.05),
    "toy_magnets": ({"case": "parallel"}, 0.2),
}


def test_every_scene_has_a_small_version_here():
    assert {
        path.stem for path in SCENES.glob("*.py")
    } == SMALL.keys() | APART.keys() | MAGNETIC.keys()


@pytest.mark.filterwarnings("error::loomstone.SceneWarning")
@pytest.mark.parametrize("name", sorted(SMALL | APART | MAGNETIC))
def test_no_scene_looks_like_a_mistake(name):
    file = SceneFile.open(SCENES / f"{name}.py", (SMALL | APART | MAGNETIC)[name][0])
    ls.Simulation(file.scene(), integrator=file.integrator, threads=1)


@pytest.mark.parametrize("name", sorted(MAGNETIC))
def test_magnets_gain_no_energy_and_fall_through_nothing(name):
    parameters, duration = MAGNETIC[name]
    file = SceneFile.open(SCENES / f"{name}.py", parameters)
    sim = ls.Simulation(file.scene(), integrator=file.integrator, threads=1)

    def energies():
        r = sim.report
        return np.array((r.energy.body_kinetic, r.energy.body_gravity, r.energy.magnetic))

    start, most = energies(), 0.0
    while sim.time < duration:
        sim.step()
        most = max(most, np.abs(energies() - start).max())
        if name not in ("halbach", "motor"):  # the bodies of halbach and motor cannot fall
            assert sim.body_centres[:, 2].min() > 1e-3, (
                "a ball on the table below the bowl has its centre at 0"
            )
    assert sim.report.magnets.substeps >= 1
    if name == "motor":  # supply = heat + motion + work on the bearing + L I^2 / 2, L = 5e-4 H
        turning = sim.report.energy.body_kinetic + sim.bearing_work + 0.25e-3 * sim.current**2
        assert turning + sim.circuit_heat == pytest.approx(sim.circuit_supply, rel=5e-3)
        assert sim.state.body_angular_velocities[0, 2] > 50
    elif name == "plunger":  # the plunger has risen, and the energy balance holds
        gained = energies().sum() - start.sum()
        assert sim.body_centres[0, 2] > 0.04 and gained > 3e-3
        circuit = sim.report.circuits.energy + sim.circuit_heat - sim.circuit_supply
        assert gained + circuit == pytest.approx(0.0, abs=0.01 * gained)
    elif name not in ("figures", "lift", "pull"):  # in those three, the script does work
        # The energy of kick-drift-kick oscillates, and contacts only dissipate energy.
        assert energies().sum() - start.sum() < 0.01 * most


@pytest.mark.parametrize(
    ("name", "triangles", "duration", "step"),
    [
        ("drape", 450, 0.6, "auto"),
        ("ribbon", 200, 2.5, 2.5e-3),
        ("table_cloth", 1000, 1.0, 4e-3),  # the step of the scene, 1 ms, is for larger meshes
        ("wave_bar", 1000, 1.0, 4e-3),
    ],
)
def test_a_scene_keeps_its_claims(name, triangles, duration, step, tmp_path):
    file = SceneFile.open(SCENES / f"{name}.py", {"triangles": triangles})
    integrator = file.integrator.replace(step=step)
    ls.Simulation(file.scene(), integrator=integrator, threads=1).run(
        out=tmp_path, duration=duration
    )
    file.check(ls.Run(tmp_path))


@pytest.mark.parametrize("case", ["antiparallel", "free", "parallel"])
def test_toy_magnets_keep_their_claims_to_the_end(case, tmp_path):
    file = SceneFile.open(SCENES / "toy_magnets.py", {"case": case})
    ls.Simulation(file.scene(), integrator=file.integrator, threads=1).run(
        out=tmp_path, duration=file.duration, rate=file.rate
    )
    file.check(ls.Run(tmp_path))


def test_the_superconducting_cube_keeps_its_energy_and_turns_as_it_swings():
    file = SceneFile.open(SCENES / "levitation.py", {"shape": "cube"})
    sim = ls.Simulation(file.scene(), integrator=file.integrator, threads=1)

    def energy():
        return (
            sim.report.energy.body_kinetic
            + sim.report.energy.body_gravity
            + sim.report.energy.magnetic
        )

    start, moving = energy(), 0.0
    for _ in range(40):
        sim.step()
        moving = max(moving, sim.report.energy.body_kinetic)
    assert np.linalg.norm(sim.state.body_angular_velocities[0]) > 1.0  # a ball would not turn
    assert abs(energy() - start) < 0.01 * moving  # forces on a cube are accurate to 1e-3


def test_asynchronous_steps_keep_the_energy_of_the_swing_for_four_seconds():
    file = SceneFile.open(SCENES / "swing.py", {"columns": 11, "rows": 14})
    sim = ls.Simulation(file.scene(), integrator=ls.Asynchronous(), threads=1)
    total, kinetic = [], 0.0
    while sim.time < file.duration - 1e-9:
        sim.step()
        e = sim.report.energy
        total.append(e.kinetic + e.membrane + e.bending + e.gravity)
        kinetic = max(kinetic, e.kinetic)
    # Oscillations average out in the mean over the last tenth of the run.
    assert np.mean(total[-len(total) // 10 :]) - total[0] == pytest.approx(0.0, abs=0.02 * kinetic)


def test_a_dress_that_starts_within_its_thickness_gains_no_energy():
    scene = SceneFile.open(SCENES / "obstacle_walk.py", {"triangles": 1200}).scene()
    sim = ls.Simulation(scene, integrator=ls.Asynchronous(step=2.5e-3))
    balances = []
    for _ in range(20):
        sim.step()
        balances.append(sim.report.account.balance)
    # Impulses restore the gaps in the first step. Their energy counts as work, so the balance does
    # not include it.
    assert max(balances) < 0.005


def test_a_queue_with_steps_of_10_ms_lets_the_hat_fall_on_the_floor():
    scene = SceneFile.open(SCENES / "uneven.py", {"triangles": 600}).scene()
    sim = ls.Simulation(scene, integrator=ls.Asynchronous(step=1e-2, schedule="queue"))
    impulses = 0
    while sim.time < 0.4:  # the hat meets the floor before this time
        sim.step()
        impulses += sim.report.contacts.event_impulses
        assert sim.frame().stretch.max() < 1.15
        assert len(sim.intersecting_pairs()) == 0
    assert impulses > 1000


def test_the_feet_of_the_walking_figure_do_not_slide_and_touch_no_obstacle():
    figure, *course = (
        SceneFile.open(SCENES / "obstacle_walk.py", {"triangles": 1000}).scene().obstacles
    )
    places = figure.vertex_positions.reshape(len(figure.times), -1, 3)
    assert figure.mesh.closed and figure.mesh.n_triangles >= 3000
    for side in (-1, 1):
        sole = places[:, (side * places[0, :, 1] > 0) & (places[0, :, 2] < 0.012)]
        heights = sole[..., 2].min(axis=1)
        # The ground is at a height of 0 or at that of one of three stairs. A standing sole is less
        # than 6 mm above the ground.
        stands = (heights[:, None] - 0.17 * np.arange(4) < 0.006).argmax(axis=1)
        stands = np.abs(heights - 0.17 * stands) < 0.006
        lowest = sole[..., 2] < heights[:, None] + 0.001
        slides = np.where(lowest[:-1], np.linalg.norm(np.diff(sole[..., :2], axis=0), axis=2), 0.0)
        both = stands[1:] & stands[:-1]
        assert both.mean() > 0.4, "a foot stands for more than 40 % of the time"
        assert slides.max(axis=1)[both].sum() < 0.01  # [m], over all steps
    for moment in places[::25]:
        meshes = [(moment, figure.mesh.triangles)]
        meshes += [(o.mesh.vertices, o.mesh.triangles) for o in course]
        first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
        triangles = np.concatenate([t + n for (_, t), n in zip(meshes, first, strict=False)])
        points = np.concatenate([vertices for vertices, _ in meshes])
        for pair in ls.collision.intersecting_pairs(points, triangles):
            assert max(pair) < figure.mesh.n_triangles, "only creases of the figure intersect"


@pytest.mark.parametrize("name", sorted(SMALL | APART))
def test_no_cloth_intersects_in_any_frame(name):
    parameters, duration, most_stretch = (SMALL | APART)[name]
    file = SceneFile.open(SCENES / f"{name}.py", parameters)
    sim = ls.Simulation(
        file.scene().replace(collisions=True), integrator=file.integrator, threads=1
    )
    in_contact = 0
    for frame in sim.frames(duration=duration, rate=file.rate):
        assert count_intersections(sim.topology, frame).cloth == 0, f"frame at {frame.time:.2f} s"
        assert frame.stretch.max() < most_stretch
        in_contact = max(in_contact, frame.report.contacts.near)
    assert in_contact > 0 or name in ("flag", "hanging", "swing_limits") or name in APART, (
        "the scene shows contact"
    )


@pytest.mark.parametrize(("speed", "step"), [(8.0, 8e-3), (16.0, 4e-3)])
def test_a_step_whose_motion_would_be_withheld_is_taken_in_halves(speed, step):
    """A wall hits the edges of eight separate sheets.

    If the first step were not halved, certification would withhold much of the sheets' motion.
    """
    flat, random = ls.grid(size=(0.2, 0.2), cells=(8, 8)), np.random.default_rng(3)
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=60.0,
        density=0.12,
        bending_weft=2e-6,
        bending_warp=2e-6,
    )
    places = [(*random.uniform(-0.004, 0.004, 2), 0.006 * i) for i in range(8)]
    wall = ls.obstacles.box(
        name="wall",
        size=(0.02, 0.6, 0.6),
        times=[0.0, 1.0],
        positions=[(0.13, 0.0, 0.0), (0.13 - speed, 0.0, 0.0)],
    )
    scene = ls.Scene(
        cloths=[ls.Cloth(mesh=flat.moved(place), material=material) for place in places],
        obstacles=[wall],
        gravity=(0.0, 0.0, 0.0),
    )
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    sim.step()
    assert sim.report.parts > 1
    assert sim.report.withheld.share < 0.1
    assert not sim.intersecting_pairs()


def test_a_count_distinguishes_cloth_and_bodies_and_finds_all_intersections():
    mesh = ls.grid(size=(0.2, 0.2), cells=(4, 4))
    through = [
        ls.obstacles.box(name=n, size=(0.05, 0.05, 0.05), centre=(0.0, 0.0, z))
        for n, z in (("a", 0.0), ("b", 0.04))
    ]
    scene = ls.Scene(
        cloths=[ls.Cloth(mesh=mesh)], obstacles=through, allow_initial_intersections=True
    )
    sim = ls.Simulation(scene)
    counts = count_intersections(sim.topology, sim.frame())
    assert counts.cloth > 0 and counts.bodies > 0
    assert sum(counts) == len(sim.intersecting_pairs())
