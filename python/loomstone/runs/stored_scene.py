"""Scenes of runs that were started from Python, stored so that other processes can resume the runs.

The file scene.npz holds the descriptions that make up the scene (Scene, Cloth and so on) as JSON,
and their arrays. Reading it executes no code from the file: only descriptions, meshes and magnetic
sources of loomstone are made from it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import CacheError, MagneticBody, Scene, SoftBody, TriangleMesh
from .checkpoints import checkpoint_files

__all__ = [
    "STORED_SCENE",
    "StoredScene",
    "begun_in_python",
    "digest_of",
    "read_scene",
    "write_scene",
]

STORED_SCENE = "scene.npz"

Arrays = dict[str, NDArray[Any]]


def begun_in_python(metadata: dict[str, Any]) -> bool:
    """Returns whether the metadata are those of a run made by Simulation.run."""
    return "loomstone" in metadata and "scene_file" not in metadata


class StoredScene:
    """The scene of a run that was started from Python. It takes the place of a SceneFile."""

    def __init__(self, directory: Path, metadata: dict[str, Any]) -> None:
        """Raises CacheError if the run cannot be resumed from its stored scene."""
        if metadata.get("control", False):
            raise CacheError(
                f"{directory}: was run with a control function in Python, which is not stored;"
                " resume it there by Simulation.run(resume=True, control=...)"
            )
        if not checkpoint_files(directory):
            raise CacheError(
                f"{directory}: was begun in Python and has no checkpoint to resume from; run it"
                " again in Python"
            )
        self._scene = read_scene(directory)
        self.control: Callable[[Any], None] | None = None

    def scene(self) -> Scene:
        """Returns the stored scene."""
        return self._scene


_DESCRIPTIONS = {
    name: kind
    for name, kind in vars(_core).items()
    if isinstance(kind, type) and hasattr(kind, "field_names")
}
_SOURCES: dict[str, Any] = {"MagneticBody": MagneticBody, "SoftBody": SoftBody}
_OF_MESH = ("vertices", "triangles", "uv", "uv_triangles")


def write_scene(directory: Path, scene: Scene) -> None:
    """Writes the scene of a run into its directory."""
    arrays: Arrays = {}
    text = json.dumps(_encoded(scene, arrays))
    path = directory / STORED_SCENE
    unfinished = path.with_name("unfinished-" + path.name)
    with unfinished.open("wb") as file:
        np.savez(file, scene=np.array(text), **arrays)  # type: ignore[arg-type]
    unfinished.replace(path)


def digest_of(*described: Any) -> str:
    """Returns a digest of scenes and other descriptions, equal for equal contents."""
    arrays: Arrays = {}
    hashed = hashlib.sha256(json.dumps(_encoded(described, arrays)).encode())
    for array in arrays.values():
        hashed.update(str((array.dtype, array.shape)).encode())
        hashed.update(np.ascontiguousarray(array).tobytes())
    return hashed.hexdigest()[:16]


def read_scene(directory: Path) -> Scene:
    """Returns the stored scene of a run. Raises CacheError if it is absent or cannot be read."""
    path = directory / STORED_SCENE
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        scene = _decoded(json.loads(str(arrays["scene"])), arrays)
    except FileNotFoundError:
        raise CacheError(
            f"{directory}: has neither a scene file nor {STORED_SCENE}, so its scene is not known;"
            " only the Python program that made it can resume it"
        ) from None
    except Exception as error:  # damaged files make numpy and zipfile raise errors of many types
        told = " ".join(str(error).split())[:200]
        raise CacheError(f"{path}: the scene cannot be read ({told}); resume in Python") from error
    if not isinstance(scene, Scene):
        raise CacheError(f"{path}: holds no scene; resume the run in Python")
    return scene


def _encoded(value: Any, arrays: Arrays) -> Any:
    """Returns a value as JSON, with arrays replaced by names. Adds the arrays to `arrays`."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.ndarray):
        name = f"array{len(arrays)}"
        arrays[name] = value
        return {"array": name}
    if isinstance(value, (list, tuple)):
        return {type(value).__name__: [_encoded(each, arrays) for each in value]}
    if isinstance(value, TriangleMesh):
        return {"mesh": {n: _encoded(np.asarray(getattr(value, n)), arrays) for n in _OF_MESH}}
    if isinstance(value, (MagneticBody, SoftBody)):
        state = value.__getstate__()
        return {"source": type(value).__name__, "state": _encoded(state, arrays)}
    # A Fabric is stored as a ClothMaterial, because the simulation does not use its other data.
    kind = next(each for each in type(value).__mro__ if each.__name__ in _DESCRIPTIONS)
    fields = {name: _encoded(getattr(value, name), arrays) for name in value.field_names}
    return {"description": kind.__name__, "fields": fields}


def _decoded(value: Any, arrays: Arrays) -> Any:
    """Restores a value from its encoded form; damaged forms raise errors such as KeyError."""
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "list" in value:
        return [_decoded(each, arrays) for each in value["list"]]
    if "tuple" in value:
        return tuple(_decoded(each, arrays) for each in value["tuple"])
    if "mesh" in value:
        parts = {name: _decoded(value["mesh"][name], arrays) for name in _OF_MESH}
        if not len(parts["uv"]):
            parts["uv"] = parts["uv_triangles"] = None
        return TriangleMesh(**parts)
    if "source" in value:
        kind = _SOURCES[value["source"]]
        source = kind.__new__(kind)
        source.__setstate__(_decoded(value["state"], arrays))
        return source
    fields = {name: _decoded(each, arrays) for name, each in value["fields"].items()}
    return _DESCRIPTIONS[value["description"]](**fields)
