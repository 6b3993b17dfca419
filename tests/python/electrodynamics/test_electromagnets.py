"""Circuits with magnetisable bodies: the inductance that cores add, the resulting forces, and
balances of energy and momentum.
"""

import loomstone as ls
import numpy as np
import pytest
from test_circuits import BOX, balance, series_force, simulation

M = ls.magnetics
WEIGHT = ls.RigidBody(name="weight", mesh=BOX, shape="box", position=(3, 0, 0))


def held(core: ls.Magnet, coil: ls.Coil, core_mesh=BOX) -> ls.Scene:
    """A core and a coil on stands, and a distant weight, because circuits need a rigid body."""
    stands = [
        ls.obstacles.mesh(core_mesh, name="core"),
        ls.obstacles.mesh(BOX.moved((0, 0, 0.5)), name="coil"),
    ]
    return ls.Scene(
        obstacles=stands,
        bodies=[WEIGHT],
        magnets=[core],
        coils=[coil],
        gravity=(0, 0, 0),
        collisions=False,
        magnetic_tolerance=1e-6,
    )


def core_inductance(core: ls.Magnet, winding: ls.magnetics.MagneticBody) -> float:
    """Inductance [H] that a core adds to a circuit, from the energy of a current in the circuit."""
    coil = ls.Coil(body="coil", source=winding, resistance=1.0, inductance=1e-3, voltages=[1.0])
    sim = simulation(held(core, coil), 1e-4)
    sim.step()
    return 2.0 * sim.report.circuits.energy / sim.current**2 - 1e-3


def test_a_small_ball_in_a_loop_slows_its_current_by_its_polarisability():
    ball = ls.Magnet(body="core", source=M.soft_sphere(radius=0.004, susceptibility=500.0))
    coil = ls.Coil(
        body="coil",
        source=M.loop(radius=0.02, turns=100),
        resistance=0.5,
        inductance=1e-5,
        voltages=[1.0],
    )
    per_ampere = M.MU0 * 100 / (2 * 0.02)
    added = 4 * np.pi * 0.004**3 / M.MU0 * 500 / 503 * per_ampere**2
    assert added > 0.5e-5, "the ball matters"
    errors = []
    for step in (4e-6, 2e-6):
        sim = simulation(held(ball, coil), step)
        for _ in range(round(4e-5 / step)):
            sim.step()
        errors.append(abs(sim.current - 2.0 * (1 - np.exp(-0.5 * sim.time / (1e-5 + added)))))
        assert abs(balance(sim)) < 1e-15
    assert errors[1] < 1e-2 and errors[1] == pytest.approx(errors[0] / 4, rel=0.1)


@pytest.mark.parametrize("chi", [1000.0, 1.0, -1.0])
def test_the_force_on_a_ball_is_half_the_slope_of_its_inductance(chi):
    def inductance(distance):
        ball = M.soft_sphere(radius=0.01, susceptibility=chi, degree=30)
        loop = M.loop(radius=0.02, turns=100).moved((0, 0, distance))
        return core_inductance(ls.Magnet(body="core", source=ball), loop)

    for distance in (0.02, 0.004):  # ball below the loop; ball inside it
        slope = (inductance(distance - 1e-5) - inductance(distance + 1e-5)) / 2e-5
        assert 0.5 * 25.0 * slope == pytest.approx(
            series_force(0.02, distance, 0.01, chi, 500.0), rel=1e-4
        )


def plunger(z: float, cells: int = 20, **coil) -> ls.Scene:
    """An iron bar on the axis of a solenoid. The centre of the bar is z [m] above that of the
    solenoid.
    """
    bar = ls.RigidBody(
        name="bar",
        mesh=ls.meshes.box(size=(0.008, 0.008, 0.03)),
        shape="box",
        density=2e5,
        position=(0, 0, z),
    )
    iron = M.soft_cuboid(size=(0.008, 0.008, 0.03), susceptibility=1000.0, cells=cells)
    winding = M.solenoid(radius=0.01, length=0.02, turns=200)
    return ls.Scene(
        bodies=[bar],
        obstacles=[ls.obstacles.mesh(BOX.moved((0.5, 0, 0)), name="stand")],
        magnets=[ls.Magnet(body="bar", source=iron)],
        coils=[ls.Coil(body="stand", source=winding, **coil)],
        gravity=(0, 0, 0),
        collisions=False,
        magnetic_tolerance=1e-5,
    )


