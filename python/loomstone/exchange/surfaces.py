"""The surfaces of a run: each of its cloths, rigid bodies and obstacles."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Frame, FrameTopology, Look

__all__ = ["Bytes", "Floats", "Indices", "Surface", "linear_rgb", "png_bytes", "srgb",
           "surfaces_of", "texture_at_vertices", "uv_table", "vertex_colors",
           "vertex_normals"]  # fmt: skip

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Bytes = NDArray[np.uint8]

# Colours of the poles of magnets in linear RGB, as in renderer/surface_shaders.cpp.
_NORTH = np.array([0.55, 0.05, 0.04])
_SOUTH = np.array([0.04, 0.12, 0.50])


@dataclass(frozen=True)
class Surface:
    """A cloth, rigid body or obstacle of a run."""

    name: str  # name of the surface in the scene
    identifier: str  # made of letters, digits and _; unique within the run
    is_cloth: bool
    vertices: slice  # its rows in the arrays of a frame
    triangles: Indices  # (m x 3) vertex indices, counted from its first vertex
    uv: Floats  # (k x 2) uv at rest [m]; no rows for a body or obstacle without a texture
    uv_triangles: Indices  # (m x 3) indices into uv; no rows if uv has none
    colors: Floats  # (c x 3) linear RGB of its materials
    material: Indices  # (m) index into colors
    roughness: float  # [1]
    texture: Bytes | None  # (height x width x 3) sRGB image that replaces colors[0]; None: no image
    repeats: bool  # whether the texture repeats; otherwise, its border continues outside of it
    texture_uv: Floats  # (k x 2) uv in units of the image's size; no rows if the look has no image

    def positions(self, frame: Frame) -> Floats:
        """Returns the vertices of the surface (n x 3) in a frame [m]."""
        every = frame.positions if self.is_cloth else frame.body_vertices
        return every[self.vertices]


def surfaces_of(topology: FrameTopology) -> list[Surface]:
    """Returns the surfaces of a run: cloths first, then rigid bodies, then obstacles."""
    taken: set[str] = set()
    cloths = [_cloth(topology, i, taken) for i in range(len(topology.cloth_names))]
    return cloths + [_body(topology, i, taken) for i in range(len(topology.body_names))]


def vertex_normals(points: Floats, triangles: Indices) -> Floats:
    """Returns unit normals (n x 3) of vertices.

    Each has the direction of the area-weighted mean of the normals of the vertex's triangles, or
    (0, 0, 1) if this mean vanishes.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros(points.shape)
    for k in range(3):
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, k], faces[:, axis], len(points))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 0.0, normals / np.where(length > 0.0, length, 1.0), (0.0, 0.0, 1.0))


def png_bytes(image: Bytes) -> bytes:
    """Returns an image (height x width x 3) as the content of a PNG file."""
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(image).save(content, "PNG")
    return content.getvalue()


def srgb(linear: Any) -> Bytes:
    """Returns linear RGB as bytes in sRGB."""
    color = np.asarray(linear, float)
    curve = np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1.0 / 2.4) - 0.055)
    return np.rint(255.0 * np.clip(curve, 0.0, 1.0)).astype(np.uint8)


def linear_rgb(bytes_: Bytes) -> Floats:
    """Returns bytes in sRGB as linear RGB."""
    color = np.asarray(bytes_, float) / 255.0
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def texture_at_vertices(surface: Surface) -> Bytes | None:
    """Returns the colours (n x 3) of the texture at the vertices, or None without a texture.

    Colours at the border of the bounding box of uv are taken just inside the border.
    """
    if surface.texture is None:
        return None
    uv = surface.texture_uv
    middle = 0.5 * (uv.min(0) + uv.max(0))
    at = np.zeros((surface.vertices.stop - surface.vertices.start, 2))
    at[surface.triangles] = (middle + (1.0 - 1e-9) * (uv - middle))[surface.uv_triangles]
    height, width = surface.texture.shape[:2]
    column = np.floor((at[:, 0] % 1.0) * width).astype(int).clip(0, width - 1)
    row = np.floor(((1.0 - at[:, 1]) % 1.0) * height).astype(int).clip(0, height - 1)
    return np.asarray(surface.texture[row, column])


def vertex_colors(surface: Surface) -> Bytes:
    """Returns the sRGB colours (n x 3) of the vertices.

    Without a texture, the colour of a vertex is the mean of the colours of its triangles. This mean
    is taken in linear RGB.
    """
    shown = texture_at_vertices(surface)
    if shown is not None:
        return shown
    n = surface.vertices.stop - surface.vertices.start
    corners = surface.triangles.reshape(-1)
    colors = np.repeat(surface.colors[surface.material], 3, axis=0)
    count = np.maximum(np.bincount(corners, minlength=n), 1)
    sums = [np.bincount(corners, colors[:, k], n) for k in range(3)]
    return srgb(np.column_stack(sums) / count[:, None])


