"""Circuits with mutual inductance, loops and dipoles that scripts move, and coils that magnetise
bodies: closed forms and balances of momentum and energy.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import _core
from scipy.special import ellipe, ellipk, eval_gegenbauer

M = ls.magnetics
BOX = ls.meshes.box(size=(0.01, 0.01, 0.01))
ONE, TWO = dict(radius=0.05, length=0.04, turns=200), dict(radius=0.04, length=0.04, turns=100)


def simulation(scene: ls.Scene, step: float) -> ls.Simulation:
    return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)


def balance(sim: ls.Simulation) -> float:
    """Total energy [J] including losses in resistances, minus the energy supplied."""
    r = sim.report
    return (
        r.energy.body_kinetic
        + r.energy.magnetic
        + r.circuits.energy
        + r.circuits.heat
        - r.circuits.supply
    )


def of_circles(a: float, b: float, distance: float) -> float:
    """Mutual inductance [H] of two coaxial circles by Maxwell's formula."""
    m = 4 * a * b / ((a + b) ** 2 + distance**2)
    return 4e-7 * np.pi * np.sqrt(a * b / m) * ((2 - m) * ellipk(m) - 2 * ellipe(m))


def test_mutual_inductances_are_those_of_their_circles():
    for a, b, distance in ((0.1, 0.01, 0.0), (0.1, 0.08, 0.02), (0.1, 0.1, 0.001)):
        pair = M.loop(radius=a, current=1.0), M.loop(radius=b, current=1.0).moved((0, 0, distance))
        assert M.mutual_inductance(*pair, tolerance=1e-10) == pytest.approx(
            of_circles(a, b, distance), rel=1e-10
        )
    x, w = np.polynomial.legendre.leggauss(40)
    # The radii of the coils differ, so the integrand is smooth, and the quadrature is exact up to
    # rounding.
    heights = np.abs(0.02 * x[:, None] - 0.02 * x - 0.03)
    wanted = 200 * 100 / 4 * np.einsum("i,j,ij->", w, w, of_circles(0.05, 0.04, heights))
    one, two = M.solenoid(**ONE, current=1.0), M.solenoid(**TWO, current=1.0).moved((0, 0, 0.03))
    assert M.mutual_inductance(one, two) == pytest.approx(wanted, rel=1e-5)
    assert M.mutual_inductance(one, two.rotated((np.pi, 0, 0))) == pytest.approx(-wanted, rel=1e-5)
    # At unit currents, the force along x must equal the derivative of the mutual inductance with
    # respect to a displacement of `beside` along x.
    beside, step = two.moved((0.07, 0.02, 0)).rotated((0.5, 0.2, 0)), 1e-5
    ends = [
        M.mutual_inductance(one, beside.moved((s * step, 0, 0)), tolerance=1e-11) for s in (1, -1)
    ]
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(
        M.force(on=beside, by=one, tolerance=1e-8).force[0], rel=1e-4
    )
    with pytest.raises(ls.InvalidInput, match="loops and solenoids"):
        M.mutual_inductance(one, M.sphere(radius=0.1, polarization=(0, 0, 1)))


def test_the_inductance_of_a_loop_with_itself_is_refused_because_it_is_infinite():
    loop = M.loop(radius=0.1, current=1.0)
    for other in (loop, loop.rotated((np.pi, 0, 0)), M.loop(radius=0.1, current=2.0)):
        with pytest.raises(ls.InvalidInput, match="thin wire with itself is infinite"):
            M.mutual_inductance(loop, other)
    # The self-inductance of a solenoid and the mutual inductance of two close loops are finite.
    winding = M.solenoid(radius=0.1, length=0.05, current=1.0, turns=100)
    assert np.isfinite(M.mutual_inductance(winding, winding))
    assert M.mutual_inductance(loop, loop.moved((0, 0, 1e-4))) > 0


def transformer(**second) -> ls.Scene:
    """Two coaxial windings on obstacles. The second is narrower, and its centre is 10 mm higher.
    The only rigid body is a distant weight.
    """
    stands = [
        ls.obstacles.mesh(BOX.moved((0, 0, z)), name=name) for name, z in (("a", 0.5), ("b", -0.5))
    ]
    weight = ls.RigidBody(name="weight", mesh=BOX, shape="box", position=(1, 0, 0))
    coils = [
        ls.Coil(
            body="a", source=M.solenoid(**ONE), resistance=0.5, inductance=4e-3, voltages=[1.0]
        ),
        ls.Coil(
            body="b",
            source=M.solenoid(**TWO).moved((0, 0, 0.01)),
            **(second or dict(resistance=0.8, inductance=1.2e-3)),
        ),
    ]
    return ls.Scene(obstacles=stands, bodies=[weight], coils=coils, gravity=(0, 0, 0))


