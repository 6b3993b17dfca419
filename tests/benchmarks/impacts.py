"""Compares long steps with short ones: towels that hit a floor, and sheets that swing.

    python tests/benchmarks/impacts.py --triangles 400 1280 3000 --tilts 30 60 90 --speeds 2 4 8
    python tests/benchmarks/impacts.py --swing [--integrator bdf2]

The first table has a row for each towel and step. `ratio` is the largest stretch divided by that in
steps of 0.25 ms. `gain` is the largest increase of energy minus work since the start, divided by
the largest kinetic energy. It leaves out the energy of contacts, which `contact` includes. `end` is
like `gain`, but at the end of the run. `parts` is the number of parts of all steps, `shortest` the
length of the shortest part [ms], and `cpu` the processor time [s].

The second table is about sheets that are pinned at two corners and released flat. It lists the time
until the free edge is vertically below these corners, for several stiffnesses and steps.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import Literal

import loomstone as ls
import numpy as np
from smoke import parsed

SIZE = (0.18, 0.12)
STEPS = (1e-3, 4e-3, 1e-2)
Step = float | Literal["auto"]
FINE = 2.5e-4
IMPLICIT = ("semi-implicit-euler", "implicit-midpoint", "bdf2")
SHEETS = ((300.0, 0.3), (3e3, 0.3), (1e4, 0.3), (1e5, 0.03))


def isotropic(stiffness: float, density: float) -> ls.ClothMaterial:
    return ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness,
        shear_stiffness=stiffness / 2,
        density=density,
    )


def towel(triangles: int, tilt: float, speed: float) -> ls.Scene:
    """A towel, tilted by `tilt` [degrees], that hits a floor at `speed` [m/s]."""
    rows = max(1, round(np.sqrt(triangles / 2 * SIZE[1] / SIZE[0])))
    mesh = ls.grid(size=SIZE, cells=(max(1, round(triangles / 2 / rows)), rows))
    along = mesh.vertices[:, 0] - mesh.vertices[:, 0].min()
    angle = np.radians(tilt)
    vertices = np.column_stack(
        (along * np.cos(angle), mesh.vertices[:, 1], 0.005 + along * np.sin(angle))
    )
    velocities = np.zeros_like(vertices)
    velocities[:, 2] = -speed
    cloth = ls.Cloth(
        mesh=ls.TriangleMesh(vertices, mesh.triangles, mesh.uv),
        material=isotropic(300.0, 0.3),
        velocities=velocities,
    )
    return ls.Scene(cloths=[cloth], obstacles=[ls.floor(height=0.0)])


@dataclass
class Fall:
    stretch: float
    gain: float
    contact_gain: float
    end: float
    parts: int
    least_part: float
    seconds: float


def fall(scene: ls.Scene, step: Step, accuracy: float | None, duration: float) -> Fall:
    sim = ls.Simulation(
        scene, integrator=ls.SemiImplicitEuler(step=step, accuracy=accuracy), threads=1
    )
    gains = [(0.0, 0.0)]
    stretch, parts, least = 1.0, 0, np.inf
    began = time.process_time()
    while sim.time < duration - 1e-9:
        sim.step()
        report, account = sim.report, sim.report.account
        stretch, parts = max(stretch, report.strain.stretch), parts + report.parts
        least = min(least, report.error.least_part)
        kinetic = account.largest_kinetic
        gains.append((account.balance * kinetic, account.contact_balance * kinetic))
    seconds = time.process_time() - began
    without, with_contacts = np.array(gains).T / kinetic
    return Fall(stretch, without.max(), with_contacts.max(), without[-1], parts, least, seconds)


def towels(arguments: argparse.Namespace) -> None:
    print(
        "triangles tilt speed   step  stretch  ratio    gain  contact     end  parts  shortest  cpu"
    )
    ratios, gains, contact_gains = [], [], []
    for triangles in arguments.triangles:
        for tilt in arguments.tilts:
            for speed in arguments.speeds:
                scene = towel(triangles, tilt, speed)
                fine = fall(scene, FINE, arguments.accuracy, arguments.duration)
                steps: tuple[Step, ...] = (FINE, *STEPS, 2e-2, "auto")
                for step in steps:
                    found = fall(scene, step, arguments.accuracy, arguments.duration)
                    ratios.append(found.stretch / fine.stretch)
                    gains.append(found.gain)
                    contact_gains.append(found.contact_gain)
                    length = step if isinstance(step, str) else f"{1e3 * step:.2f}"
                    print(
                        f"{triangles:>9} {tilt:>4.0f} {speed:>5.1f} {length:>6}"
                        f" {found.stretch:>8.3f} {ratios[-1]:>6.3f} {found.gain:>7.4f}"
                        f" {found.contact_gain:>8.4f} {found.end:>7.3f} {found.parts:>6}"
                        f" {1e3 * found.least_part:>9.3f} {found.seconds:>4.1f}",
                        flush=True,
                    )
    print(
        f"largest ratio {max(ratios):.3f}, largest gain {max(gains):.4f},"
        f" with contacts {max(contact_gains):.4f}"
    )


def swing_time(stiffness: float, density: float, integrator: ls.Integrator) -> float:
    mesh = ls.grid(size=(0.3, 0.3), cells=(12, 12))
    x = mesh.vertices
    held = np.isclose(x[:, 1], x[:, 1].min())
    corners = held & (np.isclose(x[:, 0], x[:, 0].min()) | np.isclose(x[:, 0], x[:, 0].max()))
    edge = np.isclose(x[:, 1], x[:, 1].max())
    cloth = ls.Cloth(
        mesh=mesh, material=isotropic(stiffness, density), pins=list(np.flatnonzero(corners))
    )
    sim = ls.Simulation(ls.Scene(cloths=[cloth]), integrator=integrator, threads=1)
    low, before = x[:, 1].min(), x[:, 1].max()
    while sim.time < 2.0:
        start = sim.time
        sim.step()
        now = sim.positions[edge, 1].mean()
        if now < low:
            return float(sim.time - (sim.time - start) * (low - now) / (before - now))
        before = now
    return np.inf


def swings(integrator: str, accuracy: float | None) -> None:
    method = ls.integrators.METHODS[integrator]
    steps: list[float | Literal["auto"]] = [5e-4, *STEPS, "auto"]
    print(f"{integrator}: time to the bottom [s] at steps of {', '.join(map(str, steps))} s")
    for stiffness, density in SHEETS:
        times = [
            swing_time(stiffness, density, method(step=step, accuracy=accuracy)) for step in steps
        ]
        print(f"{stiffness:>8.0f} N/m  " + " ".join(f"{t:.4f}" for t in times), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, nargs="+", default=[400, 1280, 3000])
    parser.add_argument("--tilts", type=float, nargs="+", default=[30.0, 60.0, 90.0])
    parser.add_argument("--speeds", type=float, nargs="+", default=[2.0, 4.0, 8.0])
    parser.add_argument("--duration", type=float, default=0.2, help="of each fall [s]")
    parser.add_argument("--accuracy", type=float, default=1.0)
    parser.add_argument("--no-accuracy", action="store_true", help="steps as given")
    parser.add_argument("--swing", action="store_true", help="the second table instead")
    parser.add_argument(
        "--integrator", choices=IMPLICIT, default=IMPLICIT[0], help="of the second table"
    )
    arguments = parsed(parser, triangles=[100], tilts=[60.0], speeds=[4.0], duration=0.04)
    if arguments.no_accuracy:
        arguments.accuracy = None
    if arguments.swing:
        swings(arguments.integrator, arguments.accuracy)
    else:
        towels(arguments)


if __name__ == "__main__":
    main()
