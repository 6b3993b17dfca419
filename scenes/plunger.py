"""An iron bar is pulled into a coil when the voltage is switched on, oscillates there, and drops
when the voltage is switched off.

The current dips while the bar enters, because the iron increases the flux through the coil. Red is
north and blue is south. The lines are magnetic field lines.
"""

from typing import Any

import loomstone as ls
import numpy as np

duration = 0.5
rate = 100.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.06, -0.20, 0.085), target=(0.0, 0.0, 0.035), field_of_view_degrees=32.0
    ),
    field_lines=60,
)

BAR = (0.008, 0.008, 0.03)
COIL: dict[str, Any] = {"radius": 0.012, "length": 0.03, "turns": 400}
HEIGHT = 0.036  # height of the coil's centre above the floor [m]
FORMER = (0.0068, 0.0115)  # inner and outer radius of the tube that carries the coil [m]
ON, OFF = 0.04, 0.34  # times at which the voltage is switched on and off [s]


def tube(inner: float, outer: float, length: float, sides: int = 32) -> ls.TriangleMesh:
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(sides)], axis=1)
    rings = [
        radius * ring + (0, 0, z)
        for radius, z in (
            (outer, -0.5 * length),
            (outer, 0.5 * length),
            (inner, 0.5 * length),
            (inner, -0.5 * length),
        )
    ]
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    triangles = []
    for k in range(4):
        a, b = k * sides, (k + 1) % 4 * sides
        triangles += [
            np.stack([a + i, a + j, b + j], axis=1),
            np.stack([a + i, b + j, b + i], axis=1),
        ]
    return ls.TriangleMesh(np.vstack(rings), np.vstack(triangles))


def scene(voltage: float = 18.0) -> ls.Scene:
    """voltage: voltage of the source while it is switched on [V]."""
    bar = ls.RigidBody(
        name="bar",
        mesh=ls.meshes.box(size=BAR),
        shape="box",
        density=7800,
        friction=0.1,
        position=(0, 0, 0.5 * BAR[2] + 1e-4),
    )
    former = ls.obstacles.mesh(
        tube(*FORMER, COIL["length"]).moved((0, 0, HEIGHT)), name="former", friction=0.1
    )
    on: dict[str, Any] = {
        "times": [0.0, ON, ON + 1e-3, OFF, OFF + 1e-3],
        "voltages": [0.0, 0.0, voltage, voltage, 0.0],
    }
    winding = ls.magnetics.solenoid(**COIL).moved((0, 0, HEIGHT))
    coil = ls.Coil(body="former", source=winding, resistance=6.0, inductance=2.5e-3, **on)
    iron = ls.magnetics.soft_cuboid(size=BAR, susceptibility=1000.0, cells=8)
    return ls.Scene(
        bodies=[bar],
        obstacles=[former, ls.floor(size=0.2)],
        magnets=[ls.Magnet(body="bar", source=iron)],
        coils=[coil],
        magnetic_tolerance=1e-3,
    )


def check(run: ls.Run) -> None:
    bar = run.topology.body_of_vertex == run.topology.body_names.index("bar")
    heights = np.array([frame.body_vertices[bar, 2].mean() for frame in run])
    times = np.array([frame.time for frame in run])
    current = np.array([frame.coil_currents[0] for frame in run])
    assert np.abs(heights[times < ON] - 0.5 * BAR[2]).max() < 5e-4, "it stands on the floor"
    assert heights.max() > HEIGHT, "leaps through the middle of the coil"
    assert heights[(times > ON + 0.02) & (times < OFF)].mean() > 0.5 * (0.5 * BAR[2] + HEIGHT), (
        "swings about it"
    )
    assert heights[-1] < 0.6 * BAR[2], "and falls back"
    assert current.max() == current[times < OFF + 0.02].max() > 2.0, "while a current flows"
