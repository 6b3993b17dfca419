"""Pickling and copying of meshes and of descriptions, such as Scene and Cloth.

Pickled objects are rebuilt from their fields, which are then validated again. The core itself
pickles sources, soft-magnetic bodies, step reports, frames, their topologies and checkpoints.
"""

from __future__ import annotations

import copyreg
from typing import Any

from .. import _core
from .._core import TriangleMesh

__all__: list[str] = []


def _rebuilt(kind: type, fields: dict[str, Any]) -> Any:
    return kind(**fields)


def _parts_of_description(description: Any) -> tuple[Any, ...]:
    kind = type(description)
    return _rebuilt, (kind, {name: getattr(description, name) for name in kind.field_names})


def _parts_of_mesh(mesh: TriangleMesh) -> tuple[Any, ...]:
    fields = {
        "vertices": mesh.vertices,
        "triangles": mesh.triangles,
        "uv": mesh.uv,
        "uv_triangles": mesh.uv_triangles,
    }
    return _rebuilt, (TriangleMesh, fields)


for _kind in list(vars(_core).values()):
    if isinstance(_kind, type) and hasattr(_kind, "field_names"):
        copyreg.pickle(_kind, _parts_of_description)
copyreg.pickle(TriangleMesh, _parts_of_mesh)
