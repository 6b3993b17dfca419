"""Coulomb's law for whole sheets: on an incline, around a cylinder, on an accelerating floor, and
where a sheet lands.
"""

import loomstone as ls
import numpy as np
import pytest

MU, GAP = 0.3, 1e-3


def incline(slope, step, cells=4):
    """Returns a simulation of a sheet on a plane.

    Gravity is tilted so that the plane slopes down along x.
    """
    angle = np.arctan(slope)
    mesh = ls.grid(size=(0.12, 0.12), cells=(cells, cells)).moved((0.0031, 0.0017, 0.9995 * GAP))
    # The plane consists of two triangles, and the sheet lies across their common edge.
    plane = ls.obstacles.mesh(ls.meshes.floor(size=4.0, cells=1), friction=MU, thickness=GAP)
    gravity = (9.81 * np.sin(angle), 0.0, -9.81 * np.cos(angle))
    scene = ls.Scene(
        cloths=[ls.Cloth(mesh=mesh, thickness=GAP, friction=MU)], obstacles=[plane], gravity=gravity
    )
    return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)


@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_a_sheet_holds_two_percent_below_the_friction_angle_and_does_not_creep(step):
    sim = incline(0.98 * MU, step)
    for _ in range(round(1.2 / step)):
        sim.step()
    settled = sim.positions
    for _ in range(round(0.8 / step)):
        sim.step()
    # Friction anchors do not creep. A creep of 0.1 mm per minute would be 1.3e-6 m in this test.
    assert np.abs(sim.positions - settled).max() < 1e-9


def test_a_held_sheet_does_not_creep_in_a_minute():
    sim = incline(0.98 * MU, 4e-3)
    while sim.time < 1.2:
        sim.step()
    settled = sim.positions
    for _ in range(15_000):
        sim.step()
    assert np.abs(sim.positions - settled).max() < 1e-9


@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_a_sheet_slides_two_percent_above_the_friction_angle(step):
    sim = incline(1.02 * MU, step)
    for _ in range(round(0.6 / step)):
        sim.step()
    assert sim.velocities[:, 0].min() > 0.02  # Coulomb's law gives 0.034 m/s


@pytest.mark.parametrize("step", [1e-3, 2e-3, 4e-3])
@pytest.mark.parametrize("slope", [0.306, 0.36, 0.6])
def test_sliding_sheets_accelerate_as_coulomb_says(slope, step):
    sim = incline(slope, step, cells=8)
    speeds = []
    for _ in range(round(0.4 / step)):
        sim.step()
        if sim.time > 0.1 - 1e-9:
            speeds.append((sim.time, sim.velocities[:, 0].mean()))
    (begin, first), (end, last) = speeds[0], speeds[-1]
    angle = np.arctan(slope)
    pull = 9.81 * (np.sin(angle) - MU * np.cos(angle))
    assert (last - first) / (end - begin) == pytest.approx(pull, rel=0.03)


def capstan(ratio, step=2e-3):
    """Wraps a strip half-way round a cylinder. The first end is pulled with 0.2 N, the second with
    `ratio` times as much. Returns how far [m] the strip slides towards the second end from 0.3 to
    0.6 s.
    """
    radius, width, leg = 0.05, 0.02, 0.06
    r = radius + GAP
    length = np.pi * r + 2 * leg
    flat = ls.grid(size=(width, length), cells=(4, round(length / 0.005)))
    along = flat.vertices[:, 1]
    angle = np.clip(along / r, -np.pi / 2, np.pi / 2)
    straight = along - angle * r
    place = np.stack(
        [
            r * np.sin(angle) + straight * np.cos(angle),
            flat.vertices[:, 0],
            r * np.cos(angle) - straight * np.sin(angle),
        ],
        1,
    )
    mesh = ls.TriangleMesh(place, flat.triangles, flat.vertices[:, :2])
    material = ls.ClothMaterial(
        weft_stiffness=2000.0,
        warp_stiffness=2000.0,
        shear_stiffness=600.0,
        density=0.2,
        bending_weft=1e-7,
        bending_warp=1e-7,
    )
    cylinder = ls.capsule(
        radius=radius, length=0.1, axis=(0.0, 1.0, 0.0), friction=MU, thickness=GAP, segments=64
    )
    strip = ls.Cloth(mesh=mesh, material=material, friction=MU, thickness=GAP)
    scene = ls.Scene(cloths=[strip], obstacles=[cylinder], gravity=(0.0, 0.0, 0.0))
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    ends = [np.isclose(along, along.min()), np.isclose(along, along.max())]
    forces = np.zeros((len(along), 3))
    settled = None
    while sim.time < 0.6:
        for end, size in zip(ends, (0.2, 0.2 * ratio), strict=True):
            forces[end, 2] = -min(1.0, sim.time / 0.1) * size / end.sum()
        sim.external_forces = forces
        sim.step()
        if settled is None and sim.time > 0.3:
            settled = sim.positions[ends[1], 2].mean()
    return settled - sim.positions[ends[1], 2].mean()


