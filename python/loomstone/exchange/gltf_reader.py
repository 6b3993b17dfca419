"""Reads the meshes of a glTF 2.0 file over time, moved by skins, morph targets and nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError, Error, InvalidInput
from .gltf_animation import Channel, channels_of, value_at
from .gltf_file import GltfFile, attributes_of, matrix
from .parts import MALFORMED, Part, sample_times
from .surfaces import Floats, Indices

__all__ = ["read_gltf"]

_RATE = 60.0  # default number of samples of an animation per second [1/s]
_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # rotates from y up to z up


def read_gltf(
    path: Path, rate: float | None, animation: list[str] | None, *, with_uv: bool = False
) -> tuple[list[Part], Floats]:
    """Returns the meshes of the default scene over time, and the times of the samples [s].

    Time 0 is the first keyframe of the animations. Without a default scene, the first scene is
    read.

    rate : samples per second [1/s]; None: 60
    animation : names of animations that run at the same time; an empty list: the only animation of
        the file; None: only the rest pose
    with_uv : whether the texture coordinates TEXCOORD_0 are read. They are converted so that v is
        measured from the lower edge of the texture.
    """
    try:
        return _sampled(GltfFile(path), rate, animation, with_uv=with_uv)
    except MALFORMED as error:
        if isinstance(error, Error):
            raise
        raise CacheError(f"{path}: is malformed, and cannot be read as glTF: {error!r}") from None


def _sampled(
    file: GltfFile, rate: float | None, animation: list[str] | None, *, with_uv: bool
) -> tuple[list[Part], Floats]:
    channels = [] if animation is None else channels_of(file, animation)
    start = min((c.times[0] for c in channels), default=0.0)
    length = max((c.times[-1] for c in channels), default=0.0) - start
    if animation is not None and length <= 0.0:
        raise InvalidInput(
            f"{file.path}: the animation must last longer than 0 s, got one keyframe"
        )
    times = sample_times(file.path, length, rate or _RATE)
    shapes = _shapes(file, with_uv=with_uv)
    frames: list[list[Floats]] = [[] for _ in shapes]
    for time in times:
        poses, weights = _pose(file, channels, start + time)
        for shape, mine in zip(shapes, frames, strict=True):
            mine.append(shape.vertices(poses, weights) @ _UP.T)
    poses, _ = _pose(file, channels, start)
    return [
        shape.part(poses, np.array(mine)) for shape, mine in zip(shapes, frames, strict=True)
    ], times


class _Shape:
    """The triangles of a node, with its morph targets and its skin."""

    def __init__(self, file: GltfFile, number: int, path: str, *, with_uv: bool) -> None:
        node = file.content.nodes[number]
        mesh = file.item("meshes", node.mesh, f"node {number}")
        self.node, self.name = number, node.name or mesh.name or f"mesh {node.mesh}"
        self.path = f"{path}/{self.name}"
        self.weights = file.weights.get(number, np.array(mesh.weights or [], float))
        pieces = [_Piece(file, p, self.name, node.skin is not None) for p in mesh.primitives]
        self.corner_uv = np.concatenate(
            [
                p.corner_uv(file) if with_uv else np.full((*p.triangles.shape, 2), np.nan)
                for p in pieces
            ]
        )
        starts = np.cumsum([0, *(len(p.points) for p in pieces)])
        self.points = np.concatenate([p.points for p in pieces])
        self.targets = np.concatenate([p.targets for p in pieces], 1)
        self.triangles = np.concatenate(
            [p.triangles + start for p, start in zip(pieces, starts, strict=False)]
        )
        self.skin: tuple[list[int], Floats] | None = None
        if node.skin is not None:
            self.joints = np.concatenate([p.joints for p in pieces])
            self.shares = np.concatenate([p.shares for p in pieces])
            self.skin = _skin(file, node.skin, self.name)
            if self.joints.max(initial=0) >= len(self.skin[0]):
                raise InvalidInput(
                    f"{file.path}: {self.name!r} uses joint {self.joints.max()}, but its skin has"
                    f" only {len(self.skin[0])} joints"
                )

    def vertices(self, poses: dict[int, Floats], weights: dict[int, Floats]) -> Floats:
        """Returns the vertices in world space (n x 3) [m], with y up."""
        share = weights.get(self.node, self.weights)[: len(self.targets)]
        points = self.points + np.tensordot(share, self.targets[: len(share)], 1)
        return _moved(points, self._matrices(poses))

    def part(self, poses: dict[int, Floats], frames: Floats) -> Part:
        """Returns the part with vertices `frames` (f x n x 3).

        Its triangles have reversed corners if there is no skin and the node's transform includes a
        reflection.
        """
        mirrored = self.skin is None and np.linalg.det(poses[self.node][:3, :3]) < 0.0
        order = slice(None, None, -1 if mirrored else 1)
        return Part(
            self.name, self.path, self.triangles[:, order], frames, self.corner_uv[:, order]
        )

    def _matrices(self, poses: dict[int, Floats]) -> Floats:
        """Returns the matrix (4 x 4) to world space; with a skin, one per vertex (n x 4 x 4)."""
        if self.skin is None:
            return poses[self.node]
        joints, inverse = self.skin
        moved = np.array([poses[j] for j in joints]) @ inverse
        return np.asarray(np.einsum("nk,nkij->nij", self.shares, moved[self.joints]))


class _Piece:
    """One primitive of a mesh."""

    def __init__(self, file: GltfFile, primitive: Any, name: str, skinned: bool) -> None:
        self._name, self._attributes = name, attributes_of(primitive.attributes)
        attributes = self._attributes
        position = attributes.get("POSITION")
        if position is None:
            raise InvalidInput(f"{file.path}: {name!r} has no positions")
        self.points = file.array(position, f"positions of {name!r}")
        n = len(self.points)
        self.triangles = _triangles(file, primitive, name, n)
        targets = [attributes_of(target).get("POSITION") for target in primitive.targets or []]
        shifts = [
            np.zeros((n, 3)) if t is None else file.array(t, f"a morph target of {name!r}")
            for t in targets
        ]
        self.targets = np.array(shifts).reshape(len(shifts), n, 3)
        if skinned:
            self.joints, self.shares = _joints(file, attributes, name)

    def corner_uv(self, file: GltfFile) -> Floats:
        """Returns the texture coordinates of corners (m x 3 x 2), NaN if there are none."""
        index = self._attributes.get("TEXCOORD_0")
        if index is None:
            return np.full((*self.triangles.shape, 2), np.nan)
        uv = file.array(index, f"texture coordinates of {self._name!r}")
        if uv.shape != (len(self.points), 2):
            raise InvalidInput(
                f"{file.path}: the texture coordinates of {self._name!r} must be"
                f" {len(self.points)} x 2 numbers, got {len(uv)} x {uv.shape[1]}"
            )
        return np.column_stack([uv[:, 0], 1.0 - uv[:, 1]])[self.triangles]


def _triangles(file: GltfFile, primitive: Any, name: str, points: int) -> Indices:
    """Returns the triangles (m x 3) of a primitive: a list, a strip or a fan of triangles.

    Raises InvalidInput for points or lines, and for a vertex index that is out of range.
    """
    corners = np.arange(points)
    if primitive.indices is not None:
        corners = file.array(primitive.indices, f"indices of {name!r}")[:, 0].astype(np.int64)
    if corners.max(initial=0) >= points:
        raise InvalidInput(
            f"{file.path}: {name!r} refers to vertex {corners.max()}, but has only {points}"
        )
    mode = 4 if primitive.mode is None else primitive.mode
    k = np.arange(max(len(corners) - 2, 0))
    if mode == 4:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode == 5:
        return corners[np.column_stack([k + k % 2, k + 1 - k % 2, k + 2])]
    if mode == 6:
        return corners[np.column_stack([0 * k, k + 1, k + 2])]
    raise InvalidInput(f"{file.path}: {name!r} must consist of triangles, got points or lines")


def _joints(
    file: GltfFile, attributes: dict[str, int | None], name: str
) -> tuple[NDArray[np.int64], Floats]:
    """Returns the joints of each vertex, as indices into the joints of the skin, and their weights.

    Both are (n x k). If the weights of a vertex have a positive sum, they are scaled to the sum 1.
    """
    joints, shares = [], []
    for number in range(8):
        index = attributes.get(f"JOINTS_{number}")
        weight = attributes.get(f"WEIGHTS_{number}")
        if index is None or weight is None:
            break
        joints.append(file.array(index, f"joints of {name!r}").astype(np.int64))
        shares.append(file.array(weight, f"weights of {name!r}"))
    if not joints:
        raise InvalidInput(f"{file.path}: {name!r} has a skin, but no joints and weights")
    share = np.concatenate(shares, 1)
    total = share.sum(1, keepdims=True)
    return np.concatenate(joints, 1), share / np.where(total > 0.0, total, 1.0)


def _skin(file: GltfFile, index: int, name: str) -> tuple[list[int], Floats]:
    """Returns the node index and the inverse bind matrix (4 x 4) of each of the j joints of a skin.

    The matrices are one array (j x 4 x 4).
    """
    skin = file.item("skins", index, repr(name))
    joints = list(skin.joints or [])
    for joint in joints:
        file.item("nodes", joint, f"the skin of {name!r}")
    if skin.inverseBindMatrices is None:
        return joints, np.tile(np.eye(4), (len(joints), 1, 1))
    flat = file.array(skin.inverseBindMatrices, f"the skin of {name!r}")
    return joints, flat.reshape(-1, 4, 4).transpose(0, 2, 1)


def _shapes(file: GltfFile, *, with_uv: bool) -> list[_Shape]:
    """Returns the shapes of all nodes of the default scene that have a mesh."""
    nodes = file.content.nodes
    found: list[_Shape] = []
    paths: dict[int | None, str] = {None: ""}
    for number, parent in _tree(file):
        paths[number] = f"{paths[parent]}/{nodes[number].name or f'node {number}'}"
        if nodes[number].mesh is not None:
            found.append(_Shape(file, number, paths[parent], with_uv=with_uv))
    return found


def _tree(file: GltfFile) -> list[tuple[int, int | None]]:
    """Returns pairs (node, parent) of indices for all nodes of the default scene, parents first.

    The parent of a root is None. If the file names no default scene, its first scene is used.
    """
    content = file.content
    if not content.scenes:
        return []
    scene = file.item("scenes", content.scene or 0, "the file")
    found: list[tuple[int, int | None]] = []
    waiting: list[tuple[int, int | None]] = [(n, None) for n in scene.nodes or []]
    while waiting:
        number, parent = waiting.pop(0)
        node = file.item("nodes", number, "a scene or node")
        found.append((number, parent))
        if len(found) > len(content.nodes):
            raise InvalidInput(f"{file.path}: a node must have one parent, got several or a cycle")
        waiting.extend((child, number) for child in node.children or [])
    return found


def _pose(
    file: GltfFile, channels: list[Channel], time: float
) -> tuple[dict[int, Floats], dict[int, Floats]]:
    """Returns the state of the default scene at `time` [s]: the transforms (4 x 4) of its nodes to
    world space, and the animated weights of morph targets. Both are dictionaries by node index.
    """
    changed: dict[int, dict[str, Floats]] = {}
    for channel in channels:
        changed.setdefault(channel.node, {})[channel.path] = value_at(channel, time)
    weights = {
        node: values.pop("weights") for node, values in changed.items() if "weights" in values
    }
    poses: dict[int, Floats] = {}
    for number, parent in _tree(file):
        own = matrix(file.content.nodes[number], changed.get(number, {}))
        poses[number] = own if parent is None else poses[parent] @ own
    return poses, weights


def _moved(points: Floats, matrices: Floats) -> Floats:
    if matrices.ndim == 2:
        return np.asarray(points @ matrices[:3, :3].T + matrices[:3, 3])
    turned = np.einsum("nij,nj->ni", matrices[:, :3, :3], points)
    return np.asarray(turned + matrices[:, :3, 3])
