"""Record of the magnets and coils of a scene and of what carries them, for drawing field lines.

The record contains only values that JSON can represent. Reading it runs no code of the scene file.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from .._core import (
    Bearing,
    CacheError,
    Coil,
    Error,
    Magnet,
    MagneticBody,
    Obstacle,
    RigidBody,
    Scene,
    SoftBody,
    TriangleMesh,
)

__all__ = ["magnets_from_record", "magnets_to_record"]

_DESCRIPTIONS = {kind.__name__: kind for kind in (Bearing, Coil, Magnet, Obstacle, RigidBody)}
_SOURCES = {kind.__name__: kind for kind in (MagneticBody, SoftBody)}
_NUMBERS = {"<f8", "<i4", "<i8"}  # types of numbers that arrays may have
_FIELDS = ("obstacles", "bodies", "magnets", "coils", "bearings", "magnetic_field")


def magnets_to_record(scene: Scene) -> dict[str, Any] | None:
    """Returns the magnetic part of a scene for JSON, or None if it has neither magnets nor coils.

    That part contains magnets, coils, bearings, the uniform field, bodies, and obstacles at rest.
    """
    if not (scene.magnets or scene.coils):
        return None
    resting = [Obstacle(name=o.name, mesh=o.mesh) for o in scene.obstacles]
    return {name: _plain(getattr(scene.replace(obstacles=resting), name)) for name in _FIELDS}


def magnets_from_record(record: Any) -> Scene:
    """Returns the scene of a record. Raises CacheError if the record is damaged."""
    try:
        fields = {name: _restored(record[name]) for name in _FIELDS}
        return Scene(**fields, collisions=False)
    except (Error, ArithmeticError, LookupError, TypeError, ValueError, RuntimeError) as error:
        raise CacheError(f"the file is damaged: its magnets cannot be read ({error})") from error


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.ndarray):
        kept = np.ascontiguousarray(value)
        return {
            "array": base64.b64encode(kept.tobytes()).decode(),
            "type": kept.dtype.str,
            "shape": list(kept.shape),
        }
    if isinstance(value, TriangleMesh):
        return {"vertices": _plain(value.vertices), "triangles": _plain(value.triangles)}
    if type(value).__name__ in _SOURCES:
        return {"source": type(value).__name__, "state": _plain(value.__getstate__())}
    if hasattr(value, "field_names"):
        fields = {name: _plain(getattr(value, name)) for name in value.field_names}
        return {"is": type(value).__name__, "fields": fields}
    return [_plain(item) for item in value]


def _restored(value: Any) -> Any:
    if isinstance(value, list):
        return [_restored(item) for item in value]
    if not isinstance(value, dict):
        return value
    if "array" in value:
        if value["type"] not in _NUMBERS:
            raise ValueError(f"unknown type of number {value['type']!r}")
        numbers = np.frombuffer(base64.b64decode(value["array"]), value["type"])
        return numbers.reshape(value["shape"])
    if "vertices" in value:
        return TriangleMesh(_restored(value["vertices"]), _restored(value["triangles"]))
    if "source" in value:
        kind = _SOURCES[value["source"]]
        made: Any = kind.__new__(kind)
        made.__setstate__(_tuples(_restored(value["state"])))
        return made
    fields = {name: _restored(item) for name, item in value["fields"].items()}
    return _DESCRIPTIONS[value["is"]](**fields)


def _tuples(value: Any) -> Any:
    """Returns nested lists as nested tuples, of which the states of sources consist."""
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value