def test_a_rope_of_cloth_round_a_cylinder_follows_the_capstan_law():
    law = np.exp(MU * np.pi)
    assert abs(capstan(0.9 * law)) < 1e-6  # sticks
    assert capstan(1.1 * law) > 5e-3  # slips


@pytest.mark.parametrize("share", [0.5, 0.75, 0.92, 1.3])
@pytest.mark.parametrize("step", [1e-3, 4e-3, "auto"])
def test_a_floor_that_accelerates_carries_a_sheet_along(step, share):
    # If the tangential displacement predicted for a step (friction.h) included the change of the
    # floor's velocity in this step, friction would be too weak: at 0.92 of the friction limit, the
    # sheet would have 0.85 of the floor's speed in automatic steps, 0.91 in steps of 4 ms and 0.974
    # in steps of 1 ms.
    acceleration, start, time = share * MU * 9.81, 0.1, 0.1
    times = np.linspace(0.0, 0.5, 2001)
    moved = 0.5 * acceleration * np.maximum(times - start, 0.0) ** 2
    floor = ls.obstacles.mesh(
        ls.floor().mesh,
        friction=MU,
        times=times,
        positions=np.column_stack((moved, np.zeros((len(times), 2)))),
    )
    mesh = ls.grid(size=(0.2, 0.2), triangles=200).moved((0.0, 0.0, 2e-3))
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh, friction=MU)], obstacles=[floor])
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    while sim.time < start + time - 1e-9:
        sim.step()
    exact = min(acceleration, MU * 9.81) * (sim.time - start)
    # Velocities are mean velocities of the last step, which lag by half a step. Another half allows
    # for errors of friction in the first steps of the motion.
    lag = (step if step != "auto" else 10e-3) * acceleration
    assert exact - lag < sim.velocities[:, 0].mean() < exact + lag / 2


def landing(mesh, material, integrator, until):
    """Returns the velocity [m/s] that a sheet loses along a floor on which it lands, and the loss
    by Coulomb's law, which follows from the impulse of the floor.
    """
    start = np.tile([3.0, 0, -1.0], (len(mesh.vertices), 1))
    cloth = ls.Cloth(mesh=mesh, material=material, friction=0.4, velocities=start)
    scene = ls.Scene(cloths=[cloth], obstacles=[ls.floor(friction=0.4)])
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    while sim.time < until:
        sim.step()
    along, _, up = sim.velocities.mean(0)
    return 3 - along, 0.4 * (1 + 9.81 * sim.time + up)


def with_step(scheme, step):
    return scheme() if step is None else scheme(step=step)


