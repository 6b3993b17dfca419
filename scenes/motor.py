"""A brushed motor: a coil between two poles, with a commutator that reverses the coil's current
every half turn.

The rotor starts from rest and speeds up until its back-EMF leaves only the current that friction
and load require. Red is north and blue is south. `python scenes/motor.py` prints speed, current and
efficiency as functions of the load.
"""

from typing import Any

import loomstone as ls
import numpy as np

duration = 0.5
rate = 100.0
integrator = ls.SemiImplicitEuler(step=5e-4)
render = ls.RenderOptions(
    field_lines=80,
    camera=ls.Camera(
        fit=False, eye=(0.06, -0.12, 0.11), target=(0.0, 0.0, 0.0), field_of_view_degrees=36.0
    ),
)

POLE, GAP = (0.012, 0.03, 0.03), 0.04  # size of each pole magnet, gap between them [m]
ROTOR = (0.026, 0.008, 0.02)  # size of the block [m]; the coil's axis is parallel to its short side
WINDING: dict[str, Any] = {"radius": 0.008, "length": 0.006, "turns": 150}
RESISTANCE, INDUCTANCE, FRICTION = 2.0, 5e-4, 2e-6


def scene(
    voltage: float = 3.0, load: float = 0.0, polarization: float = 1.2, density: float = 3000.0
) -> ls.Scene:
    """voltage: that of the source [V]; load: torque that opposes the rotation [N m]; polarization:
    that of the poles [T]; density: that of the rotor [kg/m^3].
    """
    poles = [
        ls.obstacles.mesh(
            ls.meshes.box(size=POLE).moved((side * 0.5 * (GAP + POLE[0]), 0, 0)), name=name
        )
        for side, name in ((-1, "left pole"), (1, "right pole"))
    ]
    pole = ls.magnetics.cuboid(size=POLE, polarization=(polarization, 0, 0))
    magnets = [
        ls.Magnet(body=name, source=pole.moved((side * 0.5 * (GAP + POLE[0]), 0, 0)))
        for side, name in ((-1, "left pole"), (1, "right pole"))
    ]
    turned = (np.cos(0.3), 0, 0, np.sin(0.3))
    rotor = ls.RigidBody(
        name="rotor",
        mesh=ls.meshes.box(size=ROTOR),
        shape="box",
        density=density,
        orientation=turned,
    )
    to_y = (np.sqrt(0.5), -np.sqrt(0.5), 0, 0)  # rotates the coil's z axis to the rotor's y axis
    # The torque on a magnetic moment at an angle a to the field, which is along x, is proportional
    # to -sin a. It keeps its sign if the current is reversed when the moment crosses the x axis.
    coil = ls.Coil(
        body="rotor",
        source=ls.magnetics.solenoid(**WINDING).at((0, 0, 0), to_y),
        resistance=RESISTANCE,
        inductance=INDUCTANCE,
        voltages=[voltage],
        commutator=(0, -1, 0),
    )
    bearing = ls.Bearing(body="rotor", axis=(0, 0, 1), friction=FRICTION, torque=-load)
    return ls.Scene(
        bodies=[rotor],
        obstacles=poles,
        magnets=magnets,
        coils=[coil],
        bearings=[bearing],
        magnetic_tolerance=1e-3,
    )


def speed_at(load: float, *, time: float = 1.5, step: float = 5e-4) -> tuple[float, float, float]:
    """Returns the speed [rad/s], root-mean-square current [A] and efficiency [1] with a load [N m],
    measured over the last fifth of a run.
    """
    sim = ls.Simulation(scene(load=load), integrator=ls.SemiImplicitEuler(step=step), threads=1)
    n = round(time / step)
    angle, supply, heat = 0.0, 0.0, 0.0
    for i in range(n):
        if i == 4 * n // 5:
            supply, heat = sim.circuit_supply, sim.circuit_heat
        sim.step()
        if i >= 4 * n // 5:
            angle += step * sim.state.body_angular_velocities[0, 2]
    span = step * (n - 4 * n // 5)
    given = sim.circuit_supply - supply
    return (
        angle / span,
        np.sqrt((sim.circuit_heat - heat) / (RESISTANCE * span)),
        load * angle / given,
    )


def check(run: ls.Run) -> None:
    last = run[-1].report
    assert last.energy.body_kinetic > 100 * run[1].report.energy.body_kinetic, (
        "the rotor has come up to speed"
    )


if __name__ == "__main__":
    for torque in np.linspace(0.0, 1.6e-3, 5):
        print(
            "load {:.4f} N m: {:.1f} rad/s, {:.3f} A, efficiency {:.2f}".format(
                torque, *speed_at(torque)
            )
        )
