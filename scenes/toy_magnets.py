"""Two toy magnets and a steel ball (figures 6.1 and 6.8 of [Thomaszewski2010]). The toys are
plastic rods on a table, with a magnet in each end.

One rod is held, with the ball at its end, and the other rod approaches. In the antiparallel case
the other rod is repelled until a sliding block has pushed it close enough. The unevenly magnetised
ball then attracts the other rod more strongly than the held rod repels it, and the other rod jumps
ahead of the block. In the parallel case the other rod is attracted from a distance and snaps to the
ball. In the free case the other rod is antiparallel and unguided: it moves away, turns round and
snaps on with its far end. Red is north and blue is south.
"""

from typing import Any

import loomstone as ls
import numpy as np

duration = 0.9
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False,
        eye=(-0.012, -0.085, 0.085),
        target=(-0.010, 0.0, 0.0),
        field_of_view_degrees=31.0,
    )
)

LENGTH, RADIUS, SIDES = 0.027, 0.004, 14  # length and radius of a rod [m], number of sides
DEEP = 0.0005  # thickness of the plastic over the magnet's end [m]
MAGNET: dict[str, Any] = {"radius": 0.003, "height": 0.006}
BALL = 0.005
GAP = {"parallel": 0.018, "antiparallel": 0.009, "free": 0.011}
ASKEW = {"parallel": 0.05, "antiparallel": 0.0, "free": 0.7}  # initial misalignment [rad]
PUSHED = (0.1, 0.6)  # start and end of the push [s]; its path is the gap less 1 mm


def rod_mesh() -> ls.TriangleMesh:
    """Returns a prism along x that lies on one of its faces. Rings of vertices at the inner ends of
    the magnets confine the colours of the poles to the ends of the rod.
    """
    half = 0.5 * LENGTH
    inner = half - DEEP - MAGNET["height"]
    angles = 2 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    ring = RADIUS * np.stack([np.sin(angles), -np.cos(angles)], axis=1)
    places = [-half, -inner - 2e-4, -inner + 1e-3, inner - 1e-3, inner + 2e-4, half]
    vertices = [(x, y, z) for x in places for y, z in ring] + [(-half, 0, 0), (half, 0, 0)]
    triangles = []
    for level in range(len(places) - 1):
        for i in range(SIDES):
            a, b = level * SIDES + i, level * SIDES + (i + 1) % SIDES
            triangles += [(a, b, b + SIDES), (a, b + SIDES, a + SIDES)]
    low, high, top = len(vertices) - 2, len(vertices) - 1, (len(places) - 1) * SIDES
    for i in range(SIDES):
        j = (i + 1) % SIDES
        triangles += [(low, j, i), (high, top + i, top + j)]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def rails_and_slide(start: float, path: float) -> list[ls.Obstacle]:
    """Returns rails on both sides of a rod whose centre is at x = `start` [m], and a sliding block
    at the end of the rod towards -x. The block advances by `path` [m] along +x.
    """
    size, beside = (0.055, 0.002, 0.005), RADIUS + 0.00105
    rails = [
        ls.obstacles.box(
            name=f"rail {y:+.0f}",
            size=size,
            centre=(start - 0.004, y * beside, 0.0025),
            friction=0.05,
        )
        for y in (-1, 1)
    ]
    back = start - 0.5 * LENGTH - 0.0031
    slide = ls.obstacles.box(
        name="slide",
        size=(0.006, 0.006, 0.006),
        friction=0.05,
        times=[0.0, *PUSHED],
        positions=[(back, 0.0, 0.0035), (back, 0.0, 0.0035), (back + path, 0.0, 0.0035)],
    )
    return [*rails, slide]


def scene(case: str = "antiparallel", polarization: float = 1.1) -> ls.Scene:
    """case: parallel | antiparallel | free; polarization: polarization of the magnets [T]."""
    if case not in GAP:
        raise ls.InvalidInput(f"case must be one of {', '.join(GAP)}, got {case!r}")
    mesh = rod_mesh()
    height, reach = RADIUS * np.cos(np.pi / SIDES), BALL + 0.5 * LENGTH
    start, turn = -reach - GAP[case], ASKEW[case] + (0.0 if case == "parallel" else np.pi)
    rod = ls.RigidBody(
        name="rod",
        mesh=mesh,
        density=1800,
        friction=0.15,
        position=(start, 0.0, height),
        orientation=(np.cos(0.5 * turn), 0.0, 0.0, np.sin(0.5 * turn)),
    )
    ball = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=BALL, subdivisions=3),
        shape="sphere",
        density=7800,
        friction=0.3,
        position=(0.0, 0.0, BALL),
    )
    # With a keyframe, magnets on the obstacle are placed relative to its pose.
    held = ls.obstacles.mesh(
        mesh, name="held", times=[0.0], positions=[(reach + 2e-5, 0.0, height)], friction=0.3
    )
    along_x = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)  # rotates z to x
    at = 0.5 * LENGTH - DEEP - 0.5 * MAGNET["height"]
    magnet = ls.magnetics.cylinder(**MAGNET, polarization=(0, 0, polarization))
    magnets = [
        ls.Magnet(body=name, source=magnet.at((x, 0, 0), along_x))
        for name in ("held", "rod")
        for x in (-at, at)
    ]
    # The ball's response is computed up to degree 6, because a single dipole (degree 1) between two
    # like poles cannot be attracted to both.
    iron = ls.magnetics.soft_sphere(radius=BALL, susceptibility=1000.0, degree=6)
    magnets.append(ls.Magnet(body="ball", source=iron))
    guides = rails_and_slide(start, GAP[case] - 0.001) if case == "antiparallel" else []
    return ls.Scene(
        bodies=[rod, ball],
        magnets=magnets,
        obstacles=[held, ls.floor(size=0.4, friction=0.15), *guides],
        magnetic_tolerance=1e-3,
    )


def check(run: ls.Run) -> None:
    names, owner = list(run.topology.body_names), run.topology.body_of_vertex

    def vertices(name: str, frame: int) -> np.ndarray:
        return np.asarray(run[frame].body_vertices[owner == names.index(name)])

    def gaps(frame: int) -> np.ndarray:
        """Returns the distances of the rod's vertices from the ball's surface [m]. The last two
        vertices are the centres of the rod's ends.
        """
        apart = vertices("rod", frame) - vertices("ball", frame).mean(axis=0)
        return np.asarray(np.linalg.norm(apart, axis=1)) - BALL

    near = [gaps(k).min() for k in range(len(run))]
    assert near[-1] < 5e-4, "the rod has found the ball"
    assert vertices("rod", -1)[:, 2].min() > -5e-4, "nothing sinks into the table"
    turned = np.argmin(gaps(0)[-2:]) != np.argmin(gaps(-1)[-2:])
    fled = max(near) > near[0] + 1e-3
    assert turned == fled, "one that is repelled and free turns, others do not"
    if "slide" in names:
        ahead = np.array(
            [
                vertices("rod", k)[:, 0].min() - vertices("slide", k)[:, 0].max()
                for k in range(len(run))
            ]
        )
        leapt = int(np.argmax(ahead > 1e-3))
        assert leapt > 0 and ahead[:leapt].max() < 5e-4, "it is repelled, and stays at the slide"
        assert 1e-3 < near[leapt - 1] < 5e-3, "until it is over the barrier"
