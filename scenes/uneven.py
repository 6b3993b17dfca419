"""A hat of felt falls on a floor, gives way, and recovers its shape.

Crown and brim of the hat are flat and have large triangles, which shrink towards the two folds in
between. The largest triangle has 178 times the area of the smallest one. With asynchronous steps
only the small triangles take small steps. Example 4.2 of the thesis (figure 4.7) has a mesh of as
many triangles and similar areas; the shape is our own.
"""

import loomstone as ls
import numpy as np
from loomstone.meshes.planar import delaunay
from numpy.typing import NDArray

Floats = NDArray[np.float64]

duration = 4.0
rate = 25.0
integrator = ls.Asynchronous(step=2.5e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.75, -1.05, 0.6), target=(0.0, 0.0, 0.13), field_of_view_degrees=30.0
    )
)

# Lengths of the profile from the middle outwards: crown, first fold, wall, second fold, brim [m].
LENGTHS = (0.12, 0.035, 0.055, 0.035, 0.115)
SLOPE = np.deg2rad(65.0)  # of the wall
KNOTS = np.cumsum((0.0, *LENGTHS))
FINE = 0.0075  # edge of the triangles in the folds of a mesh with 2,304 triangles [m]


def profile(along: Floats) -> tuple[Floats, Floats]:
    """Returns radius and height of the hat at distances along its profile from the middle [m]."""
    fine = np.linspace(0.0, KNOTS[-1], 4001)
    slope = np.interp(fine, KNOTS, (0.0, 0.0, SLOPE, SLOPE, 0.0, 0.0))
    step = np.diff(fine, prepend=0.0)
    radius, height = np.cumsum(np.cos(slope) * step), -np.cumsum(np.sin(slope) * step)
    return np.interp(along, fine, radius), np.interp(along, fine, height)


def edge_at(points: Floats, fine: float, coarse: float) -> Floats:
    """Returns the wanted edge of triangles at flat points (n x 2) [m]."""
    along = np.linalg.norm(points, axis=1)
    apart = [np.maximum(KNOTS[i] - along, along - KNOTS[i + 1]).clip(0.0) for i in (1, 3)]
    return np.asarray(np.minimum(fine + 0.4 * np.minimum(*apart), coarse))


def flat(triangles: int, coarse: float) -> tuple[Floats, NDArray[np.int32]]:
    """Returns points and triangles of a disc, fine in the folds.

    Points start at random, apart from one another by the wanted edge times a factor that decreases
    until there are enough, and move to the centroids of their triangles, weighted by density.
    """
    fine = FINE * np.sqrt(2304 / triangles)
    random, outer = np.random.default_rng(3), KNOTS[-1]
    count = 2 * round(np.pi * outer / edge_at(np.array([[outer, 0.0]]), fine, coarse)[0])
    angle = 2.0 * np.pi * np.arange(count) / count
    points = np.zeros((count + (triangles + 2 - count) // 2, 2))
    points[:count] = outer * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    placed, gap = count, 1.0
    while placed < len(points):
        tried = random.uniform(-outer, outer, (500, 2))
        edges = gap * edge_at(tried, fine, coarse)
        for point, edge in zip(tried, edges, strict=True):
            inside = np.linalg.norm(point) < outer - 0.5 * edge
            if inside and np.linalg.norm(points[:placed] - point, axis=1).min() > edge:
                points[placed], placed = point, placed + 1
                if placed == len(points):
                    break
        gap *= 0.98
    for _ in range(60):
        faces = delaunay(points, 0.0)
        points[count:] = weighted_centres(points, faces, fine, coarse)[count:]
    return points, delaunay(points, 0.0)


def weighted_centres(
    points: Floats, faces: NDArray[np.int32], fine: float, coarse: float
) -> Floats:
    """Returns the centroid of the triangles around each point, with more weight on fine ones."""
    corners = points[faces]
    e, f = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    middle = corners.mean(axis=1)
    area = np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0])
    weight = area / edge_at(middle, fine, coarse) ** 4
    total, moment = np.zeros(len(points)), np.zeros_like(points)
    for corner in range(3):
        np.add.at(total, faces[:, corner], weight)
        np.add.at(moment, faces[:, corner], weight[:, None] * middle)
    return moment / total[:, None]


def hat(triangles: int, coarse: float) -> ls.TriangleMesh:
    points, faces = flat(triangles, coarse)
    along = np.linalg.norm(points, axis=1)
    radius, height = profile(along)
    scale = radius / np.maximum(along, 1e-12)
    curved = np.column_stack((points * scale[:, None], height - height.min()))
    return ls.TriangleMesh(curved, faces, points)


def scene(triangles: int = 2304, coarse: float = 0.03, damping: float = 1e-5) -> ls.Scene:
    """coarse: largest edge of the triangles [m], 0.06 for areas of 436:1; damping: that of bending
    [N m s].
    """
    felt = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.5,
        bending_weft=1.5e-3,
        bending_warp=1.5e-3,
        bending_damping=damping,
    )
    tilt = np.deg2rad(20.0)
    c, s = np.cos(tilt), np.sin(tilt)
    leaning = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    mesh = hat(triangles, coarse).moved((0.0, 0.0, 0.4), rotation=leaning)
    cloth = ls.Cloth(
        name="hat", mesh=mesh, material=felt, rest="mesh", rest_angles="mesh", friction=0.4
    )
    return ls.Scene(cloths=[cloth], obstacles=[ls.floor(height=0.0)], air=ls.Air(normal_drag=0.5))


def apart(shape: Floats, other: Floats) -> float:
    """Returns the root mean square distance of two shapes (n x 3) after a rigid motion [m]."""
    a, b = shape - shape.mean(axis=0), other - other.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    u[:, -1] *= np.sign(np.linalg.det(u @ v))
    return float(np.sqrt(((a @ u @ v - b) ** 2).sum(axis=1).mean()))


def check(run: ls.Run) -> None:
    given = [apart(frame.positions, run[0].positions) for frame in run]
    assert max(given) > 0.008, "the hat gives way when it lands"
    assert given[-1] < 0.25 * max(given), "it recovers its shape"
    assert run[-1].positions[:, 2].min() > 0.0, "it lies on the floor"
    speed = np.linalg.norm(run[-1].velocities, axis=1)
    assert np.sqrt((speed**2).mean()) < 0.05, "it comes to rest"