def _cloth(topology: FrameTopology, index: int, taken: set[str]) -> Surface:
    name = topology.cloth_names[index]
    mine = np.flatnonzero(topology.cloth_of_triangle == index)
    rows = _rows(topology.cloth_of_vertex, index)
    triangles = topology.triangles[mine].astype(np.int64) - rows.start
    corners = (3 * mine[:, None] + np.arange(3)).ravel()
    uv, uv_triangles = uv_table(triangles, topology.corner_uv[corners])
    look = topology.cloth_looks[index] if topology.cloth_looks else Look()
    color = np.asarray(_core.shown_color(look, _core.cloth_color(index)), float)
    return Surface(
        name=name,
        identifier=_identifier(name, f"cloth{index}", taken),
        is_cloth=True,
        vertices=rows,
        triangles=triangles,
        uv=uv,
        uv_triangles=uv_triangles,
        colors=color[None],
        material=np.zeros(len(mine), np.int64),
        roughness=0.9 if look.roughness is None else look.roughness,
        texture=_image(look, color),
        repeats=look.texture_width > 0.0,
        texture_uv=_texture_uv(look, uv),
    )


def _body(topology: FrameTopology, index: int, taken: set[str]) -> Surface:
    name = topology.body_names[index]
    rows = _rows(topology.body_of_vertex, index)
    mine = topology.body_of_triangle == index
    triangles = topology.body_triangles[mine].astype(np.int64) - rows.start
    look = topology.body_looks[index] if topology.body_looks else Look()
    color = np.asarray(_core.shown_color(look, _core.body_color(index)), float)
    colors = np.array([color, _NORTH, _SOUTH])
    material = np.zeros(len(triangles), np.int64)
    if len(topology.body_pole):
        pole = topology.body_pole[rows][triangles].mean(1)
        material[pole > 0.03] = 1
        material[pole < -0.03] = 2
    used, material = np.unique(material, return_inverse=True)
    uv, uv_triangles = np.empty((0, 2)), np.empty((0, 3), np.int64)
    if look.texture is not None:
        corners = (3 * np.flatnonzero(mine)[:, None] + np.arange(3)).ravel()
        uv, uv_triangles = uv_table(triangles, topology.body_corner_uv[corners])
    return Surface(
        name=name,
        identifier=_identifier(name, f"body{index}", taken),
        is_cloth=False,
        vertices=rows,
        triangles=triangles,
        uv=uv,
        uv_triangles=uv_triangles,
        colors=colors[used],
        material=material.reshape(-1),
        roughness=0.6 if look.roughness is None else look.roughness,
        texture=_image(look, color) if used[0] == 0 else None,
        repeats=look.texture_width > 0.0,
        texture_uv=_texture_uv(look, uv),
    )


def _image(look: Look, color: Floats) -> Bytes | None:
    """Returns the texture of a look, blended with `color` where it is transparent, or None if the
    look has no texture.
    """
    if look.texture is None:
        return None
    share = look.texture[..., 3:] / 255.0
    mixed = share * look.texture[..., :3] + (1.0 - share) * srgb(color)
    return np.rint(mixed).astype(np.uint8)


def _texture_uv(look: Look, uv: Floats) -> Floats:
    """Returns uv in units of the texture's size, or no rows if the look has no texture.

    The texture is placed as in rendered pictures.
    """
    if look.texture is None:
        return np.empty((0, 2))
    if look.texture_width > 0.0:
        height, width = look.texture.shape[:2]
        return np.asarray(uv / (look.texture_width * np.array([1.0, height / width])))
    low, size = uv.min(0), np.ptp(uv, axis=0)
    return np.asarray((uv - low) / np.where(size > 0.0, size, 1.0))


def _rows(owner: NDArray[Any], index: int) -> slice:
    """Returns the slice of rows whose owner is `index`. These rows must be contiguous."""
    mine = np.flatnonzero(owner == index)
    return slice(int(mine[0]), int(mine[-1]) + 1)


def uv_table(triangles: Indices, corner_uv: Floats) -> tuple[Floats, Indices]:
    """Returns a table of uv (k x 2), and the table's row for each corner of the triangles (m x 3).

    Corners of the same vertex with the same uv share a row. The rows are ordered by vertex.
    """
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
