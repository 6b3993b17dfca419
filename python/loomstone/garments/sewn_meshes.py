"""Garments from other programs: GarmentCode patterns, and meshes whose uv are the pattern."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import meshes
from .._core import InvalidInput, TriangleMesh, intersecting_pairs
from ..base.arguments import takes
from .closing import close_seams
from .garmentcode import read_garmentcode
from .sewing import Garment, boundary_loops, garment

__all__ = ["read", "sewn"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Largest ease of patterns from files: the difference in length of two sewn edges, relative to the
# longer one. It allows ruffles: an edge may be gathered to a quarter of its length.
GATHERED = 0.75


@takes()
def read(path: str | os.PathLike[str], *, triangles: int | None = None, seed: int = 1) -> Garment:
    """Reads a garment: a GarmentCode pattern (.json), or a sewn mesh whose uv are the pattern [m].

    Sewn meshes are .obj or .ply files. Patterns are sewn by `garment` or, if the result would
    intersect itself, by `close_seams`.

    triangles : total number of triangles for a pattern, by default 6,000; not allowed for a sewn
        mesh, which keeps its triangles
    seed : seed of the triangulation of a pattern

    Raises CacheError if the file cannot be read, InvalidInput if it contains no garment or its
    pattern cannot be sewn, and SolverFailure if seams of a pattern stay open.
    """
    path = Path(path)
    if path.suffix.lower() == ".json":
        pattern, count = read_garmentcode(path), 6000 if triangles is None else triangles
        sewn_at_once = garment(
            pattern, triangles=count, ease=GATHERED, seed=seed, allow_intersections=True
        )
        if not intersecting_pairs(sewn_at_once.mesh.vertices, sewn_at_once.mesh.triangles):
            return sewn_at_once
        return close_seams(pattern, triangles=count, ease=GATHERED, seed=seed)
    if triangles is not None:
        raise InvalidInput(
            f"{path}: a sewn mesh keeps its triangles; leave triangles={triangles} out"
        )
    return sewn(meshes.read(path), where=str(path))


@takes()
def sewn(mesh: TriangleMesh, *, where: str = "mesh") -> Garment:
    """Returns a garment from a sewn mesh.

    Panels are sets of triangles connected by edges with the same uv on both sides. They are called
    "panel_1", "panel_2" and so on, by descending area. Boundary loops are called "opening_1" and so
    on, by descending number of vertices. The groups of the garment have these names.

    mesh : sewn mesh whose uv are the pattern [m]
    where : name of the mesh in errors

    Raises InvalidInput if there are no uv, or if two boundary vertices coincide, which indicates an
    open seam.
    """
    if len(mesh.uv) == 0:
        raise InvalidInput(f"{where}: has no uv; a sewn garment needs its flat pattern as uv [m]")
    triangles = np.asarray(mesh.triangles, np.int64)
    uv = np.asarray(mesh.uv)[np.asarray(mesh.uv_triangles)]
    _check_closed_seams(mesh, triangles, where)
    first, second, seam = _interior_edges(triangles, uv)
    panel = _panels(
        len(triangles), first[~seam] % len(triangles), second[~seam] % len(triangles), uv
    )
    corner = first[seam] // len(triangles), first[seam] % len(triangles)
    ends = np.c_[triangles[corner[1], corner[0]], triangles[corner[1], (corner[0] + 1) % 3]]
    names = tuple(f"panel_{i + 1}" for i in range(int(panel.max()) + 1))
    groups = {name: np.unique(triangles[panel == i]) for i, name in enumerate(names)}
    for i, loop in enumerate(sorted(boundary_loops(triangles), key=lambda loop: -len(loop))):
        groups[f"opening_{i + 1}"] = np.array(loop)
    return Garment(mesh, groups, names, panel, ends)


def _interior_edges(triangles: Indices, uv: Floats) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    """Returns, for every interior edge, its two half-edges and whether their uv differ.

    Half-edge c * m + t starts at corner c of triangle t, where m is the number of triangles.
    """
    m = len(triangles)
    half = np.concatenate([triangles[:, [c, (c + 1) % 3]] for c in range(3)])
    ends = np.concatenate([uv[:, [c, (c + 1) % 3]] for c in range(3)])
    order = np.lexsort(np.sort(half, axis=1).T)
    ordered = np.sort(half, axis=1)[order]
    same = np.flatnonzero((ordered[1:] == ordered[:-1]).all(1))
    first, second = order[same], order[same + 1]
    # Neighbouring triangles traverse their common edge in opposite directions. The tolerance allows
    # for files that store uv with about 6 digits.
    tolerance = 1e-5 * float(np.ptp(uv.reshape(-1, 2), axis=0).max())
    seam = np.abs(ends[first] - ends[second][:, ::-1]).max((1, 2)) > tolerance
    assert (first % m != second % m).all(), "a triangle has no edge twice"
    return first, second, seam


def _panels(count: int, a: Indices, b: Indices, uv: Floats) -> Indices:
    """Returns the panel of every triangle; panel 0 has the largest area in uv.

    count : number of triangles
    a, b : the two triangles at each interior edge that is not on a seam
    uv : (count x 3 x 2) corners of the triangles in the pattern [m]
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    links = coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count))
    number, label = connected_components(links, directed=False)
    e, f = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = np.bincount(label, np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]), minlength=number)
    rank = np.empty(number, np.int64)
    rank[np.argsort(-area, kind="stable")] = np.arange(number)
    ranked: Indices = rank[label]
    return ranked


def _check_closed_seams(mesh: TriangleMesh, triangles: Indices, where: str) -> None:
    border = np.array([v for loop in boundary_loops(triangles) for v in loop], np.int64)
    places = np.round(np.asarray(mesh.vertices)[border] / (1e-6 * mesh.mean_edge))
    _, first, uses = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    double = np.flatnonzero(uses > 1)
    if len(double):
        a, b = border[np.flatnonzero(first.ravel() == double[0])[:2]]
        raise InvalidInput(
            f"{where}: {len(double)} seam points are open, first vertices {a} and {b} at the same"
            " place; weld them so that the panels share vertices and differ in uv only"
        )