MUTUAL = M.mutual_inductance(
    M.solenoid(**ONE, current=1.0), M.solenoid(**TWO, current=1.0).moved((0, 0, 0.01))
)


def test_two_coupled_circuits_follow_the_closed_form_with_second_order():
    inductances, resistances = np.array([[4e-3, MUTUAL], [MUTUAL, 1.2e-3]]), np.array((0.5, 0.8))
    rates, modes = np.linalg.eig(np.linalg.solve(inductances, np.diag(resistances)))
    final = np.array((2.0, 0.0))
    errors = []
    for step in (4e-4, 2e-4):
        sim = simulation(transformer(), step)
        for _ in range(round(4e-3 / step)):
            sim.step()
        exact = final - modes @ (np.exp(-rates * sim.time) * np.linalg.solve(modes, final))
        errors.append(np.abs(sim.currents - exact).max())
        assert abs(balance(sim)) < 1e-15, "every kick balances to rounding"
        assert sim.frame().coil_currents == pytest.approx(sim.currents, rel=1e-15)
    assert errors[1] < 5e-5 and errors[1] == pytest.approx(errors[0] / 4, rel=0.05)
    assert sim.currents[1] < -0.2, "the second opposes what the first does"


def test_a_changing_given_current_drives_a_nearby_circuit():
    frequency, times = 50.0, np.linspace(0, 0.1, 2001)
    given = np.sin(2 * np.pi * frequency * times)
    scene = transformer(times=times.tolist(), currents=given.tolist())
    sim = simulation(
        scene.replace(coils=[scene.coils[0].replace(voltages=[]), scene.coils[1]]), 1e-4
    )
    found = []
    while sim.time < 0.08:
        sim.step()
        found.append((sim.time, sim.current))
    time, current = np.array(found)[-400:].T  # two periods, after five time constants
    wave = 2 / 400 * (current * np.exp(-2j * np.pi * frequency * time)).sum()
    omega = 2 * np.pi * frequency
    wanted = -1j * omega * MUTUAL / (0.5 + 1j * omega * 4e-3) * -1j
    assert abs(wave - wanted) < 2e-3 * abs(wanted)  # errors of order (omega h)^2 for a step h
    assert abs(balance(sim)) < 1e-12


def moving(step: float, steps: int) -> ls.Simulation:
    """Returns a simulation after `steps` steps. Three coils approach one another and rotate: one
    with a given voltage, a shorted one, and one with a given current.
    """
    places = {"a": (0, 0, 0), "b": (0.02, 0, 0.05), "c": (-0.03, 0.02, -0.05)}
    bodies = [
        ls.RigidBody(
            name=n,
            mesh=BOX,
            shape="box",
            density=2e5,
            position=p,
            velocity=(0, 0, -10 * p[2]),
            angular_velocity=(0, 20, 5),
        )
        for n, p in places.items()
    ]
    winding, loop = M.solenoid(radius=0.03, length=0.02, turns=200), M.loop(radius=0.03, turns=200)
    coils = [
        ls.Coil(body="a", source=winding, resistance=0.2, inductance=4e-3, voltages=[2.0]),
        ls.Coil(body="b", source=loop, resistance=0.2, inductance=5e-3),
        ls.Coil(body="c", source=winding, times=[0.0, 0.1], currents=[0.0, 10.0]),
    ]
    sim = simulation(
        ls.Scene(
            bodies=bodies,
            coils=coils,
            gravity=(0, 0, 0),
            collisions=False,
            magnetic_tolerance=1e-5,
            rigid_rebuild_interval=2,
        ),
        step,
    )
    for _ in range(steps):
        sim.step()
    return sim


def test_moving_circuits_keep_momentum_and_balance_their_energy_with_second_order():
    start = balance(moving(1e-3, 0))
    sims = [moving(0.02 / n, n) for n in (8, 16)]
    errors = [abs(balance(sim) - start) for sim in sims]
    exchanged = sims[1].circuit_supply
    assert errors[1] < 1e-3 * exchanged and errors[1] < 0.3 * errors[0] + 1e-6 * exchanged
    momentum = 0.2 * np.asarray(sims[1].state.body_velocities).sum(axis=0)
    assert momentum == pytest.approx((0, 0, 0), abs=1e-12)
    # A simulation restored from a checkpoint continues with the same bits as the original.
    halves = [moving(1e-3, 0), moving(1e-3, 4)]
    halves[0].restore(halves[1].checkpoint())
    for sim in halves:
        for _ in range(2):
            sim.step()
    assert (
        np.array_equal(halves[0].currents, halves[1].currents)
        and np.abs(halves[0].currents).min() > 0
    )


