"""The surfaces of a run: its cloths, rigid bodies and obstacles, one by one."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Frame, FrameTopology

__all__ = ["Floats", "Indices", "Surface", "surfaces_of", "vertex_normals"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Colours of bodies and of the poles of magnets in linear RGB, as in renderer/surface_shaders.cpp.
_BODY = np.array([0.46, 0.45, 0.44])
_NORTH = np.array([0.55, 0.05, 0.04])
_SOUTH = np.array([0.04, 0.12, 0.50])


@dataclass(frozen=True)
class Surface:
    """A cloth, rigid body or obstacle of a run."""

    name: str  # as in the scene
    identifier: str  # made of letters, digits and _; unique within the run
    is_cloth: bool
    vertices: slice  # its rows in the arrays of a frame
    triangles: Indices  # (m x 3) indices of its own vertices
    uv: Floats  # (k x 2) rest coordinates [m]; no rows for bodies
    uv_triangles: Indices  # (m x 3) indices into uv; no rows for bodies
    colors: Floats  # (c x 3) linear RGB of its materials
    material: Indices  # (m) index into colors

    def positions(self, frame: Frame) -> Floats:
        """Returns its vertices (n x 3) in a frame [m]."""
        every = frame.positions if self.is_cloth else frame.body_vertices
        return every[self.vertices]


def surfaces_of(topology: FrameTopology) -> list[Surface]:
    """Returns the surfaces of a run: cloths first, then rigid bodies, then obstacles."""
    taken: set[str] = set()
    cloths = [_cloth(topology, i, taken) for i in range(len(topology.cloth_names))]
    return cloths + [_body(topology, i, taken) for i in range(len(topology.body_names))]


def vertex_normals(points: Floats, triangles: Indices) -> Floats:
    """Returns unit normals (n x 3) of vertices: means over their triangles, weighted by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros(points.shape)
    for k in range(3):
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, k], faces[:, axis], len(points))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 0.0, normals / np.where(length > 0.0, length, 1.0), (0.0, 0.0, 1.0))


def _cloth(topology: FrameTopology, index: int, taken: set[str]) -> Surface:
    name = topology.cloth_names[index]
    mine = np.flatnonzero(topology.cloth_of_triangle == index)
    rows = _rows(topology.cloth_of_vertex, index)
    triangles = topology.triangles[mine].astype(np.int64) - rows.start
    corners = (3 * mine[:, None] + np.arange(3)).ravel()
    uv, uv_triangles = _uv_table(triangles, topology.corner_uv[corners])
    return Surface(
        name=name,
        identifier=_identifier(name, f"cloth{index}", taken),
        is_cloth=True,
        vertices=rows,
        triangles=triangles,
        uv=uv,
        uv_triangles=uv_triangles,
        colors=np.asarray([_core.cloth_color(index)], np.float64),
        material=np.zeros(len(mine), np.int64),
    )


def _body(topology: FrameTopology, index: int, taken: set[str]) -> Surface:
    name = topology.body_names[index]
    rows = _rows(topology.body_of_vertex, index)
    mine = topology.body_of_triangle == index
    triangles = topology.body_triangles[mine].astype(np.int64) - rows.start
    colors = np.array([_BODY * (1.0 - 0.07 * (index % 3)), _NORTH, _SOUTH])
    material = np.zeros(len(triangles), np.int64)
    if len(topology.body_pole):
        pole = topology.body_pole[rows][triangles].mean(1)
        material[pole > 0.03] = 1
        material[pole < -0.03] = 2
    used, material = np.unique(material, return_inverse=True)
    return Surface(
        name=name,
        identifier=_identifier(name, f"body{index}", taken),
        is_cloth=False,
        vertices=rows,
        triangles=triangles,
        uv=np.empty((0, 2)),
        uv_triangles=np.empty((0, 3), np.int64),
        colors=colors[used],
        material=material.reshape(-1),
    )


def _rows(owner: NDArray[Any], index: int) -> slice:
    """Returns the rows of an owner; all vertices of a surface are stored one after another."""
    mine = np.flatnonzero(owner == index)
    return slice(int(mine[0]), int(mine[-1]) + 1)


def _uv_table(triangles: Indices, corner_uv: Floats) -> tuple[Floats, Indices]:
    """Joins corners of the same vertex with the same uv, and orders uv by their vertices."""
    keys = np.column_stack([triangles.reshape(-1), corner_uv])
    table, index = np.unique(keys, axis=0, return_inverse=True)
    return table[:, 1:], index.reshape(-1, 3)


def _identifier(name: str, default: str, taken: set[str]) -> str:
    base = re.sub(r"[^A-Za-z0-9_]", "_", name) or default
    base = f"_{base}" if base[0].isdigit() else base
    made, number = base, 2
    while made.lower() in taken:
        made, number = f"{base}_{number}", number + 1
    taken.add(made.lower())
    return made
