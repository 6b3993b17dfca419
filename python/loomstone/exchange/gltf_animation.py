"""Animations of glTF 2.0: properties of nodes at given times (specification, appendix C)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core import InvalidInput
from .gltf_file import GltfFile
from .surfaces import Floats

__all__ = ["Channel", "channels_of", "value_at"]


@dataclass(frozen=True)
class Channel:
    """Keyframes of one property of a node."""

    node: int
    path: str  # translation, rotation, scale or weights
    times: Floats  # (k) ascending [s]
    # (k x c) for c components; (k x 3 x c) for CUBICSPLINE, with in-tangent, value and out-tangent
    values: Floats
    interpolation: str  # LINEAR, STEP or CUBICSPLINE


def channels_of(file: GltfFile, names: list[str]) -> list[Channel]:
    """Returns the channels of the named animations, or of the only animation if no name is given.

    Omits channels without a node. The animations have the order of `names`. If several of the
    channels move the same property of a node, the caller must use the last one. Raises InvalidInput
    if the file has no animation or lacks a named one, if it has several and no name is given, or if
    a channel is invalid.
    """
    animations = file.content.animations
    known = [item.name or f"animation {i}" for i, item in enumerate(animations)]
    if not known:
        raise InvalidInput(
            f"{file.path}: has no animation; use"
            " loomstone.obstacles.mesh(loomstone.meshes.read(path))"
        )
    listed = ", ".join(map(repr, known))
    if not names and len(known) > 1:
        raise InvalidInput(
            f"{file.path}: has several animations, {listed}; give animation=..., one of these"
            " names, or a list of those that run at the same time"
        )
    if unknown := [name for name in names if name not in known]:
        raise InvalidInput(f"{file.path}: animation must be one of {listed}, got {unknown[0]!r}")
    chosen = [animations[known.index(name)] for name in names] or animations
    return [
        _channel(file, animation, channel)
        for animation in chosen
        for channel in animation.channels
        if channel.target.node is not None
    ]


def value_at(channel: Channel, time: float) -> Floats:
    """Returns the value of a channel at a time [s].

    Before the first keyframe and after the last, it is the value at that keyframe.
    """
    times, values = channel.times, channel.values
    cubic = channel.interpolation == "CUBICSPLINE"
    i = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 1))
    here: Floats = values[i, 1] if cubic else values[i]
    if i == len(times) - 1 or time <= times[0] or channel.interpolation == "STEP":
        return here
    length = times[i + 1] - times[i]
    t = (time - times[i]) / length
    if cubic:
        found: Floats = (
            (2 * t**3 - 3 * t**2 + 1) * here
            + (t**3 - 2 * t**2 + t) * length * values[i, 2]
            + (3 * t**2 - 2 * t**3) * values[i + 1, 1]
            + (t**3 - t**2) * length * values[i + 1, 0]
        )
        return np.asarray(found / np.linalg.norm(found)) if channel.path == "rotation" else found
    if channel.path == "rotation":
        return _slerp(here, values[i + 1], t)
    return np.asarray((1.0 - t) * here + t * values[i + 1])


def _channel(file: GltfFile, animation: object, channel: object) -> Channel:
    sampler = animation.samplers[channel.sampler]  # type: ignore[attr-defined]
    target = channel.target  # type: ignore[attr-defined]
    node = file.item("nodes", target.node, "an animation")
    times = file.array(sampler.input, "the times of an animation")[:, 0]
    values = file.array(sampler.output, "the values of an animation")
    if target.path == "weights":
        mesh = file.item("meshes", node.mesh, "animated weights")
        values = values.reshape(-1, len(mesh.primitives[0].targets or []))
    elif node.matrix is not None:
        raise InvalidInput(
            f"{file.path}: node {target.node} must not have a matrix, because an animation changes"
            f" its {target.path}; export it with translation, rotation and scale"
        )
    cubic = sampler.interpolation == "CUBICSPLINE"
    wanted = (3 if cubic else 1) * len(times)
    if not len(times) or len(values) != wanted:
        raise InvalidInput(
            f"{file.path}: an animation must have {wanted} values for {len(times)} times, got"
            f" {len(values)}"
        )
    values = values.reshape(len(times), 3, -1) if cubic else values
    return Channel(target.node, target.path, times, values, sampler.interpolation or "LINEAR")


def _slerp(a: Floats, b: Floats, t: float) -> Floats:
    """Interpolates unit quaternions along the shorter arc."""
    cosine = float(a @ b)
    b, cosine = (-b, -cosine) if cosine < 0.0 else (b, cosine)
    angle = np.arccos(min(cosine, 1.0))
    if angle < 1e-6:
        return a + t * (b - a)
    found: Floats = (np.sin((1.0 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)
    return found
