"""Checks the types of the values in a glTF file, because pygltflib leaves some unchecked."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path
from typing import Any, Union, get_args, get_origin, get_type_hints

from .._core import CacheError

__all__ = ["check_types"]

_USED = (  # lists of a file that are read
    "accessors",
    "animations",
    "buffers",
    "bufferViews",
    "extensionsRequired",
    "meshes",
    "nodes",
    "scenes",
    "skins",
)
_OPAQUE = ("extensions", "extras")  # properties of any type
_NAMES = {int: "a whole number", float: "a number", str: "a string", bool: "true or false"}
_hints: Any = cache(get_type_hints)


def check_types(path: Path, content: Any) -> None:
    """Raises CacheError if a value does not have the type that pygltflib declares for it.

    Checks only what is read: `scene` and the lists in _USED, without the properties `extensions`
    and `extras`. A missing value is an error unless it is declared optional.

    content : content of the file, as a pygltflib.GLTF2
    """
    hints = _hints(type(content))
    for kind in _USED:
        _check(getattr(content, kind), hints[kind], f"{path}", kind)
    if content.scene is not None:
        _check(content.scene, int, f"{path}", "scene")


def _check(value: Any, hint: Any, path: str, where: str) -> None:
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Union:  # Optional[...]
        if value is not None:
            _check(value, arguments[0], path, where)
    elif origin is list:
        _require(isinstance(value, list), value, "a list", path, where)
        for number, item in enumerate(value):
            _check(item, arguments[0], path, f"{where}[{number}]")
    elif dataclasses.is_dataclass(hint):
        _require(dataclasses.is_dataclass(value), value, "an object", path, where)
        for name, wanted in _hints(hint).items():
            if name not in _OPAQUE:
                _check(getattr(value, name), wanted, path, f"{where}.{name}")
    elif hint in _NAMES:
        types = (int, float) if hint is float else hint
        right = isinstance(value, types) and isinstance(value, bool) == (hint is bool)
        _require(right, value, _NAMES[hint], path, where)
    else:  # Attributes: a dictionary, or an object with one property per attribute
        _require(isinstance(value, (dict, hint)), value, "an object", path, where)
        for name, index in (value if isinstance(value, dict) else vars(value)).items():
            if index is not None:
                _check(index, int, path, f"{where}.{name}")


def _require(holds: bool, value: Any, wanted: str, path: str, where: str) -> None:
    if not holds:
        got = "nothing" if value is None else repr(value)[:60]
        raise CacheError(
            f"{path}: is malformed, and cannot be read as glTF: {where} must be {wanted}, got {got}"
        )
