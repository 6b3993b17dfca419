"""Sewing by simulation: forces close the seams of panels. The joined vertices are then welded."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._core import Cloth, ClothMaterial, InvalidInput, Obstacle, Scene, SolverFailure
from ..base.arguments import takes, whole
from ..base.cautions import SceneWarning
from ..integrators import SemiImplicitEuler
from ..simulation import Simulation
from .cutting import Cut, cut
from .placement import Placement
from .relaxation import relaxed
from .seams import Pattern
from .sewing import EASE, Garment, check_free, edge_for, joined, welded

__all__ = ["close_seams"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

REACH = 0.03  # gap above which the spring force between two vertices is constant [m]
# The seams are closed if the largest gap, divided by the mean edge, is at most SHUT, or at most
# SHUT_AT_REST once gaps no longer shrink [1].
SHUT, SHUT_AT_REST = 0.15, 0.5
AT_REST = 0.1  # gaps no longer shrink if their sum falls by less than 1 % in this time [s]
DRAG = 15.0  # damping rate of all vertices, which suppresses oscillation [1/s]


@takes(longest="s", step="s", ease="1")
def close_seams(
    pattern: Pattern,
    *,
    triangles: int,
    obstacles: Sequence[Obstacle] = (),
    places: Mapping[str, Placement] | None = None,
    material: ClothMaterial | None = None,
    longest: float = 3.0,
    step: float = 2e-3,
    ease: float = EASE,
    seed: int = 1,
    threads: int = 0,
) -> Garment:
    """Returns a garment whose seams are closed by springs of zero rest length, without gravity.

    pattern : its placed panels may meet only along seams, and must not touch obstacles
    places : placements by panel name, which replace those of the pattern
    obstacles : surfaces with which the panels collide, such as the wearer's body
    material : material of the panels during sewing; default: 300 N/m (75 in shear), 0.2 kg/m^2
    longest : simulated time after which open seams are an error [s]
    step : time step [s]
    ease : largest relative difference in length of sewn edges [1]
    triangles, seed, threads : as in garment() and Simulation

    Seams count as closed if no gap exceeds 0.15 times the mean mesh edge, which is 1.5 contact
    distances. They also count as closed if gaps no longer shrink and none exceeds half the mean
    mesh edge, because thickness keeps panels apart where three meet. Joined vertices are then
    welded at their mean position, and the strain is reduced. Raises SolverFailure naming the widest
    seam if seams stay open, and InvalidInput if the pattern cannot be sewn or the sewn garment
    would intersect itself.
    """
    _check(pattern, longest=longest, step=step)
    pattern = pattern if places is None else pattern.placed(places)
    pattern.check(ease)
    total = sum(panel.area for panel in pattern.panels)
    count = whole("triangles", triangles, 2 * len(pattern.panels), 10_000_000)
    pieces = cut(pattern, spacing=edge_for(total, count), triangles=count, seed=seed)
    if len(pieces.pairs) == 0:
        raise InvalidInput("the pattern has no seams to close")
    # The contact distance is 0.1 `edge`. A Cloth has about this default if no triangle is slender.
    edge = edge_for(total, count)
    index, mesh = welded(pieces, pieces.placed, pieces.pairs[_closed_already(pieces, 0.1 * edge)])
    if material is None:
        material = ClothMaterial(
            weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=75.0, density=0.2
        )
    cloth = Cloth(name="panels", mesh=mesh, material=material, friction=0.0, thickness=0.1 * edge)
    body = [obstacle.replace(friction=0.0) for obstacle in obstacles]
    scene = Scene(cloths=[cloth], obstacles=body, gravity=(0.0, 0.0, 0.0))
    sim = _simulation(scene, step, threads)
    masses = np.asarray(np.bincount(index, material.density * _areas(pieces)), float)
    positions = _pulled(sim, pieces, index[pieces.pairs], masses, _Limits(step, longest, edge))
    sewn = joined(pieces, positions[index])
    faces = np.asarray(sewn.mesh.triangles, np.int64)
    # Joining moves the vertices of a seam by about half the gap. Relaxation smooths the distortion.
    sewn = sewn.at(
        relaxed(np.asarray(sewn.mesh.vertices), faces, sewn.flat_corners(), iterations=20)
    )
    check_free(sewn)
    return sewn


def _check(pattern: object, **times: float) -> None:
    if not isinstance(pattern, Pattern):
        raise InvalidInput(f"close_seams needs a Pattern, got {pattern!r}")
    for name, value in times.items():
        if not (np.isfinite(value) and value > 0):
            raise InvalidInput(f"close_seams: {name} must be > 0 [s], got {value}")


def _simulation(scene: Scene, step: float, threads: int) -> Simulation:
    """Builds the simulation of sewing.

    Warnings about the scene are ignored, since panels touch at seams that are closed at the start.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return Simulation(scene, integrator=SemiImplicitEuler(step=step), threads=threads)


