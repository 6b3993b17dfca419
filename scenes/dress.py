"""A dress hangs by its straps from a bar, and is shaken and spun.

The skirt starts as a cone and falls into folds. From 1 s to 2.6 s, the bar moves back and forth and
the dress swings after it. From 2.8 s on, the bar turns ever faster: the skirt first winds round
itself, then flies out. This is example 3.4 of [Thomaszewski2010] (figure 3.9), with the same
stiffness and strain limits and nearly the same number of triangles, but with a different pattern of
13 panels.

The following command hangs another garment from the bar. Its file must contain a sewn mesh whose z
axis points up and whose uv are the pattern in metres:

    loomstone run scenes/dress.py -p mesh=dress.obj
"""

import loomstone as ls
import numpy as np

duration = 5.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=2e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(1.1, -2.2, 0.1), target=(0.0, 0.0, -0.5), field_of_view_degrees=30.0
    ),
    floor=False,
)

BAR_RADIUS = 0.015
SHAKEN, SPUN = 1.0, 2.8  # start of shaking and of spinning [s]


def motion(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns positions (k x 3) [m] and rotation vectors (k x 3) [rad] of the bar at times [s]."""
    shaken = np.clip(times - SHAKEN, 0.0, 1.6)
    positions = np.zeros((len(times), 3))
    positions[:, 1] = 0.12 * np.sin(2.0 * np.pi * 1.25 * shaken)
    turns = np.zeros((len(times), 3))
    turns[:, 2] = 0.5 * 6.0 * np.clip(times - SPUN, 0.0, None) ** 2
    return positions, turns


def bar() -> ls.Obstacle:
    times = np.linspace(0.0, duration, 1 + round(1000 * duration))
    positions, turns = motion(times)
    along = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # rotates z to x
    mesh = ls.meshes.capsule(radius=BAR_RADIUS, length=0.5).moved((0.0, 0.0, 0.0), rotation=along)
    return ls.obstacles.mesh(
        mesh, name="bar", times=times, positions=positions, axis_angles=turns, friction=0.6
    )


def scene(
    triangles: int = 8900, limited: bool = True, mesh: str = "", below: float = 0.048
) -> ls.Scene:
    """mesh: file of a garment that replaces the dress and hangs from the bar by its neck, like a
    halter. In the file's axes, the bar runs along y, `below` [m] under the garment's highest point.
    """
    if mesh:
        dress = ls.garments.read(mesh)
        highest = dress.mesh.vertices[np.argmax(dress.mesh.vertices[:, 2])]
        quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # rotates y to x
        dress = dress.at((dress.mesh.vertices - highest + (0.0, 0.0, below)) @ quarter.T)
    else:
        dress = ls.garments.dress(triangles, bar_radius=BAR_RADIUS)
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=75.0,
        density=0.2,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    limit = ls.StrainLimit(weft=0.1, warp=0.1, shear=0.4) if limited else None
    cloth = ls.Cloth(
        name="dress", mesh=dress.mesh, material=material, friction=0.3, strain_limit=limit
    )
    return ls.Scene(
        cloths=[cloth], obstacles=[bar()], air=ls.Air(normal_drag=0.5, tangential_drag=0.02)
    )


def check(run: ls.Run) -> None:
    last = run[-1]
    assert last.positions[:, 2].max() > 0.5 * BAR_RADIUS, "the straps still lie on the bar"
    assert max(frame.stretch.max() for frame in run) < 1.3, "nothing is torn"
