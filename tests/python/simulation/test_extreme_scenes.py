"""Claims about pins that jump, bodies much heavier than cloth, and heaps of cloth."""

from typing import Literal

import loomstone as ls
import numpy as np
import pytest

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
SOFT = ls.ClothMaterial(
    weft_stiffness=300.0,
    warp_stiffness=300.0,
    shear_stiffness=60.0,
    density=0.15,
    bending_weft=2e-6,
    bending_warp=2e-6,
)


def top(mesh: ls.TriangleMesh) -> np.ndarray:
    heights = mesh.vertices[:, 2]
    return np.flatnonzero(heights > heights.max() - 1e-6)


def curtains(cells: int, hung: bool) -> ls.Scene:
    """Two curtains. At 0.1 s the pins of the first jump by 0.3 m, through the second."""
    flat = ls.grid(size=(0.4, 0.4), cells=(cells, cells))
    first = flat.moved((0, 0, 0), rotation=UPRIGHT)
    second = flat.moved((0.03, 0.05, 0.01), rotation=UPRIGHT)
    pins = top(first)
    places = first.vertices[pins]
    script = np.concatenate([places, places, places + (0, 0.3, 0)])
    return ls.Scene(
        cloths=[
            ls.Cloth(
                name="driven",
                mesh=first,
                material=SOFT,
                pins=list(pins),
                script_times=[0.0, 0.1, 0.1001],
                script_positions=script,
            ),
            ls.Cloth(
                name="struck", mesh=second, material=SOFT, pins=list(top(second)) if hung else []
            ),
        ],
        gravity=(0, 0, -9.81) if hung else (0, 0, 0),
    )


@pytest.mark.parametrize("cells", [12, 18])
@pytest.mark.parametrize("hung", [False, True])
def test_a_curtain_gives_way_to_pins_that_jump_through_it(cells: int, hung: bool) -> None:
    # The pins move at many times the speed of sound in cloth (45 m/s). This stretches the hung
    # curtain up to 25 times for a moment. It must slide over the pins and not hook into them.
    sim = ls.Simulation(curtains(cells, hung), threads=1)
    recovered = 0.0
    while sim.time < 0.4:
        sim.step()
        report = sim.report
        if report.strain.stretch > 1.5:
            recovered = sim.time
        assert report.contacts.intersections == 0
        assert report.contacts.unresolved == 0
        assert report.withheld.motion <= 0.2 * report.withheld.requested
    assert recovered < 0.2
    assert sim.report.strain.stretch < 1.15  # it still swings


def caught(mass: float) -> ls.Scene:
    """A ball that falls by 5 cm into a cloth of 40 g with limits of 2 %."""
    mesh = ls.grid(size=(0.5, 0.5), cells=(15, 15))
    edges = np.flatnonzero(np.abs(mesh.vertices[:, 0]) > 0.25 - 1e-6)
    material = ls.ClothMaterial(
        weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=80.0, density=0.16
    )
    radius = 0.06
    density = mass / (4.0 / 3.0 * np.pi * radius**3)
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=mesh,
                material=material,
                pins=list(edges),
                strain_limit=ls.StrainLimit(0.02, 0.02, 0.04),
            )
        ],
        bodies=[
            ls.RigidBody(
                name="ball",
                mesh=ls.sphere(radius=radius).mesh,
                shape="sphere",
                density=density,
                position=(0.003, 0.002, radius + 0.05),
            )
        ],
    )


@pytest.mark.parametrize(("mass", "excess"), [(1.0, 0.008), (12.0, 0.016), (40.0, 0.03)])
def test_limited_cloth_catches_a_ball_a_thousand_times_as_heavy(mass: float, excess: float) -> None:
    # The cloth stops the ball within milliseconds, by forces of some hundred times its weight.
    # Without the fourth phase of limits, the excess is twice as large.
    sim = ls.Simulation(caught(mass), threads=1)
    worst = 0.0
    while sim.time < 0.4:
        sim.step()
        worst = max(worst, sim.report.limits.excess)
        assert sim.report.contacts.intersections == 0
    assert worst < excess
    assert len(sim.broken_limits) == 0


def heap(towels: int) -> ls.Scene:
    """Towels that fall onto one another."""
    random = np.random.default_rng(0)
    flat = ls.grid(size=(0.18, 0.12), cells=(11, 7))
    material = ls.ClothMaterial(
        weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=150.0, density=0.3
    )
    cloths = []
    for i in range(towels):
        x, y = random.uniform(-0.03, 0.03, 2)
        roll, pitch = random.uniform(-0.2, 0.2, 2)
        turn = random.uniform(0.0, 3.0)
        about_x = np.array(
            [[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]]
        )
        about_y = np.array(
            [[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]
        )
        about_z = np.array(
            [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
        )
        mesh = flat.moved((x, y, 0.08 + 0.08 * i), rotation=about_z @ about_y @ about_x)
        cloths.append(ls.Cloth(name=f"towel {i}", mesh=mesh, material=material))
    return ls.Scene(cloths=cloths, obstacles=[ls.floor(height=0.0)])


@pytest.mark.parametrize("step", ["auto", 10e-3])
def test_a_heap_of_towels_comes_to_rest(step: Literal["auto"] | float) -> None:
    sim = ls.Simulation(heap(8), integrator=ls.SemiImplicitEuler(step=step), threads=1)
    peak, last = 0.0, 0.0
    while sim.time < 3.0:
        sim.step()
        kinetic = sim.report.energy.kinetic
        peak = max(peak, kinetic)
        if sim.time > 2.5:
            last = max(last, kinetic)
    assert last < 1e-6 * peak
