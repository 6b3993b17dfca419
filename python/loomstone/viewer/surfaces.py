"""The surfaces of a frame as meshes of a web page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import _core
from .._core import Frame, FrameTopology
from ..exchange.surfaces import (
    Bytes,
    Floats,
    Surface,
    srgb,
    surfaces_of,
    texture_at_vertices,
)
from ..pictures.color_maps import color_table

__all__ = ["FIELDS", "Surfaces"]

FIELDS = ("cloth", "stretch", "strain_weft", "strain_warp", "strain_shear", "contact")

_FLOOR = (226, 224, 218)  # sRGB, close to the backdrop of pictures


class Surfaces:
    """The cloths, bodies and obstacles of a run as nodes of a page.

    server : viser.ViserServer
    topology : topology of the frames
    """

    def __init__(self, server: Any, topology: FrameTopology) -> None:
        self._server, self._topology = server, topology
        self._surfaces = {
            f"/{'cloth' if surface.is_cloth else 'body'}/{surface.name}": surface
            for surface in surfaces_of(topology)
        }
        self._textured = {n: _vertex_colors(surface) for n, surface in self._surfaces.items()}
        self._meshes: dict[str, Any] = {}
        self._shown: dict[str, Floats] = {}
        self._colors: dict[str, Bytes | None] = {}  # colours of vertices; None: one colour
        self._listeners: dict[str, Callable[[Any], None]] = {}

    @property
    def cloth_nodes(self) -> list[Any]:
        """The nodes of the cloths in the order of the scene."""
        return [self._meshes[name] for name, each in self._surfaces.items() if each.is_cloth]

    @property
    def body_nodes(self) -> list[Any]:
        """The nodes of the rigid bodies, followed by those of the obstacles."""
        return [self._meshes[name] for name, each in self._surfaces.items() if not each.is_cloth]

    def on_drag(self, node: Any, listener: Callable[[Any], None]) -> None:
        """Makes a node call a function with each viser.SceneNodeDragEvent of the left button."""
        self._listeners[node.name] = listener
        self._listen(node)

    def _listen(self, node: Any) -> None:
        """Gives a new node the listener that on_drag() has set for a node of this name, if any."""
        if node.name in self._listeners:
            node.on_drag("left")(self._listeners[node.name])

    def show(
        self, frame: Frame, field: str = "cloth", limits: tuple[float, float] = (0, 1)
    ) -> None:
        """Shows a frame. `field` is one of FIELDS; its colours span `limits`."""
        with self._server.atomic():
            colors = None
            if field != "cloth":
                colors = _colors(_core.scalar_field(field, self._topology, frame), limits)
            for name, surface in self._surfaces.items():
                points = surface.positions(frame)
                shown = self._textured[name]
                if colors is not None and surface.is_cloth:
                    shown = colors[surface.vertices]
                if shown is None:
                    self._show_plain(name, points, surface)
                else:
                    self._show_colored(name, points, surface, shown)

    def _plain_color(self, surface: Surface) -> tuple[int, ...]:
        """Returns the colour of a surface without a texture, in sRGB."""
        topology = self._topology
        if not surface.is_cloth:
            body = topology.body_names.index(surface.name)
            colored = topology.body_looks and topology.body_looks[body].color is not None
            if topology.body_is_floor[body] and not colored:
                return _FLOOR
        return tuple(map(int, srgb(surface.colors[0])))

    def _show_plain(self, name: str, points: Floats, surface: Surface) -> None:
        if self._colors.get(name, points) is not None:
            self._meshes[name] = self._server.scene.add_mesh_simple(
                name,
                points.astype(np.float32),
                surface.triangles.astype(np.int32),
                color=self._plain_color(surface),
                side="double",
            )
            self._colors[name] = None
            self._listen(self._meshes[name])
        elif not np.array_equal(self._shown[name], points):
            self._meshes[name].vertices = points.astype(np.float32)
        self._shown[name] = points

    def _show_colored(self, name: str, points: Floats, surface: Surface, colors: Bytes) -> None:
        import trimesh

        if self._colors.get(name) is colors and np.array_equal(self._shown[name], points):
            return
        mesh = trimesh.Trimesh(points, surface.triangles, vertex_colors=colors, process=False)
        content = mesh.export(file_type="glb")
        if self._colors.get(name) is not None:
            self._meshes[name].glb_data = content
        else:
            self._meshes[name] = self._server.scene.add_glb(name, content)
            self._listen(self._meshes[name])
        self._colors[name], self._shown[name] = colors, points


def _vertex_colors(surface: Surface) -> Bytes | None:
    """Returns the texture's colours, opaque, at the vertices (n x 4); None without a texture."""
    colors = texture_at_vertices(surface)
    return None if colors is None else np.pad(colors, ((0, 0), (0, 1)), constant_values=255)


def _colors(values: Floats, limits: tuple[float, float]) -> Bytes:
    """Returns the sRGB colours of values, with alpha (n x 4)."""
    low, high = limits
    place = np.clip((values - low) / max(high - low, 1e-12), 0.0, 1.0)
    colors = color_table("viridis")[0][np.rint(255.0 * place).astype(int)]
    return np.concatenate([colors, np.full((len(colors), 1), 255, np.uint8)], axis=1)