def test_a_step_in_which_two_loops_meet_fails_and_changes_nothing():
    loop = M.loop(radius=0.03, turns=200)
    meeting = {"times": [0.0, 0.002], "positions": [(0, 0, 0.01), (0, 0, 0)]}
    scene = ls.Scene(
        bodies=[ls.RigidBody(mesh=BOX, shape="box", density=1e3, position=(1, 0, 0))],
        obstacles=[ls.Obstacle(name="a", mesh=BOX), ls.Obstacle(name="b", mesh=BOX, **meeting)],
        coils=[
            ls.Coil(body="a", source=loop, resistance=0.2, inductance=4e-3, voltages=[2.0]),
            ls.Coil(body="b", source=loop, resistance=0.2, inductance=4e-3),
        ],
        collisions=False,
    )
    sim = simulation(scene, step=1e-3)
    sim.step()
    before, currents = sim.digest(), sim.currents.copy()
    for _ in range(2):
        with pytest.raises(ls.InvalidInput, match="thin wire with itself is infinite"):
            sim.step()
        assert sim.digest() == before and (sim.currents == currents).all()


RADIUS, TURNS, MOMENT, SPEED = 0.02, 50, 0.5, 3.0


def scripted(**what) -> ls.Scene:
    """A dipole and a loop, each on its own stand. `scripts` moves one of the stands. If
    `magnetic_field` is given, this uniform field replaces the dipole. The only rigid body is a
    distant weight, on which no force acts.
    """
    stands = {"magnet": {}, "loop": {}} | what.pop("scripts")
    obstacles = [
        ls.obstacles.mesh(BOX.moved((0, 0, z)), name=name, **stands[name])
        for name, z in (("magnet", 0.5), ("loop", -0.5))
    ]
    magnets = (
        []
        if "magnetic_field" in what
        else [ls.Magnet(body="magnet", source=M.dipoles([(0, 0, 0)], [(0, 0, MOMENT)]))]
    )
    coil = ls.Coil(
        body="loop",
        source=M.loop(radius=RADIUS, turns=TURNS),
        resistance=0.3,
        inductance=what.pop("inductance", 0.0),
    )
    weight = ls.RigidBody(name="weight", mesh=BOX, shape="box", position=(5, 0, 0))
    return ls.Scene(
        obstacles=obstacles,
        bodies=[weight],
        magnets=magnets,
        coils=[coil],
        gravity=(0, 0, 0),
        **what,
    )


def passing(name: str, sense: float) -> dict:
    return {
        name: dict(
            times=[0.0, 0.1],
            positions=[(0, 0, -0.15 * sense), (0, 0, -0.15 * sense + 0.1 * SPEED * sense)],
        )
    }


def flux(z):
    """Flux linkage [T m^2] of the dipole with all turns of the loop at an axial distance z [m]."""
    return TURNS * 2e-7 * np.pi * MOMENT * RADIUS**2 / (RADIUS**2 + z**2) ** 1.5


@pytest.mark.parametrize(
    "script", [passing("magnet", 1.0), passing("loop", -1.0)], ids=["magnet", "loop"]
)
def test_a_dipole_moved_by_script_along_the_axis_of_a_loop_drives_the_current_of_faraday(script):
    sim = simulation(scripted(scripts=script), 5e-4)
    exact, found = [], []
    while sim.time < 0.0999:
        sim.step()
        z = -0.15 + SPEED * sim.time
        exact.append(3 * z / (RADIUS**2 + z**2) * flux(z) * SPEED / 0.3)
        found.append(sim.current)
    assert found == pytest.approx(exact, rel=1e-9, abs=1e-9 * max(exact))
    assert found[40] < 0 < found[-40], (
        "it opposes the flux that grows and sustains the one that falls"
    )
    # All work of the script becomes heat. The sum below takes the power only at the ends of steps,
    # so its tolerance is larger.
    assert sim.circuit_supply == pytest.approx(sim.circuit_heat, rel=1e-12)
    assert sim.circuit_heat == pytest.approx(0.3 * 5e-4 * np.square(exact).sum(), rel=1e-3)
    assert sim.state.body_velocities == pytest.approx(0.0, abs=1e-9), (
        "the weight five metres off stays"
    )


