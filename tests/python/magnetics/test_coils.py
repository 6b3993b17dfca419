"""Coils, circuits and bearings: tables of a magnetic brake and of motors, energy balances, and
invalid input.
"""

import loomstone as ls
import motors
import numpy as np
import pytest
from magnet_tables import each_case

DENSITY = 7500


def balance(sim):
    """Total energy [J] including losses in resistances and bearings, minus the energy supplied."""
    r = sim.report
    inductance = sum(coil.inductance for coil in COILS[id(sim)])
    assert (
        r.circuits.energy == 0.5 * inductance * sim.current * sim.current
        and r.circuits.current == sim.current
    )
    mechanical = r.energy.body_kinetic + r.energy.body_gravity + r.energy.magnetic
    return (
        mechanical
        + r.circuits.energy
        + r.circuits.heat
        + r.circuits.bearing_work
        - r.circuits.supply
    )


COILS = {}


def simulation(scene, step):
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    COILS[id(sim)] = scene.coils
    return sim


def falling_magnet(case, tolerance=1e-4):
    """Scene of a magnet that falls through a coil.

    The ball mesh only carries the magnet and gives it the mass listed in the reference table.
    """
    radius = 0.004
    mesh = ls.meshes.sphere(radius=radius, subdivisions=2)
    density = case["magnet_mass"] / ls.meshes.mass_properties(mesh, 1.0).mass
    body = ls.RigidBody(
        name="magnet", mesh=mesh, shape="sphere", density=density, position=(0, 0, case["start_z"])
    )
    size = {"radius": case["magnet_radius"], "height": case["magnet_height"]}
    source = ls.magnetics.cylinder(**size, polarization=(0, 0, case["magnet_Jz"]))
    magnet = ls.Magnet(body="magnet", source=source)
    far = ls.obstacles.mesh(ls.meshes.box(size=(0.01, 0.01, 0.01)).moved((0.2, 0, 0)), name="stand")
    winding = ls.magnetics.solenoid(
        radius=case["coil_radius"], length=case["coil_length"], turns=case["turns"]
    )
    coil = ls.Coil(
        body="stand",
        source=winding,
        resistance=case["coil_resistance"],
        inductance=case["coil_inductance"],
    )
    return ls.Scene(
        bodies=[body],
        obstacles=[far],
        magnets=[magnet],
        coils=[coil],
        gravity=(0, 0, -case["gravity"]),
        magnetic_tolerance=tolerance,
    )


@each_case("vii_magnet_through_coil")
def test_a_magnet_falls_through_a_coil_as_in_the_table(case):
    sim = simulation(falling_magnet(case), 2.5e-4)
    peak = 0.0
    while sim.body_centres[0, 2] > case["end_z"]:
        sim.step()
        peak = max(peak, abs(sim.current))
        before = sim.body_centres[0, 2]
    speed = -sim.state.body_velocities[0, 2]
    late = (case["end_z"] - before) / speed
    # Time and speed are extrapolated back from the last step to the end of the path, which is far
    # from the coil.
    time, speed = (
        sim.time - late,
        speed - case["gravity"] * late,
    )
    # The tolerances cover two errors: the simulation replaces the turns by a current sheet, and its
    # steps of 0.25 ms do not resolve the decay of the current at rates R / L of up to 25,000/s.
    assert time == pytest.approx(case["time"], rel=2e-3)
    assert speed == pytest.approx(case["end_speed"], rel=5e-3)
    assert sim.circuit_heat == pytest.approx(case["joule_heat"], rel=5e-3)
    assert peak == pytest.approx(case["peak_current"], rel=1e-2)


@each_case("vii_magnet_through_coil")
def test_energy_balances_with_second_order(case):
    errors = []
    for step in (2e-3, 1e-3):
        # Steps are not divided into sub-steps.
        sim = simulation(falling_magnet(case, 1e-6).replace(magnetic_step=1.0), step)
        start = balance(sim)
        for _ in range(round(0.1 / step)):
            sim.step()
        errors.append(abs(balance(sim) - start))
    # Each kick satisfies the balance to rounding. The error due to the motion between kicks is of
    # second order in the step. The magnet's fall in uniform gravity contributes no error.
    assert errors[1] < 1e-3 * case["joule_heat"] + 1e-12
    assert errors[1] < 0.3 * errors[0] + 1e-9


@each_case("vii_motors")
def test_motors_follow_the_table(case):
    """Tests the beginning of the runs; tests/benchmarks/motors.py simulates them to their end."""
    until, step = (0.1, 1e-4) if case["type"] == "brushed_dc_two_segment" else (0.5, 1e-3)
    found = motors.follow(case, until, step)
    assert found["angle"] < 2e-3 * max(case["theta"])
    assert found["speed"] < 5e-3 * np.abs(case["omega"]).max()
    assert found["place"] < 1e-12, "the bearing holds it"
    # Each kick satisfies the energy balance to rounding. The motion between kicks causes a relative
    # error of the order of the square of the angle [rad] by which the rotor turns in it.
    assert found["missing"] < 5e-3 * found["turned over"]


