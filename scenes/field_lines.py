"""Field lines of two magnets: a horseshoe attracts a moving bar (figure 6.13 of
[Thomaszewski2010], in motion).

Lines run from red north poles to blue south poles, and each carries the same share of the flux.
The bar flies to the pole that attracts it, snaps on and stands up. Lines then run between the far
end of the bar and the other pole. There is no gravity.
"""

import loomstone as ls
import numpy as np

duration = 0.1
rate = 250.0
integrator = ls.SemiImplicitEuler(step=5e-4)
render = ls.RenderOptions(
    field_lines=160,
    camera=ls.Camera(
        fit=False, eye=(0.05, -0.21, 0.07), target=(0.0, 0.0, 0.012), field_of_view_degrees=34.0
    ),
)

WIDE, LEG, THICK = 0.008, 0.03, 0.008  # width, length and thickness of the horseshoe's legs [m]
GAP = 0.03  # distance between the centre lines of the legs [m]
BAR = (0.02, 0.006, 0.006)


def horseshoe(bends: int = 16) -> ls.TriangleMesh:
    """Returns a horseshoe: two legs joined by half a ring, symmetric about the plane y = 0."""
    angles = np.linspace(0.0, np.pi, bends + 1)
    arc = np.stack([np.cos(angles), -np.sin(angles)], axis=1)
    half = 0.5 * WIDE
    outer = np.vstack([[0.5 * GAP + half, LEG], (0.5 * GAP + half) * arc, [-0.5 * GAP - half, LEG]])
    inner = np.vstack([[0.5 * GAP - half, LEG], (0.5 * GAP - half) * arc, [-0.5 * GAP + half, LEG]])
    n = len(outer)
    rows = [
        np.insert(line, 1, y, axis=1)
        for line, y in ((outer, -0.5), (inner, -0.5), (inner, 0.5), (outer, 0.5))
    ]
    vertices = np.vstack([row * (1.0, THICK, 1.0) for row in rows])
    triangles = []
    for side in range(4):
        a, b = side * n, (side + 1) % 4 * n
        for i in range(n - 1):
            triangles += [(a + i, a + i + 1, b + i + 1), (a + i, b + i + 1, b + i)]
    for i in (0, n - 1):
        a, b, c, d = i, n + i, 2 * n + i, 3 * n + i
        triangles += [(a, b, c), (a, c, d)] if i == 0 else [(c, b, a), (d, c, a)]
    return ls.TriangleMesh(vertices, np.array(triangles))


def scene(polarization: float = 1.0) -> ls.Scene:
    """polarization: that of both magnets [T]."""
    magnets = []
    for x in (-0.5 * GAP, 0.5 * GAP):
        along = (0, 0, np.sign(x) * polarization)
        leg = ls.magnetics.cuboid(size=(WIDE, THICK, LEG), polarization=along)
        magnets.append(ls.Magnet(body="horseshoe", source=leg.moved((x, 0, 0.5 * LEG))))
    magnet = ls.magnetics.cuboid(size=BAR, polarization=(polarization, 0, 0))
    magnets.append(ls.Magnet(body="bar", source=magnet))
    turned = (np.cos(0.6), 0.0, np.sin(0.6), 0.0)
    bar = ls.RigidBody(
        name="bar",
        mesh=ls.meshes.box(size=BAR),
        shape="box",
        density=7500,
        position=(0, 0, 0.05),
        orientation=turned,
    )
    arch = ls.obstacles.mesh(horseshoe(), name="horseshoe")
    return ls.Scene(
        bodies=[bar], obstacles=[arch], magnets=magnets, gravity=(0, 0, 0), magnetic_tolerance=1e-3
    )


def check(run: ls.Run) -> None:
    owner = run.topology.body_of_vertex
    bar = run[-1].body_vertices[owner == 0]
    assert bar.mean(axis=0)[2] < 0.045, "the bar is drawn to the horseshoe"
