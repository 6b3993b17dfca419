"""Simulates random sheets with all integrators, and lists what goes wrong.

    python tests/benchmarks/random_scenes.py [--scenes 100 --seed 1 --integrators bdf2 asynchronous]
    python tests/benchmarks/random_scenes.py --seed 1 --only 17

Size, mesh, material, speed, pins, limits and obstacles of each sheet are random, within a factor of
200 in size and 10,000 in stiffness. A scene is listed if a step fails, an impact is unresolved,
triangles intersect, or the balance of energy with contacts rises by more than --tolerance of the
largest kinetic energy. A scene ends after --wall seconds, even if its motion has not. Ends with
exit status 1 if a step failed, an impact remained or triangles intersected.
"""

import argparse
import time
from typing import Any

import loomstone as ls
import numpy as np
from numpy.typing import NDArray
from smoke import parsed

METHODS = ls.integrators.METHODS
INTEGRATORS = [name for name in METHODS if name != "explicit-euler"]  # that gains energy


def between(random: np.random.Generator, low: float, high: float) -> float:
    """Returns a number between `low` and `high` whose logarithm is uniformly distributed."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def random_mesh(random: np.random.Generator, size: float) -> ls.TriangleMesh:
    cells = int(random.integers(3, 16))
    if random.random() < 0.4:
        triangles, seed = 2 * cells * cells, int(random.integers(100))
        return ls.meshes.irregular(size=(size, size), triangles=triangles, seed=seed)
    return ls.grid(size=(size, size), cells=(cells, cells))


def random_material(random: np.random.Generator) -> ls.ClothMaterial:
    stiffness, bending = between(random, 10.0, 1e5), between(random, 1e-7, 1e-3)
    return ls.ClothMaterial(
        weft_stiffness=stiffness,
        warp_stiffness=stiffness * between(random, 0.3, 3.0),
        shear_stiffness=stiffness * between(random, 0.03, 0.6),
        density=between(random, 0.01, 1.0),
        bending_weft=bending,
        bending_warp=bending,
        bending_damping=1e-3 if random.random() < 0.2 else 0.0,
    )


def smooth_velocities(
    random: np.random.Generator, points: NDArray[np.float64], size: float, speed: float
) -> NDArray[np.float64]:
    """Returns velocities that vary over the sheet, at most `speed` along each axis [m/s]."""
    velocities = np.zeros_like(points)
    for _ in range(4):
        waves, phases = random.integers(1, 3, size=2), random.uniform(0.0, 2.0 * np.pi, size=2)
        shape = np.cos(np.pi * waves * points[:, :2] / size + phases).prod(axis=1)
        velocities += np.outer(shape, random.normal(size=3))
    velocities *= speed / np.abs(velocities).max()
    return velocities


def random_simulation(
    random: np.random.Generator, names: list[str]
) -> tuple[str, float, ls.Simulation]:
    """Returns a description, the time at which the simulation ends [s], and the simulation."""
    name = names[int(random.integers(len(names)))]
    size = between(random, 0.01, 2.0)
    speed = between(random, 0.1, 50.0) * size**0.5
    mesh, material = random_mesh(random, size), random_material(random)
    options: dict[str, Any] = {}
    if random.random() < 0.3:
        options["strain_limit"] = ls.StrainLimit(0.05, 0.05, 0.1)
    if random.random() < 0.2:
        options["bending"] = "hinge"
    n_pins = int(random.integers(0, 4))
    pins = [int(i) for i in random.choice(len(mesh.vertices), size=n_pins, replace=False)]
    obstacles = []
    if random.random() < 0.5:
        obstacles.append(ls.sphere(radius=0.3 * size, centre=(0.0, 0.0, -0.4 * size)))
    if random.random() < 0.5:
        obstacles.append(ls.floor(height=-0.8 * size))
    cloth = ls.Cloth(mesh=mesh, material=material, pins=pins, **options)
    scene = ls.Scene(cloths=[cloth], obstacles=obstacles, collisions=bool(random.random() < 0.8))
    sim = ls.Simulation(scene, integrator=METHODS[name](), threads=1)
    velocities = smooth_velocities(random, mesh.vertices, size, speed)
    velocities[pins] = 0.0
    sim.velocities = velocities
    words = (
        f"{name}, {size:.3g} m, {len(mesh.triangles)} triangles, {speed:.2g} m/s, "
        f"{material.weft_stiffness:.3g} N/m, {material.bending_weft:.1g} N m, "
        f"{material.density:.2g} kg/m^2, {n_pins} pins, {len(obstacles)} obstacles, "
        f"{', '.join(options) or 'no options'}"
    )
    return words, 0.3 * size**0.5, sim


def judge(sim: ls.Simulation, end: float, wall: float) -> tuple[bool, float]:
    """Returns whether the run was wrong, and the largest balance of energy with contacts."""
    wrong, balance, start = False, -np.inf, time.perf_counter()
    while sim.time < end and time.perf_counter() - start < wall:
        sim.step()
        contacts = sim.report.contacts
        wrong = wrong or contacts.unresolved > 0 or contacts.intersections > 0
        balance = max(balance, sim.report.account.contact_balance)
    return wrong, balance


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="number of the only scene to run")
    parser.add_argument("--integrators", nargs="+", choices=INTEGRATORS, default=INTEGRATORS)
    parser.add_argument("--tolerance", type=float, default=0.05)
    parser.add_argument("--wall", type=float, default=8.0, help="[s]")
    given = parsed(parser, scenes=10, wall=0.3)
    n_wrong = n_gaining = 0
    numbers = range(given.scenes) if given.only is None else range(given.only, given.only + 1)
    for number in numbers:
        random = np.random.default_rng((given.seed, number))
        words, end, sim = random_simulation(random, given.integrators)
        try:
            wrong, balance = judge(sim, end, given.wall)
            found = f"balance {balance:.3f}, {sim.step_index} steps to {sim.time / end:.2f}"
        except ls.SolverFailure as failure:
            wrong, balance, found = True, 0.0, str(failure)
        gaining = balance > given.tolerance
        n_wrong, n_gaining = n_wrong + wrong, n_gaining + gaining
        if wrong or gaining or given.only is not None:
            print(f"{number}: {found}: {words}", flush=True)
    print(f"{len(numbers)} scenes: {n_wrong} wrong, {n_gaining} gain energy", flush=True)
    raise SystemExit(1 if n_wrong else 0)


if __name__ == "__main__":
    main()