def test_a_current_pushes_magnet_and_coil_with_opposite_forces():
    box = ls.meshes.box(size=(0.01, 0.01, 0.01))
    bodies = [
        ls.RigidBody(name=n, mesh=box, shape="box", position=x)
        for n, x in (("coil", (0, 0, 0)), ("magnet", (0.01, 0, 0.03)))
    ]
    winding = ls.magnetics.solenoid(radius=0.01, length=0.01, turns=50)
    magnet = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    scene = ls.Scene(
        bodies=bodies,
        gravity=(0, 0, 0),
        coils=[ls.Coil(body="coil", source=winding, currents=[2.0])],
        magnets=[ls.Magnet(body="magnet", source=magnet)],
    )
    sim = simulation(scene, 1e-4)
    sim.step()
    a = ls.magnetics.solenoid(radius=0.01, length=0.01, turns=50, current=2.0)
    b = magnet.moved((0.01, 0, 0.03))
    wanted = ls.magnetics.force(on=b, by=a).force
    momenta = 1e-3 * sim.state.body_velocities  # each body has 1 g
    assert momenta[1] / 1e-4 == pytest.approx(wanted, rel=1e-3)
    assert np.abs(momenta.sum(axis=0)).max() < 1e-15
    assert sim.circuit_supply == pytest.approx(sim.report.energy.body_kinetic, rel=1e-9)


def test_the_current_goes_on_after_a_checkpoint():
    case = {
        "magnet_mass": 0.01,
        "magnet_radius": 0.005,
        "magnet_height": 0.01,
        "magnet_Jz": 1.0,
        "start_z": 0.02,
        "gravity": 9.81,
        "coil_radius": 0.008,
        "coil_length": 0.01,
        "turns": 100,
        "coil_resistance": 1.0,
        "coil_inductance": 1e-3,
    }
    sims = [simulation(falling_magnet(case, 1e-3), 1e-3) for _ in range(2)]
    for _ in range(40):
        sims[0].step()
    sims[1].restore(sims[0].checkpoint())
    for sim in sims:
        for _ in range(5):
            sim.step()
    assert sims[0].current != 0.0
    assert [s.current for s in sims] == 2 * [sims[0].current]
    assert sims[0].circuit_heat == sims[1].circuit_heat


def test_bad_coils_and_bearings_are_refused():
    box = ls.RigidBody(name="b", mesh=ls.meshes.box(size=(0.01, 0.02, 0.03)), shape="box")
    M = ls.magnetics
    good = {"body": "b", "source": M.solenoid(radius=0.01, length=0.01, turns=1)}
    strong = M.loop(radius=0.01, current=2.0)
    line = M.polyline([(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 0, 0)], current=1.0)
    for bad, message in (
        ({"coils": [ls.Coil(**good)]}, "either currents .* got neither"),
        (
            {"coils": [ls.Coil(**good, currents=[1.0], resistance=1.0)]},
            "either currents .* got both",
        ),
        ({"coils": [ls.Coil(**good, currents=[1.0], inductance=1.0)]}, "belong to a circuit"),
        ({"coils": [ls.Coil(**good, currents=[1.0, 2.0])]}, "one value for each"),
        (
            {"coils": [ls.Coil(**good, currents=[1.0, 2.0], times=[1.0, 0.0])]},
            "must be finite and ascending",
        ),
        ({"coils": [ls.Coil(body="b", currents=[1.0])]}, "loop or a solenoid.*got none"),
        (
            {"coils": [ls.Coil(body="b", source=strong, currents=[1.0])]},
            "default current of 1 A, got 2 A",
        ),
        (
            {"coils": [ls.Coil(**(good | {"body": "c"}), currents=[1.0])]},
            "body must be one of the names .b., got .c.",
        ),
        ({"coils": [ls.Coil(body="b", source=line, currents=[1.0])]}, "loop or a solenoid"),
        ({"bearings": [ls.Bearing(body="b", axis=(1, 1, 0))]}, "principal axis"),
        ({"bearings": [ls.Bearing(body="b"), ls.Bearing(body="b")]}, "has a bearing already"),
        ({"bearings": [ls.Bearing(body="b", axis=(0, 0, 0))]}, "axis must be finite"),
    ):
        with pytest.raises(ls.InvalidInput, match=message):
            ls.Simulation(ls.Scene(bodies=[box], **bad))
    for bad, message in (
        (
            {
                "bearings": [ls.Bearing(body="b")],
                "cloths": [ls.Cloth(mesh=ls.grid(cells=(2, 2)).moved((0, 0, 1)))],
            },
            "scene.bearings require a scene without cloth",
        ),
    ):
        with pytest.raises(ls.Unsupported, match=message):
            ls.Simulation(ls.Scene(bodies=[box], **bad))


def test_a_circle_that_rounding_errors_leave_open_is_closed():
    angles = np.linspace(0.0, 2.0 * np.pi, 200)
    M = ls.magnetics
    circle = M.polyline(np.c_[0.02 * np.cos(angles), 0.02 * np.sin(angles), 0 * angles], current=1)
    ball = M.sphere(radius=0.005, polarization=(0, 0, 1)).moved((0, 0, 0.05))
    loop = M.force(on=ball, by=M.loop(radius=0.02, current=1.0)).force
    assert M.force(on=ball, by=circle).force == pytest.approx(loop, rel=1e-3, abs=1e-12)


@pytest.mark.parametrize("length", [0.5, 1.0, 1.5])
def test_the_torque_on_a_coil_wound_on_a_magnet_is_the_limit_of_wider_coils(length):
    M, radius = ls.magnetics, 0.01
    magnet = M.cylinder(radius=radius, height=radius, polarization=(1, 0, 0))
    on, wider = (
        M.solenoid(radius=radius * k, length=length * radius, turns=100) for k in (1.0, 1.0 + 1e-7)
    )
    limit = M.force(on=wider, by=magnet).torque
    assert M.force(on=on, by=magnet).torque == pytest.approx(limit, rel=1e-3, abs=1e-8)
    assert -M.force(on=magnet, by=on).torque == pytest.approx(limit, rel=1e-3, abs=1e-8)
