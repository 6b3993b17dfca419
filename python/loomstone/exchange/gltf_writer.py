"""Writes glTF 2.0: deforming surfaces with morph targets, moving rigid ones as animated nodes.

Cloth always counts as deforming. Other surfaces at rest are nodes without animation. glTF has y up,
so a root node rotates the scene; all other positions and poses have z up. Each frame after the
first is a morph target of every deforming surface, and linearly interpolated weights select it at
the time of the frame. Vertices that need several uv or normals are repeated. The copies follow all
other vertices, so each mesh begins with those vertices of the surface that belong to triangles, in
ascending order of their indices.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput, __version__
from .clip import Clip
from .corner_normals import corner_normals
from .extras import imported
from .motions import Motion
from .surfaces import Bytes, Floats, Indices, Surface, png_bytes, vertex_normals

__all__ = ["write_gltf"]

_LARGEST = 2**32 - 1  # largest size of a binary glTF file [bytes]
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _INDICES = 34962, 34963  # targets of buffer views
_REPEAT, _CLAMP_TO_EDGE = 10497, 33071


def write_gltf(path: Path, clip: Clip) -> None:
    """Writes a clip to a .glb file, or to a .gltf file with embedded data.

    Raises InvalidInput if the frames exceed 4 GiB, and Unsupported without the package pygltflib.
    """
    gltf = imported("pygltflib", path)
    _check_size(path, clip)
    written = _Document(gltf)
    for surface, motion in zip(clip.surfaces, clip.motions, strict=True):
        written.add(surface, motion)
    written.add_frames(clip)
    document = written.finished(clip)
    if path.suffix.lower() == ".glb":
        document.save_binary(str(path))
    else:
        document.convert_buffers(gltf.BufferFormat.DATAURI)
        document.save_json(str(path))


def _check_size(path: Path, clip: Clip) -> None:
    moving = sum(len(m.first) for m in clip.motions if not m.rigid)
    size = 24 * moving * len(clip)
    if size > _LARGEST:
        raise InvalidInput(
            f"{path}: the frames need {size / 2**30:.1f} GiB, but glTF holds at most 4 GiB; choose"
            " fewer frames (--frames, --every), or export to usd"
        )


class _Document:
    """A glTF document that is being built."""

    def __init__(self, gltf: Any) -> None:
        self._gltf = gltf
        self._made = gltf.GLTF2()
        self._made.asset = gltf.Asset(version="2.0", generator=f"loomstone {__version__}")
        # The rotation of the root node maps the z axis to the y axis, which points up in glTF.
        half = float(np.sqrt(0.5))
        root = gltf.Node(name="run", rotation=[-half, 0.0, 0.0, half], children=[])
        self._made.nodes = [root]
        self._made.scenes, self._made.scene = [gltf.Scene(nodes=[0])], 0
        self._content = bytearray()
        self._deforming: list[tuple[Surface, Motion, Indices, int]] = []
        self._rigid: list[tuple[Motion, int]] = []

    def add(self, surface: Surface, motion: Motion) -> None:
        """Adds a surface as it is in the first frame."""
        gltf, made = self._gltf, self._made
        moving = motion.rigid and not motion.still
        points = motion.local if moving else motion.first
        source, corners, normals = _split(surface, motion, points)
        attributes = gltf.Attributes(
            POSITION=self._array(points[source].astype(np.float32), _VERTICES, bounds=True),
            NORMAL=self._array(normals.astype(np.float32), _VERTICES),
        )
        if len(surface.uv):
            uv = np.empty((len(source), 2))
            source_uv = surface.uv if surface.texture is None else surface.texture_uv
            uv[corners.reshape(-1)] = source_uv[surface.uv_triangles.reshape(-1)]
            uv[:, 1] = 1.0 - uv[:, 1]  # glTF measures v from the upper edge of a texture
            attributes.TEXCOORD_0 = self._array(uv.astype(np.float32), _VERTICES)
        primitives = [
            gltf.Primitive(
                attributes=attributes,
                indices=self._array(
                    corners[surface.material == k].reshape(-1).astype(np.uint32), _INDICES
                ),
                material=self._material(surface, k),
                targets=[],
            )
            for k in range(len(surface.colors))
        ]
        made.meshes.append(gltf.Mesh(name=surface.name, primitives=primitives))
        node = len(made.nodes)
        made.nodes.append(gltf.Node(name=surface.name, mesh=len(made.meshes) - 1))
        made.nodes[0].children.append(node)
        if moving:
            made.nodes[node].translation = motion.centres[0].tolist()
            self._rigid.append((motion, node))
        elif not motion.rigid:
            self._deforming.append((surface, motion, source, node))

    def add_frames(self, clip: Clip) -> None:
        """Adds the morph targets of deforming surfaces for all frames after the first."""
        for index, frame in enumerate(clip):
            for surface, motion, source, node in self._deforming if index else ():
                now = surface.positions(frame)
                first = motion.first.astype(np.float32).astype(float)
                turned = vertex_normals(now, surface.triangles) - vertex_normals(
                    motion.first, surface.triangles
                )
                shifts = (now - first)[source].astype(np.float32)
                target = {
                    "POSITION": self._array(shifts, _VERTICES, bounds=True),
                    "NORMAL": self._array(turned[source].astype(np.float32), _VERTICES),
                }
                for primitive in self._made.meshes[self._made.nodes[node].mesh].primitives:
                    primitive.targets.append(target)

    def finished(self, clip: Clip) -> Any:
        """Completes and returns the document.

        It has an animation if there are several frames, and a cloth or another moving surface.
        """
        gltf, made, count = self._gltf, self._made, len(clip)
        if count > 1 and (self._deforming or self._rigid):
            animation = gltf.Animation(name="run", samplers=[], channels=[])
            made.animations.append(animation)
            times = self._array(clip.times.astype(np.float32), bounds=True)

            def move(node: int, path: str, values: Floats) -> None:
                animation.samplers.append(
                    gltf.AnimationSampler(
                        input=times,
                        output=self._array(values.astype(np.float32)),
                        interpolation="LINEAR",
                    )
                )
                target = gltf.AnimationChannelTarget(node=node, path=path)
                animation.channels.append(
                    gltf.AnimationChannel(sampler=len(animation.samplers) - 1, target=target)
                )

            for motion, node in self._rigid:
                move(node, "translation", motion.centres)
                move(node, "rotation", motion.quaternions)
            for _, _, _, node in self._deforming:
                made.meshes[made.nodes[node].mesh].weights = [0.0] * (count - 1)
                move(node, "weights", np.eye(count)[:, 1:].reshape(-1))
        made.buffers = [gltf.Buffer(byteLength=len(self._content))]
        made.set_binary_blob(bytes(self._content))
        return made

    def _material(self, surface: Surface, number: int) -> int:
        gltf, made = self._gltf, self._made
        look = gltf.PbrMetallicRoughness(
            baseColorFactor=[*map(float, surface.colors[number]), 1.0],
            metallicFactor=0.0,
            roughnessFactor=float(surface.roughness),
        )
        if surface.texture is not None and number == 0:
            look.baseColorFactor = [1.0, 1.0, 1.0, 1.0]
            look.baseColorTexture = gltf.TextureInfo(
                index=self._texture(surface.texture, surface.repeats)
            )
        made.materials.append(
            gltf.Material(
                name=surface.name,
                pbrMetallicRoughness=look,
                doubleSided=surface.is_cloth,
                alphaCutoff=None,
            )
        )
        return len(made.materials) - 1

    def _texture(self, image: Bytes, repeats: bool) -> int:
        """Appends an image; returns the index of its texture."""
        gltf, made = self._gltf, self._made
        content = png_bytes(image)
        made.bufferViews.append(
            gltf.BufferView(buffer=0, byteOffset=len(self._content), byteLength=len(content))
        )
        self._content += content + bytes(-len(content) % 4)  # arrays start at multiples of 4 bytes
        made.images.append(gltf.Image(bufferView=len(made.bufferViews) - 1, mimeType="image/png"))
        wrap = _REPEAT if repeats else _CLAMP_TO_EDGE
        sampler = gltf.Sampler(wrapS=wrap, wrapT=wrap)
        if sampler not in made.samplers:
            made.samplers.append(sampler)
        made.textures.append(
            gltf.Texture(source=len(made.images) - 1, sampler=made.samplers.index(sampler))
        )
        return len(made.textures) - 1

    def _array(
        self, values: NDArray[Any], target: int | None = None, *, bounds: bool = False
    ) -> int:
        """Appends an array to the buffer; returns the index of its accessor."""
        gltf, made = self._gltf, self._made
        columns = 1 if values.ndim == 1 else values.shape[1]
        view = gltf.BufferView(
            buffer=0, byteOffset=len(self._content), byteLength=values.nbytes, target=target
        )
        made.bufferViews.append(view)
        self._content += values.tobytes()
        rows = values.reshape(len(values), columns)
        accessor = gltf.Accessor(
            bufferView=len(made.bufferViews) - 1,
            componentType=_FLOAT if values.dtype == np.float32 else _UNSIGNED,
            count=len(values),
            type=_KINDS[columns],
            min=rows.min(0).tolist() if bounds else None,
            max=rows.max(0).tolist() if bounds else None,
        )
        made.accessors.append(accessor)
        return len(made.accessors) - 1


def _split(surface: Surface, motion: Motion, points: Floats) -> tuple[Indices, Indices, Floats]:
    """Repeats vertices whose corners differ in uv or, if the surface is rigid, in normals.

    Returns three arrays: for each vertex of the resulting mesh, the index of the surface's vertex
    that it repeats (k); the triangles (m x 3); and the normals at the vertices (k x 3).
    """
    corner_vertex = surface.triangles.reshape(-1)
    keys = corner_vertex[:, None]
    if len(surface.uv):
        keys = np.column_stack([keys, surface.uv_triangles.reshape(-1)])
    if motion.rigid:
        per_corner = corner_normals(points, surface.triangles)
        keys = np.column_stack([keys, np.round(per_corner, 6)])
    table, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    vertex = table[:, 0].astype(np.int64)
    repeated = np.r_[False, vertex[1:] == vertex[:-1]]
    order = np.argsort(repeated, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    source, corners = vertex[order], place[index.reshape(-1)].reshape(-1, 3)
    if motion.rigid:
        return source, corners, per_corner[first[order]]
    return source, corners, vertex_normals(points, surface.triangles)[source]
