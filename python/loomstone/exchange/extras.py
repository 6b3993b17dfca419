"""Import of packages that are needed only for some file formats."""

from __future__ import annotations

import importlib
from typing import Any

from .._core import Unsupported

__all__ = ["imported"]

_PACKAGES = {
    "pxr": "usd-core",
    "pygltflib": "pygltflib",
    "alembic3d": "alembic3d",
    "imath": "alembic3d",
    "OpenEXR": "OpenEXR",
}
_EXTRAS = {
    "pxr": "usd",
    "pygltflib": "gltf",
    "alembic3d": "alembic",
    "imath": "alembic",
    "OpenEXR": "exr",
}


def imported(module: str, what: object) -> Any:
    """Imports and returns a module. Raises Unsupported if its package is not installed.

    what : the file or format that needs the module; the message begins with it
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        top = module.split(".")[0]
        raise Unsupported(
            f"{what}: this format needs the package {_PACKAGES[top]}, which is not installed; pip"
            f" install loomstone[{_EXTRAS[top]}], or pip install {_PACKAGES[top]}"
        ) from None
