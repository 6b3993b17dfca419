"""Lets the module `loomstone.fabrics` act as a mapping of fabrics by name."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, ValuesView
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .fabric import Fabric
from .named_fabrics import catalogue

__all__ = ["FabricsRoom"]


class FabricsRoom(ModuleType):
    """A module that is indexed by the names of fabrics, as in loomstone.fabrics["cotton"]."""

    def __getitem__(self, name: str) -> Fabric:
        return catalogue[name]

    def __contains__(self, name: object) -> bool:
        return name in catalogue

    def __iter__(self) -> Iterator[str]:
        return iter(catalogue)

    def __len__(self) -> int:
        return len(catalogue)

    def keys(self) -> KeysView[str]:
        """Returns the names of the fabrics."""
        return catalogue.keys()

    def values(self) -> ValuesView[Fabric]:
        """Returns the fabrics."""
        return catalogue.values()

    def items(self) -> ItemsView[str, Fabric]:
        """Returns pairs of a name and a fabric."""
        return catalogue.items()

    def get(self, name: str, default: Any = None) -> Any:
        """Returns a fabric, or `default` if there is no fabric of that name."""
        return catalogue.get(name, default)

    def __repr__(self) -> str:
        return f"fabrics({', '.join(catalogue)})"

    if TYPE_CHECKING:  # type checkers treat the module as an object of this class

        def __getattr__(self, name: str) -> Any: ...
