"""Two toy magnets and a steel ball, figure 6.1: plastic rods with a magnet in each end, lying side by side on a table.

See: a soft ball is drawn to the end of the first rod. Antiparallel, the rods roll towards each other and snap together along
their sides. Parallel, the second rod is repelled until it has turned: over the barrier, it is caught by the other end.
Red is north, blue south.
"""

import numpy as np

import loomstone as ls

duration = 1.0
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(camera=ls.Camera(fit=False, eye=(0.02, -0.10, 0.09), target=(0.0, 0.0, 0.0), field_of_view_degrees=40.0))

LENGTH, RADIUS = 0.027, 0.004          # of a rod
DEEP = 0.0005                          # plastic over the magnet's end
MAGNET = {"radius": 0.003, "height": 0.006}
BALL = 0.00635


def rod_mesh() -> ls.TriangleMesh:
    """Cylinder along z with rings where its magnets begin, so that the ends alone are coloured."""
    sides, half = 14, 0.5 * LENGTH  # few enough to collide as a polyhedron
    inner = half - DEEP - MAGNET["height"]
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = RADIUS * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    heights = [-half, -inner - 2e-4, -inner + 1e-3, inner - 1e-3, inner + 2e-4, half]
    vertices = [(x, y, z) for z in heights for x, y in ring] + [(0, 0, -half), (0, 0, half)]
    triangles = []
    for level in range(len(heights) - 1):
        for i in range(sides):
            a, b = level * sides + i, level * sides + (i + 1) % sides
            triangles += [(a, b, b + sides), (a, b + sides, a + sides)]
    low, high, top = len(vertices) - 2, len(vertices) - 1, (len(heights) - 1) * sides
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [(low, j, i), (high, top + i, top + j)]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def scene(parallel: bool = True, polarization: float = 1.1) -> ls.Scene:
    """parallel: the moments of the rods point the same way; polarization: of their magnets [T]."""
    mesh = rod_mesh()
    s = np.sqrt(0.5)
    along_y = np.array((s, -s, 0.0, 0.0))  # takes z to y
    turned = along_y if parallel else np.array((s, s, 0.0, 0.0))  # takes z to -y
    # A little askew, as things on a table are.
    askew = np.array((np.cos(0.05), 0.0, 0.0, np.sin(0.05)))
    w, x, y, z = askew
    matrix = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    rods = [
        ls.RigidBody(name="first", mesh=mesh, density=1800, position=(-0.011, 0.0, 1.05 * RADIUS), orientation=along_y, friction=0.3),
        ls.RigidBody(name="second", mesh=mesh, density=1800, position=(0.011, 0.002, 1.05 * RADIUS), orientation=matrix @ turned, friction=0.3),
    ]
    ball = ls.RigidBody(
        name="ball", mesh=ls.meshes.sphere(radius=BALL, subdivisions=3), shape="sphere", density=7800,
        position=(-0.013, 0.5 * LENGTH + BALL + 0.004, BALL),
    )
    at = 0.5 * LENGTH - DEEP - 0.5 * MAGNET["height"]
    magnets = [
        ls.Magnet(body=name, shape="cylinder", **MAGNET, position=(0, 0, end), polarization=(0, 0, polarization))
        for name in ("first", "second")
        for end in (-at, at)
    ]
    magnets.append(ls.Magnet(body="ball", shape="sphere", radius=BALL, susceptibility=1000.0))
    return ls.Scene(bodies=[*rods, ball], magnets=magnets, obstacles=[ls.floor(size=0.3)], magnetic_tolerance=1e-3)


def check(run: ls.Run) -> None:
    last = run[-1]
    bodies = [last.body_positions[run.topology.body_of_vertex == b] for b in range(3)]
    near = [np.linalg.norm(a[:, None] - b[None], axis=2).min() for a, b in ((bodies[0], bodies[1]), (bodies[0], bodies[2]))]
    assert near[0] < 2e-3, "the rods have found each other"
    assert near[1] < 2e-3 or np.linalg.norm(bodies[1][:, None] - bodies[2][None], axis=2).min() < 2e-3, "the ball sticks to one of them"
    assert min(b[:, 2].min() for b in bodies) > -5e-4, "nothing sinks into the table"
