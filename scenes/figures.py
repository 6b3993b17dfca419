"""A block magnet lifts four iron figures out of a tray of non-magnetic balls (figure 6.11 of
[Thomaszewski2010]).

The magnet comes down over the tray. One after another the figures jump to it out of the balls and
hang on it or on one another, by head or foot. The balls stay in the tray. Red is north and blue is
south. By default the magnetic charges on the figures' surfaces respond to one another. `-p
response=explicit` uses the dipole cells of the thesis instead, each of which is magnetised
independently. This takes less time.
"""

import loomstone as ls
import numpy as np

duration = 0.8
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.04, -0.15, 0.075), target=(0.0, 0.0, 0.024), field_of_view_degrees=32.0
    )
)

BLOCK = (0.04, 0.02, 0.01)
TRAY, WALL, RIM = (0.064, 0.044), 0.003, 0.012  # inner size, wall thickness and wall height [m]
BALL = 0.003
PROFILE = (
    (0.004, 0.0),
    (0.0018, 0.008),
    (0.0028, 0.0105),
    (0.0012, 0.0135),
)  # radius and height of each ring of a figure [m]
PLACES = ((-0.013, -0.006), (-0.012, 0.007), (0.012, -0.007), (0.013, 0.006))
HIGH, LOW = 0.060, 0.026  # heights of the magnet's centre [m]


def figure(sides: int = 8) -> ls.TriangleMesh:
    """Returns a figure like a pawn in chess. It has few vertices, so that its convex hull collides
    as a polyhedron.
    """
    angles = 2 * np.pi * np.arange(sides) / sides
    vertices = [(r * np.cos(a), r * np.sin(a), z) for r, z in PROFILE for a in angles]
    bottom, top, last = len(vertices), len(vertices) + 1, (len(PROFILE) - 1) * sides
    vertices += [(0, 0, PROFILE[0][1]), (0, 0, PROFILE[-1][1])]
    triangles = []
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [(bottom, j, i), (top, last + i, last + j)]
        for level in range(len(PROFILE) - 1):
            a, b = level * sides + i, level * sides + j
            triangles += [(a, b, b + sides), (a, b + sides, a + sides)]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def fill(balls: int) -> list[ls.RigidBody]:
    """Returns balls that fill the tray in layers, except where figures stand."""
    ball, bodies = ls.meshes.sphere(radius=BALL, subdivisions=2), []
    random, pitch = np.random.default_rng(4), 2.15 * BALL
    columns, rows = int(TRAY[0] / pitch), int(TRAY[1] / pitch)
    layer = 0
    while balls > 0:
        for place in np.ndindex(columns, rows):
            x, y = (
                np.array(place) - 0.5 * (np.array((columns, rows)) - 1)
            ) * pitch + random.uniform(-1e-4, 1e-4, 2)
            if (
                balls == 0
                or min(np.hypot(x - a, y - b) for a, b in PLACES) < PROFILE[0][0] + 1.1 * BALL
            ):
                continue
            at = (x, y, (1.05 + 2.1 * layer) * BALL)
            bodies.append(
                ls.RigidBody(
                    name=f"ball {balls}",
                    mesh=ball,
                    shape="sphere",
                    density=2500,
                    friction=0.3,
                    position=at,
                )
            )
            balls -= 1
        layer += 1
    return bodies


def walls() -> list[ls.Obstacle]:
    """Returns the walls of the tray."""
    return [
        ls.obstacles.box(
            name=f"wall {k + 1}", size=(*size, RIM), centre=(x, y, 0.5 * RIM), friction=0.3
        )
        for k, (size, x, y) in enumerate(
            (
                (sx, sy),
                side * 0.5 * (TRAY[0] + WALL) * along,
                side * 0.5 * (TRAY[1] + WALL) * (1 - along),
            )
            for along, sx, sy in ((1, WALL, TRAY[1] + 2 * WALL), (0, TRAY[0], WALL))
            for side in (-1, 1)
        )
    ]


def scene(
    figures: int = 4,
    balls: int = 90,
    response: str = "mutual",
    resolution: int = 64,
    polarization: float = 1.2,
) -> ls.Scene:
    """response: mutual | explicit, the way in which the figures are magnetised; polarization:
    polarization of the block magnet [T].

    resolution: least number of panels per figure if the response is mutual.
    """
    man = figure()
    volume = ls.meshes.mass_properties(man, 1.0).mass
    panels = resolution if response == "mutual" else 500
    iron = ls.magnetics.soft_mesh(man, susceptibility=500.0, panels=panels)
    density = 24 / volume if response == "explicit" else 0.0
    bodies = [
        ls.RigidBody(
            name=f"figure {i + 1}",
            mesh=man,
            shape="convex",
            density=7800,
            friction=0.4,
            position=(*PLACES[i], 1e-4),
        )
        for i in range(figures)
    ]
    magnets = [
        ls.Magnet(body=body.name, source=iron, response=response, density=density)
        for body in bodies
    ]
    times = [0.0, 0.05, 0.4, 0.5, 0.8]
    block = ls.obstacles.mesh(
        ls.meshes.box(size=BLOCK, cells_per_side=4),
        name="block",
        times=times,
        positions=[(0.0, 0.0, z) for z in (HIGH, HIGH, LOW, LOW, HIGH)],
        friction=0.5,
    )
    magnet = ls.magnetics.cuboid(size=BLOCK, polarization=(0, 0, polarization))
    magnets.append(ls.Magnet(body="block", source=magnet))
    return ls.Scene(
        bodies=[*bodies, *fill(balls)],
        magnets=magnets,
        obstacles=[block, *walls(), ls.floor(size=0.4)],
        magnetic_tolerance=1e-3,
        magnetic_step=1.0,
    )


def check(run: ls.Run) -> None:
    owner, names, last = (
        run.topology.body_of_vertex,
        run.topology.body_names,
        run[-1].body_vertices,
    )
    heights = {name: last[owner == b, 2].mean() for b, name in enumerate(names)}
    assert all(
        height > HIGH - 0.03 for name, height in heights.items() if name.startswith("figure")
    ), "all figures hang on the block"
    assert all(0 < height < 0.04 for name, height in heights.items() if name.startswith("ball")), (
        "all balls stay behind"
    )
