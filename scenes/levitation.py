"""A superconductor floats over a magnetised ring (example 6.5 of [Thomaszewski2010]).

The superconductor is a ball or, with `shape="cube"`, the cube of the thesis. It is released
beside and above its equilibrium and oscillates about this point without touching the ring. The
magnetic force drives it towards a point on the axis where the field vanishes. The cube also turns.
With `material="magnet"`, a permanent magnet replaces the superconductor, and falls or flips. Red is
north and blue is south.
"""

from typing import Any

import loomstone as ls
import numpy as np

duration = 2.0
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.05, -0.08, 0.05), target=(0.0, 0.0, 0.008), field_of_view_degrees=34.0
    )
)

RING: dict[str, Any] = {"radius": 0.02, "inner_radius": 0.011, "height": 0.006}
BALL = 0.003


def ring_mesh(sides: int = 64) -> ls.TriangleMesh:
    half = 0.5 * RING["height"]
    angles = 2 * np.pi * np.arange(sides) / sides
    profile = [
        (RING["inner_radius"], -half),
        (RING["radius"], -half),
        (RING["radius"], half),
        (RING["inner_radius"], half),
    ]
    vertices = [(r * np.cos(a), r * np.sin(a), z) for r, z in profile for a in angles]
    triangles = []
    for k in range(4):
        for i in range(sides):
            j = (i + 1) % sides
            a, b, c, d = (
                k * sides + i,
                k * sides + j,
                (k + 1) % 4 * sides + i,
                (k + 1) % 4 * sides + j,
            )
            triangles += [(a, b, d), (a, d, c)]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def balance(material: str = "superconductor", density: float = 6000.0) -> float:
    """Returns the height above the centre of the ring [m] at which a ball on the axis of the ring
    is in equilibrium and stable along the axis. Only heights above 4 mm count; if there are
    several, returns the lowest.
    """
    ring = ls.magnetics.cylinder(**RING, polarization=(0, 0, 1.2))
    z = np.linspace(0.004, 0.03, 2000)
    axis = np.stack([0 * z, 0 * z, z], axis=1)
    field, slope = ls.magnetics.field(ring, axis)[:, 2], ls.magnetics.gradient(ring, axis)[:, 2, 2]
    volume = 4 / 3 * np.pi * BALL**3
    moment = (
        -1.5 * volume * field if material == "superconductor" else 0.05 * volume + 0 * z
    )  # mu0 times the dipole moment [T m^3]
    force = moment / ls.magnetics.MU0 * slope - density * volume * 9.81
    crossings = np.flatnonzero((force[:-1] > 0) & (force[1:] <= 0))
    return float(z[crossings[0]])


def scene(material: str = "superconductor", shape: str = "ball") -> ls.Scene:
    """material: superconductor | magnet (polarization 0.05 T, parallel to that of the ring);
    shape: ball | cube (of the volume of the ball, slightly rotated).
    """
    if shape not in ("ball", "cube") or material not in ("superconductor", "magnet"):
        raise ls.InvalidInput(
            f"material must be superconductor or magnet and shape ball or cube, got {material!r}"
            f" and {shape!r}"
        )
    polarization = (0, 0, 0.05)
    place = np.array((0.0, 0.0, balance(material)))
    ring = ls.obstacles.mesh(ring_mesh(), name="ring")
    start = place + ((0.001, 0.0005, 0.001) if material == "superconductor" else (1e-5, 0.0, 0.0))
    if shape == "ball":
        mesh = ls.meshes.sphere(radius=BALL, subdivisions=3)
        body = ls.RigidBody(
            name="floating", mesh=mesh, shape="sphere", density=6000, position=start
        )
        source: ls.magnetics.MagneticBody | ls.magnetics.SoftBody = (
            ls.magnetics.soft_sphere(radius=BALL, susceptibility=-1.0, degree=1)
            if material == "superconductor"
            else ls.magnetics.sphere(radius=BALL, polarization=polarization)
        )
    else:
        size = (BALL * (4 / 3 * np.pi) ** (1 / 3),) * 3
        askew = (np.cos(0.1), 0.0, np.sin(0.1), 0.0)
        body = ls.RigidBody(
            name="floating",
            mesh=ls.meshes.box(size=size),
            shape="box",
            density=6000,
            position=start,
            orientation=askew,
        )
        source = (
            ls.magnetics.soft_cuboid(size=size, susceptibility=-1.0, cells=8)
            if material == "superconductor"
            else ls.magnetics.cuboid(size=size, polarization=polarization)
        )
    below = ls.magnetics.cylinder(**RING, polarization=(0, 0, 1.2))
    return ls.Scene(
        bodies=[body],
        obstacles=[ring, ls.floor(height=-0.003, size=0.2)],
        magnets=[ls.Magnet(body="floating", source=source), ls.Magnet(body="ring", source=below)],
    )


def check(run: ls.Run) -> None:
    floating = np.array(
        [frame.body_vertices[run.topology.body_of_vertex == 0].mean(axis=0) for frame in run]
    )
    away = np.linalg.norm(floating - (0.0, 0.0, balance()), axis=1)
    assert away.max() < 0.004, "it swings about its place"
