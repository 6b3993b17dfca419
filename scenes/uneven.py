"""A pointed hat of felt falls on a floor, gives way, and recovers its shape.

Triangles are smallest at the tip, where the hat is most curved. The largest triangle has 190 times
the area of the smallest. With asynchronous steps, only small triangles take small steps. Example
4.2 of [Thomaszewski2010] (figure 4.7) has a different shape, but the same number of triangles, and
areas that differ by a factor of up to 160.
"""

from typing import NamedTuple

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
        fit=False, eye=(0.7, -1.0, 0.6), target=(0.03, 0.0, 0.23), field_of_view_degrees=36.0
    )
)

# Distances from the tip along the profile [m] and slopes of the profile there [rad]
KNOTS = (0.0, 0.012, 0.13, 0.21, 0.33)
SLOPES = np.deg2rad((0.0, 62.0, 62.0, 0.0, 0.0))
GRADING = 0.13  # increase of the edge length per distance from the tip [1]
COARSE = 0.016  # largest edge length [m]


class Profile(NamedTuple):
    """Profile of the hat, sampled along the cloth from its tip, and a conformal map to a disc."""

    along: Floats  # distance from the tip along the cloth [m]
    radius: Floats  # distance from the axis [m]
    height: Floats  # height above the rim [m]
    flat: Floats  # distance from the middle of the disc [m]


def profile() -> Profile:
    along = np.linspace(0.0, KNOTS[-1], 4001)
    slope = np.interp(along, KNOTS, SLOPES)
    step = along[1]
    radius = np.cumsum(np.cos(slope)) * step
    height = (np.cumsum(np.sin(slope)[::-1]) * step)[::-1]
    # The map is conformal: d flat / flat = d along / radius.
    flat = np.exp(np.cumsum(step / radius))
    return Profile(along, radius, height, flat * radius[-1] / flat[-1])


def edge_at(points: Floats, hat: Profile, fine: float) -> Floats:
    """Returns the desired edge length in the disc [m] at points (n x 2) of the disc [m]."""
    away = np.linalg.norm(points, axis=1)
    along, radius = (np.interp(away, hat.flat, values) for values in (hat.along, hat.radius))
    edge = np.minimum(fine + GRADING * along, COARSE)
    return np.asarray(edge * np.maximum(away, hat.flat[0]) / radius)


def flat(triangles: int, hat: Profile, fine: float) -> tuple[Floats, NDArray[np.int32]]:
    """Returns the points (n x 2) [m] and triangles (m x 3) of the disc.

    Points on the rim are evenly spaced. Inner points are placed at random, with distances of at
    least the desired edge length times a factor, which decreases until all are placed. Then all
    inner points move 60 times to the places that weighted_centres() returns.
    """
    random, outer = np.random.default_rng(3), hat.flat[-1]
    spread = np.sqrt(2304 / triangles)
    count = 2 * round(np.pi * outer / (spread * edge_at(np.array([[outer, 0.0]]), hat, fine)[0]))
    angle = 2.0 * np.pi * np.arange(count) / count
    points = np.zeros((count + (triangles + 2 - count) // 2, 2))
    points[:count] = outer * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    # Desired number of points within each distance of the tip, up to a constant factor
    wanted = np.cumsum(hat.radius / np.minimum(fine + GRADING * hat.along, COARSE) ** 2)
    placed, gap = count, 1.1 * spread
    while placed < len(points):
        share, angle = random.uniform((0.0, 0.0), (1.0, 2.0 * np.pi), (500, 2)).T
        away = np.interp(share, wanted / wanted[-1], hat.flat)
        tried = away[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
        edges = gap * edge_at(tried, hat, fine)
        for point, edge in zip(tried, edges, strict=True):
            inside = placed < len(points) and np.linalg.norm(point) < outer - 0.5 * edge
            if inside and np.linalg.norm(points[:placed] - point, axis=1).min() > edge:
                points[placed], placed = point, placed + 1
        gap *= 0.98
    for _ in range(60):
        faces = delaunay(points, 0.0)
        points[count:] = weighted_centres(points, faces, edge_at(points, hat, fine))[count:]
    return points, delaunay(points, 0.0)


def weighted_centres(points: Floats, faces: NDArray[np.int32], edges: Floats) -> Floats:
    """Returns, for each point, the weighted mean (n x 2) [m] of the centroids of its triangles.

    `edges` are the desired edge lengths at the points [m]. Shorter ones give larger weights.
    """
    corners = points[faces]
    e, f = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    weight = np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]) / edges[faces].mean(axis=1) ** 3
    total, moment = np.zeros(len(points)), np.zeros_like(points)
    for corner in range(3):
        np.add.at(total, faces[:, corner], weight)
        np.add.at(moment, faces[:, corner], weight[:, None] * corners.mean(axis=1))
    return moment / total[:, None]


def hat(triangles: int, fine: float) -> ls.TriangleMesh:
    shape = profile()
    points, faces = flat(triangles, shape, fine)
    away = np.maximum(np.linalg.norm(points, axis=1), 1e-12)
    radius, height = (np.interp(away, shape.flat, v) for v in (shape.radius, shape.height))
    curved = np.column_stack((points * (radius / away)[:, None], height))
    return ls.TriangleMesh(curved, faces, points)


def scene(
    triangles: int = 2304, fine: float = 0.003, bending: float = 1e-3, damping: float = 1e-5
) -> ls.Scene:
    """fine: edge length of triangles at the tip [m]; with 0.00166, areas differ by a factor of up
    to 433. bending: bending rigidity [N m]; damping: damping of bending [s].
    """
    felt = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.5,
        bending_weft=bending,
        bending_warp=bending,
        bending_damping=damping,
    )
    tilt = np.deg2rad(20.0)
    c, s = np.cos(tilt), np.sin(tilt)
    leaning = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    mesh = hat(triangles, fine).moved((0.0, 0.0, 0.4), rotation=leaning)
    cloth = ls.Cloth(
        name="hat", mesh=mesh, material=felt, rest="mesh", rest_angles="mesh", friction=0.4
    )
    return ls.Scene(cloths=[cloth], obstacles=[ls.floor(height=0.0)], air=ls.Air(normal_drag=0.5))


def apart(shape: Floats, other: Floats) -> float:
    """Returns the RMS distance [m] between the vertices of two shapes (n x 3), after a translation
    and a rotation that make it minimal.
    """
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
