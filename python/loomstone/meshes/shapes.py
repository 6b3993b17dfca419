"""Meshes from numbers and files. Flat cloth lies in z = 0, centred at the origin, weft along x;
solids are centred.

Quality unstructured meshes are Delaunay triangulations of points relaxed by Lloyd's iteration:
boundary points are fixed and evenly spaced, interior points start at random and move to the centre
of their surroundings.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from . import planar
from .._core import InvalidInput, TriangleMesh
from ..base.arguments import explained, vector, whole

__all__ = [
    "box",
    "capsule",
    "cylinder",
    "disc",
    "floor",
    "funnel",
    "grid",
    "irregular",
    "nearest_vertices",
    "quality",
    "read_mesh",
    "sphere",
    "strip",
    "wave_bar",
    "write_mesh",
]

MOST_TRIANGLES = 100_000_000

Floats = NDArray[np.float64]


@explained
def grid(
    *,
    size: tuple[float, float] = (0.5, 0.5),
    triangles: int | None = None,
    cells: tuple[int, int] | None = None,
    pattern: str = "alternating",
) -> TriangleMesh:
    """Regular rectangle.

    size : width and height [m]
    triangles : about how many, in square cells; or give
    cells : (columns, rows), two triangles a cell; vertex j (columns + 1) + i is at column i, row j
    pattern : diagonals "alternating" like a checkerboard, or all "diagonal"

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


@explained
def irregular(
    *, size: tuple[float, float] = (0.5, 0.5), triangles: int, seed: int = 1
) -> TriangleMesh:
    """Quality unstructured rectangle of exactly `triangles` triangles (rounded to the parity of its
    boundary).

    size : width and height [m]; seed : of the random start points

    >>> mesh = irregular(size=(0.5, 0.5), triangles=500)
    >>> quality(mesh)["min_angle_degrees"] > 20
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

    return _relaxed(outline, depth, (width, height), edge, triangles, seed)


@explained
def strip(*, length: float, width: float, triangles: int, seed: int | None = None) -> TriangleMesh:
    """Strip of `length` along x and `width` along y [m]: a grid, or quality unstructured where a
    seed is given.
    """
    if seed is None:
        return grid(size=(length, width), triangles=triangles)
    return irregular(size=(length, width), triangles=triangles, seed=seed)


@explained
def disc(*, radius: float = 0.5, triangles: int, seed: int = 1) -> TriangleMesh:
    """Quality unstructured disc.

    radius : [m]; triangles : exactly as many (rounded to the parity of its boundary); seed : of the
        start points
    """
    _check("disc", "radius", radius)
    edge = _edge_length(np.pi * radius**2, triangles)
    angle = np.arange(n := max(6, round(2 * np.pi * radius / edge))) * 2 * np.pi / n
    outline = radius * np.c_[np.cos(angle), np.sin(angle)]
    inner = radius * np.cos(np.pi / n)

    def depth(points: Floats) -> Floats:
        distance: Floats = inner - np.linalg.norm(points, axis=1)
        return distance

    return _relaxed(outline, depth, (2 * radius, 2 * radius), edge, triangles, seed)


@explained
def sphere(*, radius: float, subdivisions: int = 4) -> TriangleMesh:
    """Icosphere of 20 * 4**subdivisions triangles, radius [m]."""
    return _core.icosphere(radius, subdivisions=subdivisions)


@explained
def box(*, size: tuple[float, float, float], cells_per_side: int = 1) -> TriangleMesh:
    """Box with the given sides [m]."""
    return _core.box(*vector("size", size, 3), cells_per_side=cells_per_side)


@explained
def capsule(*, radius: float, length: float, segments: int = 32) -> TriangleMesh:
    """Capsule along z; `length` between the centres of its caps [m]."""
    return _core.capsule(radius, length, segments=segments)


@explained
def cylinder(*, radius: float, length: float, segments: int = 32) -> TriangleMesh:
    """Cylinder along z [m]: a prism of `segments` sides with its corners on the cylinder.

    Up to 16 sides it is a rigid body's polyhedron, whose contacts are exact.
    """
    return _core.cylinder(radius, length, segments=segments)


@explained
def funnel(
    *,
    top_radius: float,
    bottom_radius: float,
    height: float,
    tube_length: float,
    wall: float,
    segments: int = 64,
) -> TriangleMesh:
    """Cone from top_radius at z = height to bottom_radius at z = 0, then a tube below; closed, with
    a wall [m].
    """
    return _core.funnel(top_radius, bottom_radius, height, tube_length, wall, segments=segments)


@explained
def wave_bar(
    *, length: float, radius: float, amplitude: float, wavelength: float, segments: int = 24
) -> TriangleMesh:
    """Tube along y whose centre line waves in z [m]."""
    return _core.wave_bar(length, radius, amplitude, wavelength, segments=segments)


@explained
def floor(*, size: float = 4.0, cells: int = 8) -> TriangleMesh:
    """Open square in z = 0 with normal +z, size [m]."""
    return _core.floor_square(size, cells=cells)


@explained
def read_mesh(path: str | os.PathLike[str], *, with_uv: bool = True) -> TriangleMesh:
    """TriangleMesh from a file: OBJ and PLY by loomstone itself, other formats by meshio where it
    is installed.

    with_uv : False leaves texture coordinates out; obstacles and bodies need none
    """
    path = Path(path)
    if path.suffix.lower() in (".obj", ".ply"):
        return _core.read_mesh(str(path), with_uv=with_uv)
    try:
        import meshio
    except ImportError:
        raise _core.Unsupported(
            f"{path}: formats other than .obj and .ply are read by meshio, which is not installed;"
            " pip install meshio"
        ) from None
    try:
        content = meshio.read(path)
    except (meshio.ReadError, OSError, SystemExit) as error:
        raise _core.CacheError(f"{path}: cannot be read as a mesh: {error}") from error
    faces = content.get_cells_type("triangle")
    if len(faces) == 0:
        raise InvalidInput(
            f"{path}: must contain triangles, got cells of {[c.type for c in content.cells]}"
        )
    return TriangleMesh(np.c_[content.points, np.zeros((len(content.points), 3))][:, :3], faces)


@explained
def write_mesh(path: str | os.PathLike[str], mesh: TriangleMesh) -> None:
    """Writes OBJ or PLY, by the path's ending; other formats by meshio where it is installed."""
    path = Path(path)
    if path.suffix.lower() in (".obj", ".ply"):
        _core.write_mesh(str(path), mesh)
        return
    try:
        import meshio
    except ImportError:
        raise _core.Unsupported(
            f"{path}: formats other than .obj and .ply are written by meshio, which is not"
            " installed; pip install meshio"
        ) from None
    try:
        meshio.write(path, meshio.Mesh(mesh.vertices, [("triangle", mesh.triangles)]))
    except (
        meshio.ReadError,
        meshio.WriteError,
        SystemExit,
    ) as error:  # a ReadError where it does not know the ending
        raise InvalidInput(
            f"{path}: must end in .obj, .ply or what meshio writes, as .stl, .off or .vtk: {error}"
        ) from None
    except OSError as error:
        raise _core.CacheError(f"{path}: cannot be written: {error.strerror or error}") from error