def test_the_charge_that_a_passing_magnet_moves_is_the_change_of_flux_over_the_resistance():
    sim = simulation(
        scripted(
            scripts={"magnet": dict(times=[0.0, 0.05], positions=[(0, 0, -0.15), (0, 0, 0)])},
            inductance=1e-3,
        ),
        5e-4,
    )
    charge, before = 0.0, 0.0
    # The magnet moves for 0.05 s and stops in the middle of the wire loop.
    for _ in range(160):
        sim.step()
        charge, before = charge + 5e-4 * 0.5 * (before + sim.current), sim.current
    # The tolerance allows for the step of 0.5 ms, which is 0.15 of the current's time constant.
    assert charge == pytest.approx((flux(0.15) - flux(0.0)) / 0.3, rel=2e-3)
    assert sim.circuit_supply == pytest.approx(
        sim.circuit_heat + sim.report.circuits.energy, rel=1e-12
    )


def test_a_loop_turned_by_script_in_a_uniform_field_is_a_generator():
    times = np.linspace(0.0, 0.1, 41)
    turns = np.outer(20 * np.pi * times, (1, 0, 0))
    sim = simulation(
        scripted(
            scripts={"loop": dict(times=times, axis_angles=turns)}, magnetic_field=(0, 0, 0.2)
        ),
        5e-4,
    )
    peak = TURNS * 0.2 * np.pi * RADIUS**2 * 20 * np.pi / 0.3
    for _ in range(200):
        sim.step()
        assert sim.current == pytest.approx(peak * np.sin(20 * np.pi * sim.time), abs=1e-6 * peak)
    assert sim.circuit_supply == pytest.approx(sim.circuit_heat, rel=1e-12)
    assert sim.circuit_heat == pytest.approx(0.5 * 0.3 * peak**2 * 0.1, rel=1e-3)


def test_the_heat_of_a_generator_turned_by_script_does_not_depend_on_the_step():
    times = np.linspace(0.0, 0.1, 401)
    turns = np.outer(80 * np.pi * times, (1, 0, 0))  # 40 turns per second
    for field in ((0, 0, 0.2), (0, 0.2, 0)):
        sim = simulation(
            scripted(scripts={"loop": dict(times=times, axis_angles=turns)}, magnetic_field=field),
            1e-2,
        )
        for _ in range(10):
            sim.step()
        peak = TURNS * 0.2 * np.pi * RADIUS**2 * 80 * np.pi / 0.3
        assert sim.circuit_heat == pytest.approx(0.5 * 0.3 * peak**2 * 0.1, rel=1e-3)


def series_force(radius: float, distance: float, ball: float, chi: float, current: float) -> float:
    """Axial force [N] on a linearly magnetisable ball, from a multipole series.

    The ball has the radius `ball` [m] and the susceptibility `chi`. It is on the axis of a loop of
    radius `radius` [m], at `distance` [m] below the plane of the loop. `current` [A] is the sum
    of the currents in all turns of the loop.
    """
    s = np.hypot(radius, distance)
    n = np.arange(60)
    # Coefficients of the field on the axis as a power series in the height z above the ball's
    # centre.
    field = current * radius**2 / (2 * s**3) * eval_gegenbauer(n, 1.5, distance / s) / s**n
    potential = np.append(0.0, -field / (n + 1))  # coefficients of the powers of z
    degree = n[1:]
    answer = (
        -degree * chi / (degree * chi + 2 * degree + 1) * potential[1:-1] * ball ** (2 * degree + 1)
    )
    return float(-4 * np.pi * M.MU0 * ((degree + 1) * answer * potential[2:]).sum())


def ball_and_coil(currents, times=(), magnets=(), **ball) -> ls.Scene:
    """A magnetisable ball below a loop, and beside them a body for `magnets`. All three bodies are
    free.
    """
    bodies = [
        ls.RigidBody(
            name="ball",
            mesh=ls.meshes.sphere(radius=0.01, subdivisions=2),
            shape="sphere",
            density=2e5,
        ),
        ls.RigidBody(name="coil", mesh=BOX, shape="box", density=2e5, position=(0, 0, 0.02)),
        ls.RigidBody(name="magnet", mesh=BOX, shape="box", density=2e5, position=(0.03, 0, 0)),
    ]
    soft = ls.Magnet(body="ball", source=M.soft_sphere(radius=0.01, **ball))
    coil = ls.Coil(
        body="coil",
        source=M.loop(radius=0.02, turns=100),
        times=list(times),
        currents=list(currents),
    )
    return ls.Scene(
        bodies=bodies,
        magnets=[soft, *magnets],
        coils=[coil],
        gravity=(0, 0, 0),
        collisions=False,
        magnetic_tolerance=1e-6,
    )


