"""A loudspeaker: a voice coil with an alternating current, glued to a cloth membrane above a
magnet.

The coil and the membrane move up and down with the current, and waves run out to the rim. The
magnet below stands still. The cloth acts as the spring. Red is north and blue is south.
"""

from typing import Any

import loomstone as ls
import numpy as np

duration = 0.4
rate = 100.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.05, -0.15, -0.045), target=(0.0, 0.0, -0.006), field_of_view_degrees=38.0
    )
)

RIM = 0.05
MAGNET: dict[str, Any] = {"radius": 0.010, "height": 0.012}
COIL: dict[str, Any] = {"radius": 0.009, "length": 0.002, "turns": 60}
DISC = (0.010, 0.002)  # radius and height of the coil former [m]
ABOVE = 0.013  # height of the coil's centre above the magnet's face [m]
FREQUENCY = 20.0


def cylinder(radius: float, height: float, sides: int = 24) -> ls.TriangleMesh:
    angles = 2 * np.pi * np.arange(sides) / sides
    vertices = [
        (radius * np.cos(a), radius * np.sin(a), z)
        for z in (-0.5 * height, 0.5 * height)
        for a in angles
    ]
    vertices += [(0, 0, -0.5 * height), (0, 0, 0.5 * height)]
    triangles = []
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [
            (i, j, sides + j),
            (i, sides + j, sides + i),
            (2 * sides, j, i),
            (2 * sides + 1, sides + i, sides + j),
        ]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def scene(triangles: int = 2000, current: float = 0.06) -> ls.Scene:
    """current: amplitude of the current [A]."""
    membrane = ls.meshes.disc(radius=RIM, triangles=triangles).moved((0, 0, 0.5 * DISC[1] + 0.0006))
    x = np.asarray(membrane.vertices)
    r = np.linalg.norm(x[:, :2], axis=1)
    rubber = ls.ClothMaterial(
        weft_stiffness=300,
        warp_stiffness=300,
        shear_stiffness=100,
        density=0.3,
        bending_weft=2e-5,
        bending_warp=2e-5,
    )
    cloth = ls.Cloth(
        name="membrane", mesh=membrane, material=rubber, pins=np.flatnonzero(r > RIM - 1e-6)
    )
    body = ls.RigidBody(name="coil", mesh=cylinder(*DISC), density=1500)
    glued = ls.Attachment(cloth="membrane", body="coil", vertices=np.flatnonzero(r < DISC[0]))
    face = -ABOVE - 0.5 * MAGNET["height"]
    magnet = ls.obstacles.mesh(cylinder(**MAGNET).moved((0, 0, face)), name="magnet")
    times = np.linspace(0.0, duration, 801)
    currents = (
        current * np.sin(2 * np.pi * FREQUENCY * times) * np.clip(times * FREQUENCY / 2, 0, 1)
    )
    return ls.Scene(
        cloths=[cloth],
        bodies=[body],
        obstacles=[magnet],
        attachments=[glued],
        magnetic_tolerance=1e-3,
        magnets=[
            ls.Magnet(
                body="magnet",
                source=ls.magnetics.cylinder(**MAGNET, polarization=(0, 0, 1.2)).moved(
                    (0, 0, face)
                ),
            )
        ],
        coils=[
            ls.Coil(
                body="coil",
                source=ls.magnetics.solenoid(**COIL),
                times=times.tolist(),
                currents=currents.tolist(),
            )
        ],
    )


def check(run: ls.Run) -> None:
    owner = run.topology.body_of_vertex
    heights = np.array([frame.body_vertices[owner == 0, 2].mean() for frame in run])
    assert np.ptp(heights) > 5e-4, "the coil swings"
    assert heights.min() > -0.5 * ABOVE, "and does not touch the magnet"
