"""Iron balls fall on a magnetised dragon (example 6.3 of [Thomaszewski2010], figure 6.10).

Many balls stick to the serpentine dragon and to one another. The others fall to the floor. Red is
north and blue is south. `-p mesh=FILE` uses any closed mesh as the dragon. `-p cells=N` replaces
the dragon's exact field by that of about N dipole cells; the thesis uses 1824 and 3628.
"""

from pathlib import Path

import loomstone as ls
import numpy as np

duration = 1.5
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.13, -0.30, 0.19), target=(0.0, 0.0, 0.035), field_of_view_degrees=32.0
    )
)

SIZE, BALL = 0.14, 0.005


def serpent(segments: int = 90, sides: int = 10) -> ls.TriangleMesh:
    """A tube along a rising spiral, thick in the middle, with a raised head."""
    t = np.linspace(0.0, 1.0, segments + 1)
    turn = 3.6 * np.pi * t
    wide = 0.34 * (1 - 0.45 * t)
    curve = np.stack([wide * np.cos(turn), wide * np.sin(turn), 0.09 + 0.42 * t**1.5], axis=1)
    thick = (
        0.02
        + 0.06 * np.sin(np.pi * np.clip(t, 0.02, 0.98)) ** 0.6
        + 0.05 * np.exp(-(((t - 0.95) / 0.035) ** 2))
    )
    tangent = np.gradient(curve, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    aside = np.cross(tangent, (0, 0, 1.0))
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    up = np.cross(aside, tangent)
    angles = 2 * np.pi * np.arange(sides) / sides
    rings = curve[:, None] + thick[:, None, None] * (
        np.cos(angles)[None, :, None] * aside[:, None] + np.sin(angles)[None, :, None] * up[:, None]
    )
    vertices = np.vstack([rings.reshape(-1, 3), curve[:1], curve[-1:]])
    triangles, last = [], segments * sides
    for k in range(segments):
        for i in range(sides):
            a, b = k * sides + i, k * sides + (i + 1) % sides
            triangles += [(a, b + sides, b), (a, a + sides, b + sides)]
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [(len(vertices) - 2, i, j), (len(vertices) - 1, last + j, last + i)]
    return ls.TriangleMesh(vertices, np.array(triangles))


def scene(
    spheres: int = 250, cells: int = 0, mesh: str = "", polarization: float = 0.6
) -> ls.Scene:
    """cells: approximate number of dipoles that represent the dragon (0: exact field); mesh: file
    with a closed mesh to use as the dragon; polarization: that of the dragon [T].
    """
    figure = ls.meshes.read(Path(mesh), with_uv=False) if mesh else serpent()
    x = np.asarray(figure.vertices)
    low, high = x.min(axis=0), x.max(axis=0)
    scale = SIZE / (high - low).max()
    figure = figure.moved(
        -scale * np.array([*(0.5 * (low + high))[:2], low[2]]) + (0, 0, 1e-4), scale=scale
    )
    carrier = ls.obstacles.mesh(figure, name="dragon", friction=0.6)
    magnet = ls.magnetics.mesh(figure, polarization=(0, 0, polarization))
    if cells:
        density = cells / ls.meshes.mass_properties(figure, 1.0).mass
        magnet = ls.magnetics.cells(magnet, density=density)
    magnets = [ls.Magnet(body="dragon", source=magnet)]
    iron = ls.magnetics.soft_sphere(radius=BALL, susceptibility=1000.0, degree=1)
    ball = ls.meshes.sphere(radius=BALL, subdivisions=2)
    random = np.random.default_rng(6)
    bodies = []
    for i in range(spheres):
        layer, place = divmod(i, 16)
        x, y = (np.array(divmod(place, 4)) - 1.5) * 0.022 + random.uniform(-0.003, 0.003, 2)
        bodies.append(
            ls.RigidBody(
                name=f"ball {i + 1}",
                mesh=ball,
                shape="sphere",
                density=7800,
                friction=0.5,
                position=(x, y, 0.12 + 0.016 * layer),
            )
        )
        magnets.append(ls.Magnet(body=f"ball {i + 1}", source=iron))
    return ls.Scene(
        bodies=bodies,
        magnets=magnets,
        obstacles=[carrier, ls.floor(size=1.0)],
        magnetic_tolerance=1e-3,
        magnetic_step=1.0,
        rigid_iterations=10,
    )


def check(run: ls.Run) -> None:
    owner, last = run.topology.body_of_vertex, run[-1].body_vertices
    n = sum(name.startswith("ball") for name in run.topology.body_names)
    centres = np.array([last[owner == b].mean(axis=0) for b in range(n)])
    assert (centres[:, 2] > 0.5 * BALL).all(), "nothing falls through the floor"
    resting = (centres[:, 2] > 2.0 * BALL) & (np.linalg.norm(centres[:, :2], axis=1) < 0.8 * SIZE)
    assert resting.sum() >= 0.2 * n, "many stick to the dragon"