@pytest.mark.parametrize(
    ("material", "step", "error"),
    [
        (ls.fabrics["silk"], None, 0.1),
        (ls.fabrics["silk"], 5e-3, 0.1),
        (ls.fabrics["silk"], 1e-2, 0.1),
        (
            ls.ClothMaterial(
                weft_stiffness=1e3, warp_stiffness=1e3, shear_stiffness=300, density=0.03
            ),
            None,
            0.3,
        ),
    ],
)
def test_a_sheet_that_lands_does_not_stop_at_once(material, step, error):
    # Light sheets flutter when they land. If contacts that pull had friction, single steps would
    # stop such a sheet, although Coulomb's law permits only a hundredth of this impulse.
    mesh = ls.grid(size=(0.15, 0.15), triangles=1800).moved((0, 0, 0.05))
    lost, expected = landing(mesh, material, with_step(ls.SemiImplicitEuler, step), until=0.15)
    assert lost == pytest.approx(expected, rel=error)


@pytest.mark.parametrize("step", [None, 4e-3])
@pytest.mark.parametrize("material", [(300.0, 0.1), (1e5, 0.03)])
def test_newton_schemes_find_the_friction_of_a_landing(material, step):
    # The normal forces of an impact change most in the last iterations, so friction limits from an
    # early iterate would be several times too large.
    stiffness, density = material
    mesh = ls.grid(size=(0.15, 0.15), triangles=450).moved((0, 0, 0.02))
    fabric = ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness,
        shear_stiffness=0.3 * stiffness,
        density=density,
    )
    lost, expected = landing(mesh, fabric, with_step(ls.BackwardEuler, step), until=0.08)
    assert lost == pytest.approx(expected, rel=0.03)


def towel_on_bar(integrator, radius, friction, stiffness):
    """Returns how far [m] the longer side of a towel sinks in 0.4 s. The towel slides over a bar
    with a horizontal axis, and one of its sides is six times as long as the other.
    """
    width, length, edge, gap = 0.1, 0.7, 0.01, 2e-3
    r = radius + gap + edge**2 / (8 * radius) + 1e-5  # edges are chords, and must not touch the bar
    arc = np.pi * r
    short = (length - arc) / 7
    flat = ls.grid(size=(width, length), cells=(10, 70))
    along = flat.vertices[:, 1] - flat.vertices[:, 1].min()
    angle = np.clip((along - short) / r, 0, np.pi) - np.pi / 2
    straight = along - short - arc / 2 - angle * r
    place = np.stack(
        [
            r * np.sin(angle) + straight * np.cos(angle),
            flat.vertices[:, 0],
            r * np.cos(angle) - straight * np.sin(angle),
        ],
        1,
    )
    material = ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness,
        shear_stiffness=stiffness / 2,
        density=0.3,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    bar = ls.capsule(
        radius=radius, length=0.3, axis=(0, 1, 0), friction=friction, thickness=gap, segments=64
    )
    mesh = ls.TriangleMesh(place, flat.triangles, flat.vertices[:, :2])
    towel = ls.Cloth(mesh=mesh, material=material, friction=friction, thickness=gap)
    sim = ls.Simulation(ls.Scene(cloths=[towel], obstacles=[bar]), integrator=integrator, threads=1)
    end = along == along.max()
    start = sim.positions[end, 2].mean()
    while sim.time < 0.4:
        before = sim.time, sim.positions[end, 2].mean()
        sim.step()
    after = sim.time, sim.positions[end, 2].mean()
    return start - np.interp(0.4, *zip(before, after, strict=True))


@pytest.mark.parametrize(
    ("radius", "friction", "stiffness", "error"),
    [(0.025, 0.2, 300.0, 0.1), (0.05, 0.2, 300.0, 0.1), (0.025, 0.4, 2000.0, 0.25)],
)
def test_a_towel_slides_over_a_round_bar_in_long_steps(radius, friction, stiffness, error):
    # A vertex that slides by d leaves a bar of the radius r by d^2 / 2 r. It then falls freely and
    # meets the bar again within a later step, whose contacts act only at its end. Contacts must
    # not create energy there, and their friction must not exceed Coulomb's law.
    in_short_steps = towel_on_bar(ls.SemiImplicitEuler(step=1e-3), radius, friction, stiffness)
    way = towel_on_bar(ls.SemiImplicitEuler(), radius, friction, stiffness)
    assert way == pytest.approx(in_short_steps, rel=error)
