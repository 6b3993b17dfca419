"""A permanent magnet lifts soft iron balls out of a bowl (example 6.2 of [Thomaszewski2010]).

The magnet comes down. Five balls jump to it and to one another, and hang below it when it rises
again. One of the five touches the magnet, and the other four hang on balls. Two balls are too far
away and stay in the bowl. Red is north and blue is south.
"""

from typing import Any

import loomstone as ls
import numpy as np

duration = 2.4
rate = 25.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.03, -0.17, 0.10), target=(0.0, 0.0, 0.028), field_of_view_degrees=34.0
    )
)

BOWL, DEPTH, WALL = 0.035, 0.02, 0.004  # rim radius, inner depth and wall thickness [m]
BALL = 0.004
MAGNET: dict[str, Any] = {"radius": 0.004, "height": 0.02}
LOW, HIGH = 0.0235, 0.065  # heights of the magnet's centre [m]
TIMES = [0.0, 0.5, 1.1, 1.3, 2.4]


def bowl(segments: int = 48, rings: int = 10) -> ls.TriangleMesh:
    """Returns a closed shell between two paraboloids. Its lowest inner point is the origin."""
    radii = BOWL * np.arange(rings + 1) / rings
    profile = [(r, DEPTH * (r / BOWL) ** 2) for r in radii] + [
        (r, DEPTH * (r / BOWL) ** 2 - WALL) for r in radii[::-1]
    ]
    vertices: list[tuple[float, float, float]] = []
    rows = []
    for r, z in profile:
        count = segments if r > 0 else 1
        rows.append(range(len(vertices), len(vertices) + count))
        angles = 2 * np.pi * np.arange(count) / count
        vertices += [(r * np.cos(a), r * np.sin(a), z) for a in angles]
    triangles = []
    for low, high in zip(rows, rows[1:], strict=False):
        for i in range(segments):
            a, b = low[i % len(low)], low[(i + 1) % len(low)]
            c, d = high[i % len(high)], high[(i + 1) % len(high)]
            triangles += [t for t in ((a, c, d), (a, d, b)) if len(set(t)) == 3]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def scene(spheres: int = 7, polarization: float = 0.66) -> ls.Scene:
    """polarization: polarization of the magnet [T]."""
    ball = ls.meshes.sphere(radius=BALL, subdivisions=2)
    turn = 2.399963  # golden angle [rad], which spreads the balls evenly
    bodies = []
    for i in range(spheres):
        r = 2.1 * BALL * np.sqrt(i)
        x, y = r * np.cos(turn * i), r * np.sin(turn * i)
        height = DEPTH * (r / BOWL) ** 2 + 1.3 * BALL
        bodies.append(
            ls.RigidBody(
                name=f"ball {i + 1}",
                mesh=ball,
                shape="sphere",
                density=7800,
                position=(x, y, height),
                friction=0.4,
            )
        )
    heights = [HIGH, HIGH, LOW, LOW, HIGH]
    rod = ls.meshes.cylinder(radius=MAGNET["radius"], length=MAGNET["height"])
    carried = ls.obstacles.mesh(
        rod, name="magnet", times=TIMES, positions=[(0.0, 0.0, z) for z in heights], friction=0.4
    )
    magnet = ls.magnetics.cylinder(**MAGNET, polarization=(0, 0, polarization))
    iron = ls.magnetics.soft_sphere(radius=BALL, susceptibility=1000.0, degree=1)
    magnets = [ls.Magnet(body="magnet", source=magnet)]
    magnets += [ls.Magnet(body=body.name, source=iron) for body in bodies]
    shell = ls.obstacles.mesh(bowl(), name="bowl", friction=0.3)
    table = ls.floor(height=-WALL, size=0.3)
    return ls.Scene(
        bodies=bodies, magnets=magnets, obstacles=[carried, shell, table], magnetic_tolerance=1e-3
    )


def check(run: ls.Run) -> None:
    last, owner = run[-1], run.topology.body_of_vertex
    n_balls = len(run.topology.body_names) - 3
    heights = np.array([last.body_vertices[owner == b, 2].mean() for b in range(n_balls)])
    lifted = heights > 0.02
    assert lifted.sum() >= min(3, n_balls), "the magnet lifts several"
    assert n_balls != 7 or lifted.sum() == 5, "five of seven"
    assert heights.min() > 0.0, "nothing falls through the bowl"