def test_a_bar_is_drawn_into_a_solenoid_as_its_inductance_grows():
    def inductance(z):
        sim = simulation(plunger(z, resistance=1.0, inductance=1e-3, voltages=[1.0]), 1e-6)
        sim.step()
        return 2.0 * sim.report.circuits.energy / sim.current**2 - 1e-3

    for z in (0.03, 0.015, 0.004):
        scene = plunger(z, currents=[5.0])
        sim = simulation(scene, 1e-6)
        sim.step()
        mass = ls.meshes.mass_properties(scene.bodies[0]).mass
        force = mass * sim.state.body_velocities[0, 2] / 1e-6
        assert force < 0.0, "into the coil"
        # Force and inductance come from different integrals, so their errors differ.
        assert 0.5 * 25.0 * (inductance(z + 1e-4) - inductance(z - 1e-4)) / 2e-4 == pytest.approx(
            force, rel=2e-3
        )
    assert inductance(0.0) > 2 * inductance(0.015) > 4 * inductance(0.03)


def falling(magnets=(), **given) -> ls.Scene:
    """A magnetisable ball flies through a loop with a circuit. Next to them is a body for `magnets`
    and for an optional second coil. All bodies are free.
    """
    places = {  # positions of bodies [m]; "coil" carries the loop 6 cm beside it
        "ball": (0, 0, 0),
        "coil": (0.06, 0, 0.02),
        "magnet": (0.03, 0, 0),
    }
    mesh = {"ball": ls.meshes.sphere(radius=0.01, subdivisions=2)}
    bodies = [
        ls.RigidBody(
            name=n,
            mesh=mesh.get(n, BOX),
            shape="sphere" if n in mesh else "box",
            density=2e5,
            position=p,
        )
        for n, p in places.items()
    ]
    bodies[0] = bodies[0].replace(velocity=(0.3, 0, 4.0), angular_velocity=(30, 10, 0))
    loop = M.loop(radius=0.02, turns=100).moved((-0.06, 0, 0))
    coils = [ls.Coil(body="coil", source=loop, resistance=0.2, inductance=8e-4, voltages=[3.0])]
    if given:
        small = M.loop(radius=0.01, turns=100).moved((0, 0, -0.02))
        coils.append(ls.Coil(body="magnet", source=small, **given))
    soft = ls.Magnet(body="ball", source=M.soft_sphere(radius=0.01, susceptibility=50.0))
    return ls.Scene(
        bodies=bodies,
        magnets=[soft, *magnets],
        coils=coils,
        gravity=(0, 0, 0),
        collisions=False,
        magnetic_tolerance=1e-6,
        rigid_rebuild_interval=2,
    )


def moving(steps: int, of: int, **what) -> ls.Simulation:
    """Returns a simulation of 8 ms in `of` equal steps, after the first `steps` of them."""
    sim = simulation(falling(**what), 8e-3 / of)
    for _ in range(steps):
        sim.step()
    return sim


MAGNET = ls.Magnet(
    body="magnet", source=M.cuboid(size=(0.01, 0.01, 0.01), polarization=(1, 0, 0.5))
)
CASES = {
    "alone": {},
    "beside a magnet": {"magnets": [MAGNET]},
    "beside a magnet and a growing current": {
        "magnets": [MAGNET],
        "times": [0.0, 0.008],
        "currents": [0.0, 20.0],
    },
    "beside another circuit": {
        "magnets": [MAGNET],
        "resistance": 0.3,
        "inductance": 6e-4,
        "voltages": [-2.0],
    },
}


