"""A ribbon is tied in an overhand knot and pulled tight.

The ends are drawn apart, the loop shrinks and the ribbon folds where it turns. In the end, friction
holds the tight knot.
"""

import loomstone as ls
import numpy as np

duration = 4.0
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.22, -0.95, 0.10), target=(0.0, 0.0, -0.205), field_of_view_degrees=24.0
    ),
    floor=False,
)

WIDTH, SCALE, REACH = 0.025, 0.042, 2.35
HEIGHT = -0.06  # height of the ends after they have been drawn apart [m]


def integrator(triangles: int = 6000) -> ls.Integrator:
    return ls.SemiImplicitEuler(step=2e-3)


def centre_line(n: int) -> np.ndarray:
    """Returns evenly spaced points ((n + 1) x 3) of an open trefoil knot [m].

    Seen along y, the curve is x = t^3 - 3 t and z = t^4 - 4 t^2, up to a scale. It crosses itself
    at t = +-0.518, +-1.732 and +-1.932, where it passes alternately in front and behind.
    """
    t = np.linspace(-REACH, REACH, 20001)
    crossings = np.array([-REACH, -1.932, -1.732, -0.518, 0.518, 1.732, 1.932, REACH])
    before = np.array([0.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 0.0]) * 0.9 * WIDTH
    place = np.clip(np.searchsorted(crossings, t, side="right") - 1, 0, len(crossings) - 2)
    share = (t - crossings[place]) / (crossings[place + 1] - crossings[place])
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    y = before[place] + smooth * (before[place + 1] - before[place])
    line = np.stack([SCALE * (t**3 - 3.0 * t), y, SCALE * (t**4 - 4.0 * t**2)], axis=1)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    even = np.linspace(0.0, length[-1], n + 1)
    return np.stack([np.interp(even, length, line[:, k]) for k in range(3)], axis=1)


def scene(triangles: int = 6000, slack: float = 8.0, friction: float = 0.2) -> ls.Scene:
    """slack: length of ribbon that is left for the knot, in widths of the ribbon [1]."""
    length = float(np.linalg.norm(np.diff(centre_line(4000), axis=0), axis=1).sum())
    edge = np.sqrt(2.0 * length * WIDTH / triangles)
    columns, rows = max(3, round(WIDTH / edge)), max(20, round(length / edge))
    flat = ls.grid(size=(WIDTH, length), cells=(columns, rows))
    # The width of the ribbon is along y everywhere. All lines along the ribbon are therefore as
    # long as the centre line.
    line = np.repeat(centre_line(rows), columns + 1, axis=0)
    mesh = ls.TriangleMesh(
        line + flat.vertices[:, :1] * [[0.0, 1.0, 0.0]], flat.triangles, flat.vertices[:, :2]
    )
    ends = np.concatenate([np.arange(columns + 1), np.arange(columns + 1) + rows * (columns + 1)])
    start = mesh.vertices[ends]
    times = np.array([0.0, 0.8 * duration, duration])
    apart = 0.5 * (length - slack * WIDTH)
    drawn = np.stack(
        [apart * np.sign(start[:, 0]), start[:, 1], np.full(len(start), HEIGHT)], axis=1
    )
    path = np.concatenate([start, drawn, drawn])
    material = ls.ClothMaterial(
        weft_stiffness=600.0,
        warp_stiffness=600.0,
        shear_stiffness=200.0,
        density=0.15,
        bending_weft=1e-6,
        bending_warp=1e-6,
    )
    ribbon = ls.Cloth(
        name="ribbon",
        mesh=mesh,
        material=material,
        friction=friction,
        pins=[int(i) for i in ends],
        script_times=times,
        script_positions=path,
    )
    return ls.Scene(cloths=[ribbon])


def check(run: ls.Run) -> None:
    assert max(frame.stretch.max() for frame in run) < 2.0, "contacts do not tear the ribbon"
