"""Complete runs of the motors of the table vii_motors: a brushed motor whose commutator has two
segments, and magnets that follow a rotating field.

    python tests/benchmarks/motors.py [PATH/vii_motors.json]

The benchmark prints for each motor:
- angle, speed: the largest deviations from the table, relative to its largest values
- balance: the energy missing or gained at the end, relative to the sum of the energies that sources
  supply and that resistances and bearings dissipate

The benchmark takes about a second.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import loomstone as ls
import numpy as np
from smoke import SHARED, parsed, present

TABLE = SHARED / "data" / "magnets" / "vii_motors.json"
TO_X = (np.sqrt(0.5), 0, np.sqrt(0.5), 0)  # quaternion that rotates z to x
TO_Y = (np.sqrt(0.5), -np.sqrt(0.5), 0, 0)
EDGE = 0.02


def scene_of(case: dict[str, Any], until: float) -> tuple[ls.Scene, float]:
    """Returns the scene and the initial angle of the rotor [rad]."""
    if case["type"] == "brushed_dc_two_segment":
        start = case["theta0"]
        winding = ls.magnetics.loop(radius=np.sqrt(case["area"] / np.pi), turns=case["turns"])
        coil = ls.Coil(
            body="rotor",
            source=winding.at((0, 0, 0), TO_X),
            resistance=case["resistance"],
            voltages=[case["voltage"]],
            commutator=(0, -1, 0),
        )
        parts = {"coils": [coil], "magnetic_field": (case["B0"], 0, 0)}
    else:
        start = 0.0
        times = np.linspace(0, until + 0.1, round(4000 * (until + 0.1)) + 1)
        # The frequency increases linearly to its final value and then stays constant.
        ramp, frequency = case["ramp_s"], case["frequency_Hz"]
        phase = (
            2
            * np.pi
            * frequency
            * np.where(times < ramp, times**2 / (2 * ramp), times - 0.5 * ramp)
        )
        radius, turns = 2.0, 1000.0
        current = case["B0"] * 2 * radius / (ls.magnetics.MU0 * turns)
        winding = ls.magnetics.loop(radius=radius, turns=turns)
        coils = [
            ls.Coil(
                body="stand",
                source=winding.at((0, 0, 0), q),
                times=times.tolist(),
                currents=i.tolist(),
            )
            for q, i in ((TO_X, current * np.cos(phase)), (TO_Y, current * np.sin(phase)))
        ]
        stand = ls.obstacles.mesh(
            ls.meshes.box(size=(0.01, 0.01, 0.01)).moved((0, 0, 0.5)), name="stand"
        )
        dipole = ls.magnetics.dipoles([(0, 0, 0)], [(case["rotor_moment"], 0, 0)])
        magnet = ls.Magnet(body="rotor", source=dipole)
        parts = {"coils": coils, "obstacles": [stand], "magnets": [magnet]}
    rotor = ls.RigidBody(
        name="rotor",
        mesh=ls.meshes.box(size=(EDGE,) * 3),
        shape="box",
        density=6 * case["inertia"] / EDGE**5,
        orientation=(np.cos(start / 2), 0, 0, np.sin(start / 2)),
    )
    bearing = ls.Bearing(body="rotor", friction=case["viscous_friction"])
    return ls.Scene(
        bodies=[rotor], bearings=[bearing], gravity=(0, 0, -9.81), magnetic_tolerance=1e-6, **parts
    ), start


def balance(sim: ls.Simulation) -> float:
    """Total energy [J] including losses in resistances and bearings, minus the energy supplied."""
    r = sim.report
    mechanical = r.energy.body_kinetic + r.energy.body_gravity + r.energy.magnetic
    return (
        mechanical
        + r.circuits.energy
        + r.circuits.heat
        + r.circuits.bearing_work
        - r.circuits.supply
    )


def follow(case: dict[str, Any], until: float, step: float) -> dict[str, Any]:
    """Runs a motor and returns its largest deviations of angle [rad] and speed [rad/s] from the
    table.

    Also returns the error of the energy balance [J], the sum of the energies that sources supply
    and that resistances and bearings dissipate [J], and the largest absolute coordinate of the
    rotor's centre at the end [m].
    """
    scene, angle = scene_of(case, until)
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    before = balance(sim)
    times, found = [0.0], [(angle, 0.0)]
    last = sim.state.body_orientations[0].copy()
    while sim.time < until + 0.5 * step:
        sim.step()
        now = sim.state.body_orientations[0].copy()
        angle += 2 * np.arctan2(
            last[0] * now[3] - last[3] * now[0], last[0] * now[0] + last[3] * now[3]
        )
        last = now
        times.append(sim.time)
        found.append((angle, sim.state.body_angular_velocities[0, 2]))
    table = np.array(case["times"])
    known = table <= until + 1e-9
    theta, omega = (np.interp(table[known], times, values) for values in np.array(found).T)
    return {
        "angle": np.abs(theta - np.array(case["theta"])[known]).max(),
        "speed": np.abs(omega - np.array(case["omega"])[known]).max(),
        "missing": abs(balance(sim) - before),
        "turned over": sim.circuit_supply + sim.circuit_heat + abs(sim.bearing_work),
        "place": np.abs(sim.body_centres[0]).max(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", type=Path, nargs="?", default=TABLE)
    parser.add_argument("--until", type=float, help="[s] (default: the end of each table)")
    given = parsed(parser, until=0.01)
    for case in json.loads(present(given.table).read_text())["cases"]:
        step = 1e-4 if case["type"] == "brushed_dc_two_segment" else 1e-3
        until = given.until or case["times"][-1]
        began = time.perf_counter()
        found = follow(case, until, step)
        angle, speed = (
            found["angle"] / max(case["theta"]),
            found["speed"] / max(map(abs, case["omega"])),
        )
        print(
            f"{case['id']} {case['type']:38} to {until} s: angle {angle:.1e}, speed {speed:.1e}, "
            f"balance {found['missing'] / found['turned over']:.1e}, "
            f"{time.perf_counter() - began:.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