@pytest.mark.parametrize("case", CASES)
def test_energy_and_momentum_balance_where_a_ball_flies_through_a_coil(case):
    start = moving(0, 16, **CASES[case])
    sims = [moving(n, n, **CASES[case]) for n in (16, 32)]
    errors = [abs(balance(sim) - balance(start)) for sim in sims]
    exchanged = sims[1].circuit_supply + sims[1].circuit_heat
    assert errors[1] < 1e-3 * exchanged and errors[1] < 0.3 * errors[0] + 1e-5 * exchanged
    masses = np.array([ls.meshes.mass_properties(b).mass for b in falling().bodies])
    momenta = [masses @ np.asarray(sim.state.body_velocities) for sim in (start, sims[1])]
    assert momenta[1] == pytest.approx(momenta[0], abs=1e-12)


def test_an_electromagnet_goes_on_with_the_same_bits_after_a_checkpoint():
    sims = [moving(n, 16, magnets=[MAGNET]) for n in (4, 0)]
    sims[1].restore(sims[0].checkpoint())
    for sim in sims:
        for _ in range(4):
            sim.step()
    assert sims[0].current == sims[1].current != 0.0
    assert np.array_equal(sims[0].state.body_velocities, sims[1].state.body_velocities)


def push(sim: ls.Simulation) -> None:
    sim.set_obstacle_pose(0, (0.03, 0.001, -0.04))


@pytest.mark.parametrize("write", [None, push])
@pytest.mark.parametrize(
    "case", ["beside a magnet and a growing current", "beside another circuit"]
)
def test_forces_at_the_end_of_a_step_are_reused_if_nothing_has_changed(case, write):
    scene = falling(**CASES[case])
    stand = ls.obstacles.box(
        name="stand",
        size=(0.01, 0.01, 0.01),
        times=[0, 1e-3, 3e-3],
        positions=[(0.03, 0, -0.04)] * 2 + [(0.03, 0, -0.03)],
    )
    scene = scene.replace(obstacles=[stand], magnets=[*scene.magnets, MAGNET.replace(body="stand")])
    going_on, rebuilt = (simulation(scene, 5e-4) for _ in range(2))
    for step in range(10):
        if write and step == 4:
            write(going_on), write(rebuilt)
        rebuilt.rebuild_stages()  # the new stages have no previous step
        for sim in (going_on, rebuilt):
            sim.step()
    for name in (
        "body_centres",
        "body_orientations",
        "body_velocities",
        "body_angular_velocities",
    ):
        assert np.array_equal(getattr(going_on.state, name), getattr(rebuilt.state, name)), name
    assert going_on.current == rebuilt.current and going_on.circuit_supply == rebuilt.circuit_supply


def half_ring(inner: float, outer: float, width: float, parts: int = 8) -> ls.TriangleMesh:
    """Half a ring in the xz-plane, open towards -x; not convex."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, parts + 1)
    section = [
        (inner, -0.5 * width),
        (outer, -0.5 * width),
        (outer, 0.5 * width),
        (inner, 0.5 * width),
    ]
    vertices = np.array([(r * np.cos(a), y, r * np.sin(a)) for a in angles for r, y in section])
    quads = [
        (4 * k + i, 4 * k + 4 + i, 4 * k + 4 + (i + 1) % 4, 4 * k + (i + 1) % 4)
        for k in range(parts)
        for i in range(4)
    ]
    quads += [(0, 1, 2, 3), tuple(4 * parts + i for i in (3, 2, 1, 0))]
    return ls.TriangleMesh(
        vertices, np.array([t for a, b, c, d in quads for t in ((a, c, b), (a, d, c))])
    )


def test_a_bow_around_a_loop_is_outside_its_winding():
    """The bow, half a ring of iron, crosses the plane of a coil only outside the coil's winding."""

    def added(z: float, winding: ls.magnetics.MagneticBody) -> float:
        mesh = half_ring(0.012, 0.018, 0.006).moved((0, 0, z))
        iron = ls.Magnet(body="core", source=M.soft_mesh(mesh, susceptibility=100.0, panels=300))
        coil = ls.Coil(body="coil", source=winding, resistance=1.0, inductance=1e-3, voltages=[1.0])
        sim = simulation(held(iron, coil, mesh), 1e-4)
        sim.step()
        return 2.0 * sim.report.circuits.energy / sim.current**2 - 1e-3

    loop = M.loop(radius=0.009, turns=100)
    short = M.solenoid(radius=0.009, length=5e-4, turns=100)
    for z in (-0.0021, 0.0, 0.0006, 0.0017):
        # The two results differ by a fraction of the order of (length / radius)^2 = 3e-3.
        assert added(z, loop) == pytest.approx(added(z, short), rel=2e-3)


