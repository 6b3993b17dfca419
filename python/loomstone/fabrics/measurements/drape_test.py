"""Cusick's drape test [Cusick1965] (BS 5058, ISO 9073-9).

A disc of fabric with a diameter of 30 cm is clamped between two discs with a diameter of 18 cm.

    drape coefficient = (A_shadow - A_disc) / (A_specimen - A_disc) * 100 %

The fabric is flat between the discs: vertices within a radius of 9 cm are pinned. The remaining
ring hangs over a solid pedestal and comes to rest by kinetic damping. The shadow is the union of
all triangles as seen from above, computed on a pixel grid.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ... import obstacles
from ..._core import Cloth, ClothMaterial, Scene, StrainLimit, TriangleMesh
from ...base.arguments import takes, whole
from ...integrators import SemiImplicitEuler
from ...meshes.relaxation import relaxed
from ...simulation import Simulation
from .rest import Rest, bring_to_rest

__all__ = ["CusickResult", "cusick", "shadow", "shadow_area", "specimen"]

DISC, SPECIMEN = 0.09, 0.15  # radii [m]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CusickResult:
    """Result of one drape test.

    drape_coefficient : Cusick's drape coefficient [%]
    folds : number of folds, counted as maxima of the outline's radius
    shadow : area of the fabric as seen from above [m^2]
    intersections : number of intersecting triangle pairs at the end, except pairs that belong to
        obstacles only
    rest : whether and how the fabric came to rest
    seconds : wall time [s]
    mesh : mesh of the specimen
    positions : final positions of the mesh's vertices (n x 3) [m]
    """

    drape_coefficient: float
    folds: int
    shadow: float
    intersections: int
    rest: Rest
    seconds: float
    mesh: TriangleMesh
    positions: Floats


def specimen(triangles: int, *, seed: int = 1) -> TriangleMesh:
    """Returns an unstructured mesh of a disc, 30 cm in diameter, with about `triangles` triangles.

    A ring of vertices lies on the edge of the clamp.
    """
    triangles = whole("triangles", triangles, 400, 1_000_000)
    # It is assumed that a fifth of the triangles lie in the clamp, and that the others are
    # equilateral with the side `edge`.
    area = np.pi * (SPECIMEN**2 - DISC**2) / (0.8 * triangles)
    edge = float(np.sqrt(4 / np.sqrt(3) * area))
    outline = _ring(SPECIMEN, edge)
    rings, radius, spacing = [_ring(DISC, edge)], DISC - 0.87 * edge, edge
    # Rings of clamped vertices fill the clamp. Only the rings next to the edge of the clamp affect
    # the drape, so vertices become sparser towards the centre.
    while radius > 0.5 * spacing:
        rings.append(_ring(radius, spacing))
        spacing *= 1.4
        radius -= 0.87 * spacing
    held = np.concatenate([*rings, [[0.0, 0.0]]])
    inner = SPECIMEN * np.cos(np.pi / len(outline))

    def depth(points: Floats) -> Floats:
        distance = np.linalg.norm(points, axis=1)
        within: Floats = np.minimum(inner - distance, distance - DISC)
        return within

    # By Euler's formula, the number of triangles is twice the number of interior points plus the
    # number of outline points, up to a constant. relaxed() counts the clamped points as outline
    # points, so the number of triangles passed to it is reduced by the number of clamped points.
    fixed = np.concatenate([outline, held])
    return relaxed(fixed, depth, (2 * SPECIMEN, 2 * SPECIMEN), edge, triangles - len(held), seed)


@takes(step="s", longest="s")
def cusick(
    material: ClothMaterial,
    *,
    strain_limit: StrainLimit | None = None,
    triangles: int = 3000,
    seed: int = 1,
    step: float | None = None,
    longest: float = 8.0,
    threads: int = 0,
) -> CusickResult:
    """Simulates a drape test.

    material : ClothMaterial or a fabric
    strain_limit : StrainLimit of the specimen; None: no limit
    triangles, seed : number of triangles and random seed of the specimen's mesh
    step : time step [s]; None: 4 ms for mean edges of 10 mm or more, and proportionally less for
        shorter ones, but at least 0.5 ms
    longest : simulated time allowed for coming to rest [s]

    Raises InvalidInput for values out of range.
    """
    began = time.perf_counter()
    mesh = specimen(triangles, seed=seed)
    if step is None:
        step = float(np.clip(0.4 * mesh.mean_edge, 5e-4, 4e-3))
    simulation = Simulation(
        drape_scene(material, mesh, strain_limit),
        integrator=SemiImplicitEuler(step=step),
        threads=threads,
    )
    rest = bring_to_rest(simulation, longest=longest)
    positions = simulation.positions
    area, flat = shadow_area(positions, mesh.triangles), shadow_area(mesh.vertices, mesh.triangles)
    disc = np.pi * DISC**2
    return CusickResult(
        drape_coefficient=100.0 * (area - disc) / (flat - disc),
        folds=count_folds(mesh, positions),
        shadow=area,
        # Pairs of two obstacle triangles are not counted.
        intersections=sum(min(pair) < mesh.n_triangles for pair in simulation.intersecting_pairs()),
        rest=rest,
        seconds=time.perf_counter() - began,
        mesh=mesh,
        positions=positions,
    )


def drape_scene(
    material: ClothMaterial, mesh: TriangleMesh, strain_limit: StrainLimit | None = None
) -> Scene:
    """Returns a scene with a pedestal, a floor and a flat specimen clamped within a 9 cm radius."""
    held = np.flatnonzero(np.linalg.norm(mesh.vertices[:, :2], axis=1) < DISC + 1e-9)
    pedestal = obstacles.mesh(
        _pedestal(DISC - 1.5e-3, 0.12), name="pedestal", centre=(0.0, 0.0, -1.5e-3)
    )
    cloth = Cloth(
        name="specimen",
        mesh=mesh,
        material=material,
        pins=[int(i) for i in held],
        strain_limit=strain_limit,
    )
    return Scene(cloths=[cloth], obstacles=[pedestal, obstacles.floor(height=-0.12, size=1.0)])


def shadow_area(positions: Floats, triangles: NDArray[np.int32], *, pixel: float = 2.5e-4) -> float:
    """Returns the area of the union of triangles as seen from above [m^2].

    pixel : side of a pixel [m]
    """
    return float(shadow(positions, triangles, pixel=pixel)[0].sum() * pixel**2)


def shadow(
    positions: Floats, triangles: NDArray[np.int32], *, pixel: float = 2.5e-4
) -> tuple[NDArray[np.bool_], Floats, float]:
    """Returns the pixels whose centres are covered by triangles, as seen from above.

    The first result is an array of flags with indices along x and y. The second is the position
    (x, y) of the array's lower corner [m], and the third is the side of a pixel [m].
    """
    xy = positions[:, :2] / pixel
    low = np.floor(xy.min(0)) - 1
    size = np.ceil(xy.max(0) - low).astype(int) + 2
    covered = np.zeros((size[0], size[1]), bool)
    for a, b, c in xy[triangles] - low:
        corner = np.array([a, b, c])
        first = np.ceil(corner.min(0) - 0.5).astype(int)
        last = np.floor(corner.max(0) - 0.5).astype(int) + 1
        x = np.arange(first[0], last[0])[:, None] + 0.5
        y = np.arange(first[1], last[1])[None, :] + 0.5
        turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if turn == 0.0 or not (last > first).all():
            continue  # the triangle is seen edge-on, or its box contains no centre of a pixel
        side = np.sign(turn)
        edges = [
            side * ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]))
            for p, q in ((a, b), (b, c), (c, a))
        ]
        covered[first[0] : last[0], first[1] : last[1]] |= np.minimum.reduce(edges) >= 0
    return covered, low * pixel, pixel


def count_folds(mesh: TriangleMesh, positions: Floats) -> int:
    """Counts the maxima of the radius along the specimen's edge.

    A maximum must have a prominence of at least 3 mm.
    """
    from scipy.signal import find_peaks

    rim = np.flatnonzero(np.linalg.norm(mesh.vertices[:, :2], axis=1) > SPECIMEN - 1e-6)
    rim = rim[np.argsort(np.arctan2(mesh.vertices[rim, 1], mesh.vertices[rim, 0]))]
    radius = np.linalg.norm(positions[rim, :2], axis=1)
    start = int(radius.argmin())  # the minimum, because a peak at the start would be split
    peaks, _ = find_peaks(np.append(np.roll(radius, -start), radius[start]), prominence=3e-3)
    return len(peaks)


def _ring(radius: float, edge: float) -> Floats:
    angle = np.arange(n := max(6, round(2 * np.pi * radius / edge))) * 2 * np.pi / n
    ring: Floats = radius * np.c_[np.cos(angle), np.sin(angle)]
    return ring


def _pedestal(radius: float, height: float) -> TriangleMesh:
    """Returns a closed cylinder below z = 0 with a rounded upper edge."""
    turn, round_off = np.linspace(0, np.pi / 2, 5), 2e-3
    r = np.r_[radius - round_off + round_off * np.sin(turn), radius]
    z = np.r_[round_off * (np.cos(turn) - 1), -height]
    n = 96
    angle = np.arange(n) * 2 * np.pi / n
    points = np.concatenate(
        [
            np.c_[a * np.cos(angle), a * np.sin(angle), np.full(n, b)]
            for a, b in zip(r, z, strict=True)
        ]
    )
    here = np.arange(n)
    after = (here + 1) % n
    faces = []
    for k in range(len(r) - 1):
        upper, lower = k * n, (k + 1) * n
        faces += [
            np.c_[upper + here, lower + here, lower + after],
            np.c_[upper + here, lower + after, upper + after],
        ]
    top, bottom, last = len(points), len(points) + 1, (len(r) - 1) * n
    faces += [
        np.c_[np.full(n, top), here, after],
        np.c_[np.full(n, bottom), last + after, last + here],
    ]
    return TriangleMesh(
        np.concatenate([points, [[0, 0, 0], [0, 0, -height]]]), np.concatenate(faces)
    )
