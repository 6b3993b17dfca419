"""Energy of magnets that swing for 10,000 periods: a compass needle in a uniform field, and two
balls that turn in fixed bearings.

    python tests/benchmarks/librations.py [--periods 10000]

The benchmark prints two results per system, both relative to the largest kinetic energy:
- swing: the largest deviation of the energy from its value after the first step
- drift: the difference between the mean energies over the last and the first tenth of the run

The benchmark takes 10 to 20 s.
"""

import argparse
import time

import loomstone as ls
import numpy as np
from smoke import parsed


def compass() -> tuple[ls.Scene, float]:
    """Returns the scene and the period of small oscillations [s]."""
    box, field = (0.02, 0.005, 0.005), 5e-3
    mesh = ls.meshes.box(size=box)
    needle = ls.RigidBody(
        name="needle",
        mesh=mesh,
        shape="box",
        density=7500,
        orientation=(np.cos(0.25), 0, 0, np.sin(0.25)),
    )
    source = ls.magnetics.cuboid(size=box, polarization=(1.0, 0, 0))
    magnet = ls.Magnet(body="needle", source=source)
    inertia = np.asarray(ls.meshes.mass_properties(mesh, 7500).inertia)[2, 2]
    frequency = np.sqrt(np.prod(box) / ls.magnetics.MU0 * field / inertia)
    return ls.Scene(
        bodies=[needle], magnets=[magnet], magnetic_field=(field, 0, 0), gravity=(0, 0, 0)
    ), 2 * np.pi / frequency


def pair(radius: float = 0.01, gap: float = 0.01) -> tuple[ls.Scene, float]:
    mesh, distance = ls.meshes.sphere(radius=radius, subdivisions=2), 2 * radius + gap
    bodies = [
        ls.RigidBody(
            name=name,
            mesh=mesh,
            shape="sphere",
            density=7500,
            position=(x, 0, 0),
            orientation=(np.cos(a), 0, 0, np.sin(a)),
        )
        for name, x, a in (("a", 0.0, 0.25), ("b", distance, -0.075))
    ]
    magnets = [
        ls.Magnet(
            body=body.name, source=ls.magnetics.sphere(radius=radius, polarization=(1.2, 0, 0))
        )
        for body in bodies
    ]
    bearings = [ls.Bearing(body=body.name, axis=(0, 0, 1)) for body in bodies]
    moment = 1.2 * 4 / 3 * np.pi * radius**3 / ls.magnetics.MU0
    inertia = np.asarray(ls.meshes.mass_properties(mesh, 7500).inertia)[2, 2]
    frequency = np.sqrt(3e-7 * moment**2 / distance**3 / inertia)  # in-phase mode [rad/s]
    return ls.Scene(
        bodies=bodies, magnets=magnets, bearings=bearings, gravity=(0, 0, 0)
    ), 2 * np.pi / frequency


def energies(scene: ls.Scene, period: float, periods: int) -> tuple[float, float]:
    """Returns swing and drift (see the top of this file) over `periods` periods of eight steps."""
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=period / 8), threads=1)
    kinetic, total = [], []
    for _ in range(8 * periods):
        sim.step()
        kinetic.append(sim.report.energy.body_kinetic)
        total.append(kinetic[-1] + sim.report.energy.magnetic)
    tenth, scale = len(total) // 10, max(kinetic)
    swing = np.abs(np.array(total) - total[0]).max() / scale
    return float(swing), float(abs(np.mean(total[-tenth:]) - np.mean(total[:tenth])) / scale)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--periods", type=int, default=10000)
    periods = parsed(parser, periods=10).periods
    for make in (compass, pair):
        start = time.process_time()
        swing, drift = energies(*make(), periods)
        print(
            f"{make.__name__:8} {periods} periods: swing {swing:.1e}, drift {drift:.1e}, "
            f"{time.process_time() - start:.1f} s"
        )


if __name__ == "__main__":
    main()