@pytest.mark.parametrize("given", [True, False])
def test_balls_in_the_field_of_a_coil_move_in_sub_steps_that_resolve_their_pull(given):
    ball, mesh = 0.003, ls.meshes.sphere(radius=0.003, subdivisions=2)
    bodies = [
        ls.RigidBody(name=n, mesh=mesh, shape="sphere", density=7800, position=(0, 0, z))
        for n, z in (("a", -0.0045), ("b", 0.0045))
    ]
    iron = M.soft_sphere(radius=ball, susceptibility=1000.0, degree=1)
    magnets = [ls.Magnet(body=n, source=iron) for n in "ab"]
    source = (
        {"currents": [20.0]}
        if given
        else {"resistance": 2.0, "inductance": 5e-3, "voltages": [40.0]}
    )
    winding = M.solenoid(radius=0.02, length=0.06, turns=600)
    coil = ls.Coil(body="stand", source=winding, **source)
    stand = ls.obstacles.mesh(BOX.moved((0, 0, 0.5)), name="stand")
    sim = simulation(
        ls.Scene(
            obstacles=[stand],
            bodies=bodies,
            magnets=magnets,
            coils=[coil],
            gravity=(0, 0, 0),
            collisions=False,
        ),
        2e-3,
    )
    start, substeps = balance(sim), 0
    for _ in range(10):
        sim.step()
        substeps += sim.report.magnets.substeps
    assert substeps > 30
    assert balance(sim) < start + 1e-4, "they click together, which takes energy and gives none"
    assert np.diff(sim.body_centres[:, 2]) == pytest.approx(2 * ball, abs=2e-5)


@pytest.mark.parametrize("soft", [True, False])
def test_a_strong_coil_draws_in_a_body_with_the_speed_of_short_steps(soft):
    ball = (
        M.soft_sphere(radius=0.004, susceptibility=1000.0, degree=1)
        if soft
        else M.sphere(radius=0.004, polarization=(0, 0, 1.0))
    )
    body = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.004, subdivisions=2),
        shape="sphere",
        density=7800,
        position=(0, 0, 0.012),
    )
    winding = M.solenoid(radius=0.01, length=0.01, turns=400)
    coil = ls.Coil(body="stand", source=winding, currents=[50.0])
    stand = ls.obstacles.mesh(BOX.moved((0.5, 0, 0)), name="stand")
    scene = ls.Scene(
        obstacles=[stand],
        bodies=[body],
        magnets=[ls.Magnet(body="ball", source=ball)],
        coils=[coil],
        gravity=(0, 0, 0),
        collisions=False,
    )
    speeds = []
    for step in (2e-3, 1e-4):
        sim = simulation(scene, step)
        for _ in range(round(2e-3 / step)):
            sim.step()
        speeds.append(sim.state.body_velocities[0, 2])
    assert abs(speeds[1]) > 1.0 and speeds[0] == pytest.approx(speeds[1], rel=0.05)


