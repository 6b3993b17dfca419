"""Access to a glTF 2.0 file: its items, arrays of its accessors, and transforms of its nodes."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError, InvalidInput, Unsupported
from .extras import imported
from .gltf_types import check_types
from .surfaces import Floats

__all__ = ["GltfFile", "attributes_of", "matrix"]

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_KNOWN = (  # prefixes of the required extensions with which geometry can be read
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "EXT_texture_",
)


class GltfFile:
    """A parsed glTF file with its binary data."""

    def __init__(self, path: Path) -> None:
        gltf = imported("pygltflib", path)
        self.path = path
        try:
            self.content = gltf.GLTF2().load(str(path))
        except (ValueError, KeyError, TypeError, AttributeError, struct.error) as error:
            reason = "" if isinstance(error, json.JSONDecodeError) else f": {error}"
            raise CacheError(
                f"{path}: is malformed or cut short, and cannot be read as glTF{reason}"
            ) from None
        except OSError as error:
            raise CacheError(f"{path}: cannot be read: {error.strerror or error}") from None
        if self.content is None:
            raise CacheError(f"{path}: cannot be read as glTF 2.0")
        check_types(path, self.content)
        for name in self.content.extensionsRequired or []:
            if not name.startswith(_KNOWN):
                raise Unsupported(f"{path}: requires {name}, which is not supported; export it"
                                  " again without compression")  # fmt: skip
        self._buffers: dict[int, bytes] = {}
        # Weights of morph targets of each node that has them, which pygltflib does not read.
        self.weights: dict[int, Floats] = {
            number: np.array(node["weights"], float)
            for number, node in enumerate(_text(path).get("nodes", []))
            if "weights" in node
        }

    def item(self, kind: str, index: int | None, of: str) -> Any:
        """Returns item `index` of the list `kind`, such as "nodes"; raises InvalidInput if absent.

        of : what refers to the item, for messages
        """
        items = getattr(self.content, kind)
        if index is None or not 0 <= index < len(items):
            raise InvalidInput(
                f"{self.path}: {of} refers to {kind}[{index}], but the file has only {len(items)}"
            )
        return items[index]

    def array(self, index: int, of: str) -> Floats:
        """Returns the values (count x columns) of an accessor.

        Integers that the accessor marks as normalized are divided by the largest value of the type,
        and quotients below -1 are replaced by -1.

        of : what the values are, for messages
        """
        accessor = self.item("accessors", index, of)
        columns = _COLUMNS[accessor.type]
        values: NDArray[Any] = np.zeros((accessor.count, columns), _TYPES[accessor.componentType])
        if accessor.bufferView is not None:
            values = self._values(accessor, accessor.count, columns, of)
        if accessor.sparse is not None:
            values = np.array(values)
            where = self._values(accessor.sparse.indices, accessor.sparse.count, 1, of)
            accessor.sparse.values.componentType = accessor.componentType
            values[where.ravel()] = self._values(
                accessor.sparse.values, accessor.sparse.count, columns, of
            )
        if accessor.normalized and values.dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
        return np.asarray(values, float)

    def _values(self, source: Any, count: int, columns: int, of: str) -> NDArray[Any]:
        view = self.item("bufferViews", source.bufferView, of)
        kind = np.dtype(_TYPES[source.componentType])
        content = self._buffer(view.buffer, of)
        offset = (view.byteOffset or 0) + (source.byteOffset or 0)
        stride = view.byteStride or kind.itemsize * columns
        wanted = offset + stride * (count - 1) + kind.itemsize * columns if count else offset
        if wanted > len(content):
            raise CacheError(
                f"{self.path}: {of} must have {wanted} bytes, got {len(content)}; the file is cut"
                " short"
            )
        return np.ndarray((count, columns), kind, content, offset, (stride, kind.itemsize))

    def _buffer(self, index: int, of: str) -> bytes:
        if index not in self._buffers:
            uri = self.item("buffers", index, of).uri
            try:
                if not uri:
                    found = self.content.binary_blob()
                elif uri.startswith("data:"):
                    found = self.content.get_data_from_buffer_uri(uri)
                else:
                    file = self.path.parent / unquote(uri)
                    if not file.is_file():  # some programs do not encode names
                        file = self.path.parent / uri
                    found = file.read_bytes()
            except (OSError, ValueError) as error:
                raise CacheError(f"{self.path}: its data cannot be read: {error}") from None
            self._buffers[index] = found or b""
        return self._buffers[index]


def _text(path: Path) -> dict[str, Any]:
    """Returns the JSON of a glTF file that can be read."""
    with path.open("rb") as file:
        head = file.read(20)  # of a binary file: its header, and that of the chunk of JSON
        binary = head.startswith(b"glTF")
        text = file.read(int.from_bytes(head[12:16], "little")) if binary else head + file.read()
    content: dict[str, Any] = json.loads(text)
    return content


def attributes_of(item: Any) -> dict[str, int | None]:
    """Returns the index of the accessor of each attribute of a primitive or morph target, by name.

    An attribute without an accessor has None or no entry.
    """
    return item if isinstance(item, dict) else vars(item)


def matrix(node: Any, changed: dict[str, Floats]) -> Floats:
    """Returns the transform (4 x 4) of a node relative to its parent.

    changed : animated values of "translation", "rotation" (x, y, z, w) and "scale", which replace
        those of the node; empty for a node with a `matrix`
    """
    from scipy.spatial.transform import Rotation

    if node.matrix is not None:
        return np.array(node.matrix, float).reshape(4, 4).T
    pose = np.eye(4)
    turn = changed.get("rotation", node.rotation)
    if turn is not None:
        pose[:3, :3] = Rotation.from_quat(turn).as_matrix()
    scale = changed.get("scale", node.scale)
    if scale is not None:
        pose[:3, :3] *= np.asarray(scale, float)
    shift = changed.get("translation", node.translation)
    if shift is not None:
        pose[:3, 3] = shift
    return pose