@pytest.mark.parametrize("chi", [1000.0, 1.0, -1.0])
def test_a_coil_magnetises_a_ball_and_is_pulled_as_the_series_says(chi):
    scene = ball_and_coil([5.0], susceptibility=chi, degree=30)
    sim = simulation(scene, 1e-5)
    sim.step()
    mass = np.array([ls.meshes.mass_properties(b.mesh, b.density).mass for b in scene.bodies])
    momenta = mass[:, None] * np.asarray(sim.state.body_velocities)
    assert momenta[0, 2] / 1e-5 == pytest.approx(
        series_force(0.02, 0.02, 0.01, chi, 500.0), rel=1e-5
    )
    assert np.abs(momenta.sum(axis=0)).max() < 1e-12 * np.abs(momenta[0, 2])
    assert sim.circuit_supply == pytest.approx(sim.report.energy.body_kinetic, rel=1e-9)


def test_energy_balances_where_coil_and_magnet_magnetise_a_ball():
    source = M.cuboid(size=(0.01, 0.01, 0.01), polarization=(1, 0, 0.5))
    magnet = ls.Magnet(body="magnet", source=source)
    errors = []
    for n in (16, 32):
        scene = ball_and_coil(
            [0.0, 30.0], times=(0.0, 0.016), magnets=[magnet], susceptibility=50.0
        )
        sim = simulation(scene, 0.016 / n)
        start = balance(sim)
        for _ in range(n):
            sim.step()
        errors.append(abs(balance(sim) - start))
    assert (
        errors[1] < 2e-3 * sim.report.energy.body_kinetic
        and errors[1] < 0.3 * errors[0] + 1e-6 * sim.report.energy.body_kinetic
    )


def test_invalid_circuits_are_refused():
    bad = transformer(resistance=0.8, inductance=1e-4)
    with pytest.raises(ls.InvalidInput, match="M\\^2 < L_1 L_2"):
        ls.Simulation(bad)
    soft = ball_and_coil([1.0], susceptibility=10.0, degree=8)
    inside = soft.coils[0].replace(source=M.loop(radius=0.008, turns=100).moved((0, 0, -0.02)))
    with pytest.raises(ls.InvalidInput, match="must lie apart from bodies that magnetise"):
        ls.Simulation(soft.replace(coils=[inside]))


def test_circuits_without_a_rigid_body_are_refused():
    with pytest.raises(ls.Unsupported, match="circuits are advanced together with rigid bodies"):
        ls.Simulation(
            transformer().replace(
                bodies=[], cloths=[ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(2, 2)))]
            )
        )


def test_a_frame_draws_the_closed_lines_of_a_coil_with_a_circuit(tmp_path):
    scene = transformer()
    sim = simulation(scene, 1e-3)
    assert ls.magnetics.frame_curves(sim, sim.frame(), 10) is None, "no current has begun to flow"
    sim.step()
    frame = sim.frame()
    coils = sim.magnets(frame)
    assert [
        c.moment[2] / (np.pi * w["radius"] ** 2 * w["turns"])
        for c, w in zip(coils, (ONE, TWO), strict=True)
    ] == pytest.approx(sim.currents)
    found = M.field_lines(coils, 40)
    assert found.ends.count(M.LineEnd.closed) > 20
    for line, end in zip(found.lines, found.ends, strict=True):
        if end == M.LineEnd.closed:
            assert np.array_equal(line[0], line[-1]), "a closed line ends where it began"
    curves = ls.magnetics.frame_curves(sim, frame, 40)
    renderer = ls.pictures.Renderer(sim.topology, ls.RenderOptions(width=120, height=90, samples=1))
    assert (renderer.render(frame, curves) != renderer.render(frame)).any()
    _core.FrameWriter(str(tmp_path), sim.topology, "{}").write(frame)
    assert (
        _core.FrameReader(str(tmp_path)).frame(0).coil_currents.tolist()
        == frame.coil_currents.tolist()
    )