def test_forces_by_currents_are_among_the_magnetic_forces():
    scene = falling(magnets=[MAGNET], times=[0.0, 0.008], currents=[5.0, 20.0])
    scene = scene.replace(
        bodies=[b.replace(velocity=(0, 0, 0), angular_velocity=(0, 0, 0)) for b in scene.bodies]
    )
    sim = simulation(scene, 1e-5)
    for _ in range(20):  # lets a current build up
        sim.step()
    masses = np.array([ls.meshes.mass_properties(b).mass for b in scene.bodies])
    before, forces = np.array(sim.state.body_velocities), np.asarray(sim.magnetic_forces()[0])
    sim.step()
    felt = masses[:, None] * (np.asarray(sim.state.body_velocities) - before) / 1e-5
    assert np.abs(forces).max() > 0.01 and forces == pytest.approx(
        felt, abs=0.06 * np.abs(felt).max()
    )  # the current grows by 1/20 in the step


def test_a_picture_has_no_field_lines_before_the_current_begins():
    scene = plunger(0.015, cells=8, resistance=1.0, inductance=1e-3, voltages=[1.0])
    sim = simulation(scene, 1e-4)
    assert M.frame_curves(sim, sim.frame(), 10) is None
    sim.step()
    assert M.frame_curves(sim, sim.frame(), 10) is not None


def horseshoe(width: float) -> ls.TriangleMesh:
    """A U-shape in the xz-plane. It is `width` thick, and 3 `width` wide and high."""
    outline = np.array([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)])
    side = np.array([(0, 5, 6), (0, 6, 7), (0, 1, 5), (1, 4, 5), (1, 2, 4), (2, 3, 4)])
    vertices = width * np.array([(x, y, z) for y in (-0.5, 0.5) for x, z in outline])
    around = [
        t for i in range(8) for j in [(i + 1) % 8] for t in ((i, i + 8, j), (j, i + 8, j + 8))
    ]
    return ls.TriangleMesh(vertices, np.vstack([side, side[:, ::-1] + 8, np.array(around)]))


def test_circuits_with_bodies_that_do_not_magnetise_linearly_are_refused():
    bar = plunger(0.0, cells=8, resistance=1.0, inductance=1e-3)
    saturated = M.soft_cuboid(size=(0.008, 0.008, 0.03), susceptibility=1e3, saturation=2, cells=8)
    for soft, coil, error, message in (
        ({"source": saturated}, {}, ls.Unsupported, "saturation"),
        ({"response": "explicit", "density": 1e7}, {}, ls.Unsupported, "explicit"),
        ({}, {"inductance": 0.0}, ls.InvalidInput, "inductance must be > 0"),
    ):
        scene = bar.replace(
            magnets=[bar.magnets[0].replace(**soft)], coils=[bar.coils[0].replace(**coil)]
        )
        with pytest.raises(error, match=message):
            ls.Simulation(scene)
    ball = M.soft_sphere(radius=0.009, susceptibility=-1.0, degree=20)
    core = ls.Magnet(body="core", source=ball)
    loop = ls.Coil(
        body="coil",
        source=M.loop(radius=0.0095, turns=100),
        resistance=1.0,
        inductance=1e-5,
        voltages=[1.0],
    )
    with pytest.raises(
        ls.InvalidInput, match="coils.0..inductance must be that of the winding in air"
    ):
        simulation(held(core, loop), 1e-4).step()
    iron = ls.Magnet(body="core", source=M.soft_sphere(radius=0.009, susceptibility=10.0))
    with pytest.raises(ls.InvalidInput, match="lie apart"):
        simulation(held(iron, loop.replace(source=M.loop(radius=0.008, turns=100))), 1e-4)
    mesh = horseshoe(0.01)
    iron = ls.Magnet(body="core", source=M.soft_mesh(mesh, susceptibility=100.0, panels=500))
    # One leg of the horseshoe is inside the winding and the other outside.
    winding = M.solenoid(radius=0.012, length=0.01, turns=100).moved((0.005, 0, 0.02))
    coil = ls.Coil(body="coil", source=winding, resistance=1.0, inductance=1e-3)
    scene = held(iron, coil, mesh)
    with pytest.raises(ls.Unsupported, match="magnets.0., which reaches around it"):
        ls.Simulation(scene)
