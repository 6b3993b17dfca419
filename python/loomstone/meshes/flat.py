"""Flat cloth in z = 0, centred at the origin, weft along x: grids and unstructured meshes.

Unstructured meshes are Delaunay triangulations of points relaxed by Lloyd's iteration [Lloyd1982].
Boundary points do not move, and are evenly spaced along each side. Interior points start on a
jittered hexagonal lattice and move repeatedly to the centroid of their neighbouring triangles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import InvalidInput, TriangleMesh
from ..base.arguments import takes, vector, whole
from .relaxation import relaxed

__all__ = ["disc", "grid", "irregular", "strip"]

MOST_TRIANGLES = 100_000_000

Floats = NDArray[np.float64]


@takes(size="m")
def grid(
    *,
    size: tuple[float, float] = (0.5, 0.5),
    triangles: int | None = None,
    cells: tuple[int, int] | None = None,
    pattern: str = "alternating",
) -> TriangleMesh:
    """Rectangle with a regular mesh.

    size : width and height [m]
    triangles : approximate number of triangles, in nearly square cells; an alternative to `cells`
    cells : (columns, rows), with two triangles per cell; vertex j (columns + 1) + i is at column i,
        row j
    pattern : "alternating" for diagonals that alternate like a checkerboard, or "diagonal" for
        diagonals that are all parallel

    Raises InvalidInput for values out of range, and if both or neither of `triangles` and `cells`
    are given.

    >>> grid(size=(0.5, 0.5), cells=(4, 4)).n_triangles
    32
    """
    width, height = _size(size)
    if (triangles is None) == (cells is None):
        raise InvalidInput(
            f"grid: give either triangles or cells, got triangles={triangles}, cells={cells}"
        )
    if cells is not None:
        columns, rows = (whole("cells", n, 1, 20_000) for n in vector("cells", cells, 2).tolist())
        return _core.grid_cells(width, height, columns, rows, pattern=pattern)
    return _core.grid(
        width, height, whole("triangles", triangles, 2, MOST_TRIANGLES), pattern=pattern
    )


@takes(size="m")
def irregular(
    *, size: tuple[float, float] = (0.5, 0.5), triangles: int, seed: int = 1
) -> TriangleMesh:
    """Rectangle with an unstructured mesh of `triangles` triangles.

    There is one triangle fewer if the parity of the number of boundary points requires it. A narrow
    rectangle has more triangles if its boundary points alone make more than `triangles`.

    size : width and height [m]
    seed : seed of the random initial points

    >>> import loomstone as ls
    >>> mesh = irregular(size=(0.5, 0.5), triangles=500)
    >>> ls.meshes.quality(mesh)["min_angle_degrees"] > 20
    True
    """
    width, height = _size(size)
    edge = _edge_length(width * height, triangles)
    nx, ny = max(1, round(width / edge)), max(1, round(height / edge))
    x, y = np.linspace(-width / 2, width / 2, nx + 1), np.linspace(-height / 2, height / 2, ny + 1)
    outline = np.concatenate(
        [
            np.c_[x[:-1], np.full(nx, -height / 2)],
            np.c_[np.full(ny, width / 2), y[:-1]],
            np.c_[x[:0:-1], np.full(nx, height / 2)],
            np.c_[np.full(ny, -width / 2), y[:0:-1]],
        ]
    )

    def depth(points: Floats) -> Floats:
        return np.minimum(width / 2 - np.abs(points[:, 0]), height / 2 - np.abs(points[:, 1]))

    return relaxed(outline, depth, (width, height), edge, triangles, seed)


@takes(length="m", width="m")
def strip(*, length: float, width: float, triangles: int, seed: int | None = None) -> TriangleMesh:
    """Strip of `length` along x and `width` along y [m].

    It is a grid, or an unstructured mesh if a seed is given.
    """
    if seed is None:
        return grid(size=(length, width), triangles=triangles)
    return irregular(size=(length, width), triangles=triangles, seed=seed)


@takes(radius="m")
def disc(*, radius: float = 0.5, triangles: int, seed: int = 1) -> TriangleMesh:
    """Disc with an unstructured mesh.

    radius : distance of the boundary points from the centre [m]
    triangles : number of triangles; one fewer if the parity of the number of boundary points
        requires it, but at least 4
    seed : seed of the random initial points
    """
    _check("disc", "radius", radius)
    edge = _edge_length(np.pi * radius**2, triangles)
    angle = np.arange(n := max(6, round(2 * np.pi * radius / edge))) * 2 * np.pi / n
    outline = radius * np.c_[np.cos(angle), np.sin(angle)]
    inner = radius * np.cos(np.pi / n)

    def depth(points: Floats) -> Floats:
        distance: Floats = inner - np.linalg.norm(points, axis=1)
        return distance

    return relaxed(outline, depth, (2 * radius, 2 * radius), edge, triangles, seed)


def _check(where: str, name: str, value: float) -> None:
    if not isinstance(value, (int, float, np.number)) or not (np.isfinite(value) and value > 0):
        raise InvalidInput(f"{where}: {name} must be > 0 [m], got {value}; correct this value")


def _size(size: tuple[float, float]) -> tuple[float, float]:
    width, height = (float(s) for s in vector("size", size, 2))
    _check("size", "width", width)
    _check("size", "height", height)
    return width, height


def _edge_length(area: float, triangles: int) -> float:
    triangles = whole("triangles", triangles, 2, MOST_TRIANGLES)
    return float(np.sqrt(area / triangles * 4 / np.sqrt(3)))  # edge of equilateral triangles