def _closed_already(pieces: Cut, distance: float) -> NDArray[np.bool_]:
    """Returns, for each pair, whether its seam initially has no gap larger than `distance` [m]."""
    gap = np.linalg.norm(
        pieces.placed[pieces.pairs[:, 0]] - pieces.placed[pieces.pairs[:, 1]], axis=1
    )
    widest = np.zeros(len(pieces.pattern.seams))
    np.maximum.at(widest, pieces.seam_of_pair, gap)
    return np.asarray(widest[pieces.seam_of_pair] <= distance)


@dataclass(frozen=True)
class _Limits:
    """Time step [s] of sewing, its largest simulated time [s], and the mean edge of the mesh [m],
    with which gaps are compared.
    """

    step: float
    longest: float
    edge: float


def _pulled(
    sim: Simulation,
    pieces: Cut,
    pairs: Indices,
    mass: Floats,
    limits: _Limits,
) -> Floats:
    """Pulls pairs of vertices together by external forces; returns positions with closed seams."""
    step, longest, edge = limits.step, limits.longest, limits.edge
    a, b = pairs.T
    pair_mass = mass[a] * mass[b] / (mass[a] + mass[b])
    # A spring between the two vertices of each pair acts as an external force, outside the implicit
    # solve. Its stiffness is pair_mass / (5 n step^2), which keeps explicit integration stable.
    # pair_mass is the reduced mass of the two vertices. n is the larger of the numbers of springs
    # at one and at the other vertex.
    meets = np.bincount(np.concatenate([a, b]), minlength=len(mass))
    stiffness = 0.2 * pair_mass / step**2 / np.maximum(meets[a], meets[b])
    least, since = np.inf, 0
    for index in range(int(np.ceil(longest / step))):
        positions, velocities = np.asarray(sim.positions), np.asarray(sim.velocities)
        apart = positions[b] - positions[a]
        gap = np.linalg.norm(apart, axis=1)
        if gap.sum() < 0.99 * least:
            least, since = float(gap.sum()), index
        if gap.max() <= SHUT * edge or (
            gap.max() <= SHUT_AT_REST * edge and (index - since) * step > AT_REST
        ):
            return positions
        pull = stiffness[:, None] * apart * np.minimum(1.0, REACH / np.maximum(gap, 1e-12))[:, None]
        damping = 2.0 * np.sqrt(stiffness * pair_mass)[:, None] * (velocities[b] - velocities[a])
        forces = -DRAG * mass[:, None] * velocities
        np.add.at(forces, a, pull + damping)
        np.add.at(forces, b, -pull - damping)
        sim.external_forces = forces
        sim.step()
    worst = int(gap.argmax())
    seam = pieces.pattern.seams[int(pieces.seam_of_pair[worst])]
    raise SolverFailure(
        f"after {longest:g} s {seam} is still {1000 * gap[worst]:.1f} mm open; place the panels"
        " closer, make the garment wider, or increase longest"
    )


def _areas(pieces: Cut) -> Floats:
    """Returns the area of every panel vertex: a third of the total area of its triangles [m^2]."""
    corners = pieces.flat[pieces.triangles]
    e, f = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    third = np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]) / 6
    return np.asarray(
        np.bincount(pieces.triangles.ravel(), np.repeat(third, 3), minlength=len(pieces.flat)),
        float,
    )
