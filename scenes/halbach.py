"""A Halbach array: a row of cubes whose magnetisation turns by 90 degrees from one cube to the
next, so that the field is strong on one side of the row and weak on the other.

Field lines are dense above the array and sparse below it. Two equal small magnets are released at
the same distance above and below the array. The upper one turns and is pulled in before the lower
one. There is no gravity. Red is north and blue is south.
"""

import loomstone as ls
import numpy as np

duration = 0.06
rate = 250.0
integrator = ls.SemiImplicitEuler(step=5e-4)
render = ls.RenderOptions(
    field_lines=160,
    camera=ls.Camera(
        fit=False, eye=(0.025, -0.16, 0.035), target=(0.0, 0.0, 0.0), field_of_view_degrees=34.0
    ),
)

CUBE, BALL = 0.01, 0.003
DISTANCE = 0.016  # vertical distance of each ball's centre from the centre of the array [m]


def directions(n: int) -> np.ndarray:
    """Returns the directions of magnetisation: unit vectors (n x 3) that turn counter-clockwise
    from cube to cube, as seen from -y. The strong side is +z.
    """
    angles = 0.5 * np.pi * (np.arange(n) - n // 2 + 1)
    return np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1).round(12)


def array(n: int, polarization: float) -> list[ls.magnetics.MagneticBody]:
    places = (np.arange(n) - 0.5 * (n - 1)) * CUBE
    return [
        ls.magnetics.cuboid(size=(CUBE, CUBE, CUBE), polarization=polarization * d).moved((x, 0, 0))
        for x, d in zip(places, directions(n), strict=True)
    ]


def scene(cubes: int = 7, polarization: float = 1.2) -> ls.Scene:
    """cubes: number of cubes in the row; polarization: that of each cube [T]."""
    cube = ls.meshes.box(size=(0.98 * CUBE, 0.98 * CUBE, 0.98 * CUBE), cells_per_side=8)
    held, magnets = [], []
    for i, source in enumerate(array(cubes, polarization)):
        name = f"cube {i + 1}"
        held.append(ls.obstacles.mesh(cube.moved(source.position), name=name))
        magnets.append(ls.Magnet(body=name, source=source))
    ball = ls.meshes.sphere(radius=BALL, subdivisions=3)
    bodies = [
        ls.RigidBody(
            name=name,
            mesh=ball,
            shape="sphere",
            density=7500,
            position=(0.0, 0, side * DISTANCE),
            orientation=(0.8, 0, 0.6, 0),
        )
        for name, side in (("above", 1), ("below", -1))
    ]
    magnet = ls.magnetics.sphere(radius=BALL, polarization=(0, 0, 0.3))
    magnets += [ls.Magnet(body=body.name, source=magnet) for body in bodies]
    return ls.Scene(
        bodies=bodies, obstacles=held, magnets=magnets, gravity=(0, 0, 0), magnetic_tolerance=1e-3
    )


def strengths(cubes: int = 7) -> tuple[float, float]:
    """Returns the mean |B| [T] over the middle third of the array, at the height of the upper small
    magnet and at that of the lower one.
    """
    sources = array(cubes, 1.2)
    x = np.linspace(-cubes * CUBE / 6, cubes * CUBE / 6, 41)
    sides = [np.stack([x, 0 * x, 0 * x + side * DISTANCE], axis=1) for side in (1, -1)]
    above, below = (
        float(np.linalg.norm(ls.magnetics.field(sources, points), axis=1).mean())
        for points in sides
    )
    return above, below


def check(run: ls.Run) -> None:
    above, below = strengths()
    assert above > 3 * below, "one side is strong"
    owner = run.topology.body_of_vertex
    heights = np.array(
        [[abs(frame.body_vertices[owner == b, 2].mean()) for b in range(2)] for frame in run]
    )
    near = heights < 0.5 * (0.5 * CUBE + BALL + DISTANCE)
    assert near[:, 0].any(), "and takes the ball"
    assert not near[:, 1].any() or near[:, 0].argmax() < near[:, 1].argmax(), (
        "before the weak one takes the other"
    )