def nearest_vertices(mesh: TriangleMesh, points: ArrayLike) -> list[int]:
    """Index of the vertex nearest to each point; points (k x 3) [m]."""
    from scipy.spatial import cKDTree  # imported where needed: the command line starts faster

    _, index = cKDTree(mesh.vertices).query(np.asarray(points, float).reshape(-1, 3))
    return [int(i) for i in index]


def quality(mesh: TriangleMesh) -> dict[str, float]:
    """Smallest and median angle [degrees] and ratio of largest to smallest area [1]."""
    corners = mesh.vertices[mesh.triangles]
    sides = np.roll(corners, -1, 1) - corners
    length = np.linalg.norm(sides, axis=2)
    cosine = -np.einsum("tij,tij->ti", sides, np.roll(sides, 1, 1)) / (
        length * np.roll(length, 1, 1)
    )
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1))).min(1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    return {
        "min_angle_degrees": float(angles.min()),
        "median_angle_degrees": float(np.median(angles)),
        "area_ratio": float(area.max() / area.min()),
    }


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
    return float(np.sqrt(area / triangles * 4 / np.sqrt(3)))  # equilateral


def _relaxed(
    outline: Floats, depth, box: tuple[float, float], edge: float, triangles: int, seed: int
) -> TriangleMesh:  # type: ignore[no-untyped-def]
    """Euler's formula gives triangles = 2 interior + boundary - 2 on a convex outline, so the count
    is met.
    """
    random = np.random.default_rng(seed)
    n_interior = max(0, (triangles + 2 - len(outline)) // 2)
    interior = np.empty((0, 2))
    spacing = edge
    while len(interior) < n_interior:  # jittered hexagonal lattice, dense enough
        rows = np.arange(-box[1] / 2, box[1] / 2 + spacing, spacing * np.sqrt(3) / 2)
        columns = np.arange(-box[0] / 2, box[0] / 2 + spacing, spacing)
        lattice = np.array(
            [(c + (r % 2) * spacing / 2, y) for r, y in enumerate(rows) for c in columns]
        )
        lattice += random.uniform(-0.35, 0.35, lattice.shape) * spacing
        interior = lattice[depth(lattice) > 0.45 * spacing]
        spacing *= 0.98
    interior = interior[np.sort(random.permutation(len(interior))[:n_interior])]
    for _ in range(30):
        points = np.concatenate([outline, interior])
        interior = planar.centres(points, _faces(points, edge))[len(outline) :]
    points = np.concatenate([outline, interior])
    return TriangleMesh(np.c_[points, np.zeros(len(points))], _faces(points, edge), points)


def _faces(points: Floats, edge: float) -> NDArray[np.int32]:
    return np.ascontiguousarray(planar.delaunay(points, 1e-6 * edge**2), np.int32)
