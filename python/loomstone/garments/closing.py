"""Sews by simulation: panels stand apart, their seams pull shut round a body, then they are welded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .._core import Cloth, ClothMaterial, InvalidInput, Obstacle, Scene, SolverFailure, TriangleMesh
from ..arguments import whole
from ..integrators import SemiImplicitEuler
from ..simulation import Simulation
from .cutting import Cut, cut
from .placement import Placement
from .relaxation import relaxed
from .seams import Pattern
from .sewing import EASE, Garment, check_free, edge_for, joined

__all__ = ["close_seams"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

REACH = 0.03  # a pair pulls no harder than at this distance [m]
AT_REST = 0.1  # gaps that have not shrunk by a hundredth for so long are at rest [s]
DRAG = 15.0  # slows all vertices [1/s]: panels approach at a speed, they do not swing


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
    """A garment sewn where its panels meet when springs of no length pull its seams together, without gravity.

    pattern : panels stand free of each other and of the body; places : other places for some of them, by name
    obstacles : the body, not to be passed through; material : default 300 N/m, 0.2 kg/m^2
    longest : simulated time after which open seams are an error [s]; step [s]
    ease : how far the lengths of sewn edges may differ [1]

    Seams count as closed when no pair is farther apart than 1.5 contact distances, or when all have come to rest within
    half an edge (where three panels meet their thickness keeps them apart); pairs then meet halfway. Raises
    SolverFailure naming the widest seam where they stay open, InvalidInput where the sewn garment would pass through
    itself.
    """
    pattern = pattern if places is None else pattern.placed(places)
    pattern.check(ease)
    total = sum(panel.area for panel in pattern.panels)
    count = whole("triangles", triangles, 2 * len(pattern.panels), 10_000_000)
    pieces = cut(pattern, spacing=edge_for(total, count), triangles=count, seed=seed)
    if len(pieces.pairs) == 0:
        raise InvalidInput("the pattern has no seams to close")
    mesh = TriangleMesh(pieces.placed, pieces.triangles, pieces.flat, uv_triangles=pieces.triangles)
    # The contact distance of the pieces while they are sewn: a tenth of an edge, as chosen by default.
    distance = 0.1 * mesh.mean_edge
    if material is None:
        material = ClothMaterial(weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=75.0, density=0.2)
    cloth = Cloth(name="panels", mesh=mesh, material=material, friction=0.0, thickness=distance)
    body = [obstacle.replace(friction=0.0) for obstacle in obstacles]
    scene = Scene(cloths=[cloth], obstacles=body, gravity=(0.0, 0.0, 0.0))
    sim = Simulation(scene, integrator=SemiImplicitEuler(step=step), threads=threads)
    positions = _closed(sim, pieces, material.density, step, longest, 1.5 * distance, 0.5 * mesh.mean_edge)
    sewn = joined(pieces, positions)
    faces = np.asarray(sewn.mesh.triangles, np.int64)
    # Vertices of a seam jumped by half their gap.
    sewn = sewn.at(relaxed(np.asarray(sewn.mesh.vertices), faces, sewn.flat_corners(), iterations=20))
    check_free(sewn)
    return sewn


def _closed(
    sim: Simulation, pieces: Cut, density: float, step: float, longest: float, distance: float, at_rest: float
) -> Floats:
    """Positions when all pairs are within `distance`, or at rest within `at_rest`; pulls by external forces."""
    a, b = pieces.pairs.T
    mass = _masses(pieces, density)
    pair_mass = mass[a] * mass[b] / (mass[a] + mass[b])
    # Springs are outside the implicit solve: a fifth of what an explicit step bears, shared by what meets in a vertex.
    meets = np.bincount(np.concatenate([a, b]), minlength=len(mass))
    stiffness = 0.2 * pair_mass / step**2 / np.maximum(meets[a], meets[b])
    least, since = np.inf, 0
    for index in range(int(np.ceil(longest / step))):
        positions, velocities = np.asarray(sim.positions), np.asarray(sim.velocities)
        apart = positions[b] - positions[a]
        gap = np.linalg.norm(apart, axis=1)
        if gap.max() <= distance:
            return positions
        if gap.sum() < 0.99 * least:
            least, since = float(gap.sum()), index
        if gap.max() <= at_rest and (index - since) * step > AT_REST:
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
        f"after {longest:g} s {seam} is still {1000 * gap[worst]:.1f} mm open ({(gap > distance).sum()} of {len(gap)} "
        f"pairs wider than {1000 * distance:.1f} mm); place the panels closer, make the garment wider, or allow longer"
    )


def _masses(pieces: Cut, density: float) -> Floats:
    corners = pieces.flat[pieces.triangles]
    e, f = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]) / 2
    corner_area = np.repeat(area / 3, 3)
    return np.asarray(density * np.bincount(pieces.triangles.ravel(), corner_area, minlength=len(pieces.flat)), float)
