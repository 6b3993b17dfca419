"""Garments in which two sewn edges of a panel meet: bags, cushions and cones."""

import loomstone as ls
import numpy as np
import pytest

G = ls.garments
NAMES = ("bottom", "right", "top", "left")


def at(height: float):
    """A placement at a constant height [m]."""
    return lambda points: np.c_[points, np.full(len(points), height)]


def bag(corners, sewn, triangles: int, seed: int = 1) -> G.Garment:
    """Two equal panels, 4 cm apart, sewn along the named edges."""
    panels = [
        G.Panel.polygon(name, corners, names=NAMES, place=at(height))
        for name, height in (("front", 0.02), ("back", -0.02))
    ]
    seams = [G.Seam(f"front.{edge}", f"back.{edge}", reverse=False) for edge in sewn]
    return ls.garment(panels, seams, triangles=triangles, seed=seed)


def check_manifold(mesh: ls.TriangleMesh, openings: int, euler: int) -> None:
    triangles = np.asarray(mesh.triangles)
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, uses = np.unique(np.sort(half, axis=1), axis=0, return_counts=True)
    assert uses.max() == 2
    assert len(mesh.vertices) - len(uses) + len(triangles) == euler - openings


@pytest.mark.parametrize("sewn", [NAMES, ("bottom", "left", "right")])
@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (0.4, 0), (0.4, 0.3), (0, 0.3)],
        [(0, 0), (0.4, 0), (0.3, 0.3), (0.1, 0.3)],
        [(0, 0), (0.44, 0), (0.32, 0.17), (0.12, 0.17)],  # angles of 55 degrees
    ],
)
def test_two_equal_panels_are_sewn_to_a_bag_or_cushion(corners, sewn):
    for triangles, seed in ((60, 1), (200, 2), (371, 1), (1285, 2)):
        sack = bag(corners, sewn, triangles, seed)
        openings = 0 if len(sewn) == 4 else 1
        assert len(sack.openings()) == openings
        check_manifold(sack.mesh, openings, 2)
        # Where two sewn edges meet in a corner of 55 to 90 degrees, an edge of the mesh is flipped
        # or split. The new triangles have smaller angles.
        assert sack.min_angle_degrees() > 17
        assert abs(sack.mesh.n_triangles - triangles) <= 0.05 * triangles + 4


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (0.4, 0), (0.4, 0.4)],  # angles of 45 degrees
        [(0, 0), (0.4, 0), (0.4, 0.23)],  # an angle of 30 degrees
        [(0, 0), (0.4, 0), (0.4, 0.1), (0.1, 0.1), (0.1, 0.4), (0, 0.4)],
    ],
)
def test_sharp_corners_of_a_cushion_do_not_pass_through_each_other(corners):
    names = tuple(f"edge{k}" for k in range(len(corners)))
    for triangles in (40, 60, 100, 150, 250):
        for seed in (1, 2, 3):
            panels = [
                G.Panel.polygon(name, corners, names=names, place=at(height))
                for name, height in (("front", 0.02), ("back", -0.02))
            ]
            seams = [G.Seam(f"front.{edge}", f"back.{edge}", reverse=False) for edge in names]
            cushion = ls.garment(panels, seams, triangles=triangles, seed=seed)
            check_manifold(cushion.mesh, 0, 2)


def cone(degrees: float, triangles: int) -> G.Garment:
    """A sector of radius 0.3 m and angle `degrees`, whose straight edges are sewn together."""
    angle = np.radians(degrees)
    share = angle / (2 * np.pi)
    arc = np.linspace(0, angle, 13)
    corners = [(0, 0), *(0.3 * np.c_[np.cos(arc), np.sin(arc)])]

    def place(points):
        radius = np.hypot(*points.T)
        turn = np.arctan2(points[:, 1], points[:, 0]) / share
        height = -radius * np.sqrt(1 - share**2)
        return np.c_[radius * share * np.cos(turn), radius * share * np.sin(turn), height]

    names = ["start", *(f"arc{k}" for k in range(12)), "end"]
    panel = G.Panel.polygon("cone", corners, names=names, place=place)
    return ls.garment([panel], [("cone.start", "cone.end")], triangles=triangles)


@pytest.mark.parametrize(("degrees", "least"), [(60, 8), (90, 15), (120, 20), (150, 25)])
def test_a_sector_is_sewn_to_a_cone(degrees, least):
    for triangles in (60, 200, 700):
        hat = cone(degrees, triangles)
        check_manifold(hat.mesh, 1, 2)
        assert hat.min_angle_degrees() > least
        # New vertices lie on the cone too.
        points = np.asarray(hat.mesh.vertices)
        radius, share = np.hypot(*points.T[:2]), degrees / 360
        slope = share / np.sqrt(1 - share**2)
        # The relaxation in garment() moves vertices off the cone by a fraction of an edge.
        assert np.abs(radius + slope * points[:, 2]).max() < 0.03


def test_a_cushion_falls_without_stretching():
    cushion = bag([(0, 0), (0.4, 0), (0.4, 0.3), (0, 0.3)], NAMES, 600)
    cloth = ls.Cloth(mesh=cushion.moved((0, 0, 0.1)).mesh)
    sim = ls.Simulation(ls.Scene(cloths=[cloth], obstacles=[ls.floor()]), threads=1)
    for _ in range(60):
        sim.step()
    assert sim.report.contacts.intersections == 0
    assert sim.report.strain.stretch < 1.1
