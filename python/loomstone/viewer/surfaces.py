"""The surfaces of a frame as meshes of a web page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Frame, FrameTopology

__all__ = ["FIELDS", "Surfaces", "field_values"]

Floats = NDArray[np.float64]
Part = tuple[str, NDArray[Any], NDArray[np.int32]]  # name, vertices, triangles among these

FIELDS = ("cloth", "stretch", "strain_weft", "strain_warp", "strain_shear", "contact")

# Colours in sRGB, close to those of the renderer (renderer/surface_shaders.cpp).
_BODY = (190, 186, 178)
_FLOOR = (226, 224, 218)


def field_values(topology: FrameTopology, frame: Frame, field: str) -> Floats:
    """Returns the values (n) of a field at the cloth vertices of a frame.

    Values of triangles are averaged at their vertices. Strains are U - I, as for strain limits.
    """
    if field == "contact":
        return frame.contact.astype(float)
    if field == "stretch":
        of_triangles = frame.stretch[:, 0] if frame.stretch.ndim == 2 else frame.stretch
    else:
        # Green strain E and the stretch U are related by U^2 = I + 2 E.
        green = frame.strain
        squared = np.empty((len(green), 2, 2))
        squared[:, 0, 0] = 1.0 + 2.0 * green[:, 0]
        squared[:, 1, 1] = 1.0 + 2.0 * green[:, 1]
        squared[:, 0, 1] = squared[:, 1, 0] = 2.0 * green[:, 2]
        size, axes = np.linalg.eigh(squared)
        stretch = np.einsum("kij,kj,klj->kil", axes, np.sqrt(np.maximum(size, 0.0)), axes)
        row, column = {"strain_weft": (0, 0), "strain_warp": (1, 1), "strain_shear": (0, 1)}[field]
        of_triangles = stretch[:, row, column] - (1.0 if row == column else 0.0)
    corners = topology.triangles.ravel()
    total = np.bincount(corners, np.repeat(of_triangles, 3), minlength=len(frame.positions))
    count = np.bincount(corners, minlength=len(frame.positions))
    return np.asarray(total / np.maximum(count, 1))


class Surfaces:
    """The cloths, bodies and obstacles of a run as nodes of a page.

    server : viser.ViserServer
    topology : topology of the frames
    """

    def __init__(self, server: Any, topology: FrameTopology) -> None:
        self._server, self._topology = server, topology
        self._cloths = _parts(
            topology.cloth_names, topology.cloth_of_vertex, topology.triangles, "/cloth"
        )
        self._bodies = _parts(
            topology.body_names, topology.body_of_vertex, topology.body_triangles, "/body"
        )
        self._meshes: dict[str, Any] = {}
        self._shown: dict[str, Floats] = {}
        self._colored: dict[str, bool] = {}
        self._listeners: dict[str, Callable[[Any], None]] = {}

    @property
    def cloth_nodes(self) -> list[Any]:
        """The nodes of the cloths in the order of the scene."""
        return [self._meshes[name] for name, _, _ in self._cloths]

    @property
    def body_nodes(self) -> list[Any]:
        """The nodes of the rigid bodies, followed by those of the obstacles."""
        return [self._meshes[name] for name, _, _ in self._bodies]

    def on_drag(self, node: Any, listener: Callable[[Any], None]) -> None:
        """Calls a function with every event (viser.SceneNodeDragEvent) of a drag at a node."""
        self._listeners[node.name] = listener
        self._listen(node)

    def _listen(self, node: Any) -> None:
        """A node that replaces another one takes over its listener."""
        if node.name in self._listeners:
            node.on_drag("left")(self._listeners[node.name])

    def show(
        self, frame: Frame, field: str = "cloth", limits: tuple[float, float] = (0, 1)
    ) -> None:
        """Shows a frame. `field` is one of FIELDS; its colours span `limits`."""
        with self._server.atomic():
            colors = None
            if field != "cloth":
                colors = _colors(field_values(self._topology, frame, field), limits)
            for i, (name, vertices, triangles) in enumerate(self._cloths):
                points = frame.positions[vertices]
                if colors is None:
                    self._show_plain(name, points, triangles, _cloth_color(i))
                else:
                    self._show_colored(name, points, triangles, colors[vertices])
            floors = self._topology.body_is_floor
            for i, (name, vertices, triangles) in enumerate(self._bodies):
                color = _FLOOR if floors[i] else _BODY
                self._show_plain(name, frame.body_vertices[vertices], triangles, color)

    def _show_plain(
        self, name: str, points: Floats, triangles: NDArray[np.int32], color: tuple[int, ...]
    ) -> None:
        if self._colored.get(name, True):
            self._meshes[name] = self._server.scene.add_mesh_simple(
                name, points.astype(np.float32), triangles, color=color, side="double"
            )
            self._colored[name] = False
            self._listen(self._meshes[name])
        elif not np.array_equal(self._shown[name], points):
            self._meshes[name].vertices = points.astype(np.float32)
        self._shown[name] = points

    def _show_colored(
        self, name: str, points: Floats, triangles: NDArray[np.int32], colors: NDArray[np.uint8]
    ) -> None:
        import trimesh

        mesh = trimesh.Trimesh(points, triangles, vertex_colors=colors, process=False)
        content = mesh.export(file_type="glb")
        if self._colored.get(name, False):
            self._meshes[name].glb_data = content
        else:
            self._meshes[name] = self._server.scene.add_glb(name, content)
            self._colored[name] = True
            self._listen(self._meshes[name])
        self._shown[name] = points


def _parts(
    names: list[str], of_vertex: NDArray[np.int32], triangles: NDArray[np.int32], folder: str
) -> list[Part]:
    parts: list[Part] = []
    for i, name in enumerate(names):
        vertices = np.flatnonzero(of_vertex == i)
        own = triangles[of_vertex[triangles[:, 0]] == i] if len(triangles) else triangles
        parts.append(
            (f"{folder}/{name or i}", vertices, np.searchsorted(vertices, own).astype(np.int32))
        )
    return parts


def _cloth_color(cloth: int) -> tuple[int, ...]:
    """Returns the colour of a cloth in pictures, in sRGB."""
    encoded = 255.0 * np.ravel(_core.cloth_color(cloth)) ** (1.0 / 2.2)
    return tuple(int(value) for value in np.rint(encoded))


def _colors(values: Floats, limits: tuple[float, float]) -> NDArray[np.uint8]:
    from matplotlib import colormaps

    low, high = limits
    place = np.clip((values - low) / max(high - low, 1e-12), 0.0, 1.0)
    return np.asarray(colormaps["viridis"](place, bytes=True))
