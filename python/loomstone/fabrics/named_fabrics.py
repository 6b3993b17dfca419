"""The fabrics of table.py by name."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from .._core import ClothMaterial, InvalidInput
from .fabric import Fabric
from .rigidity import bending_from_strips
from .table import BANDS, FABRICS, SOURCES, Row

__all__ = ["Catalogue", "catalogue"]


class Catalogue(Mapping[str, Fabric]):
    """A read-only mapping of fabrics by name."""

    def __init__(self, fabrics: dict[str, Fabric]) -> None:
        self._fabrics = fabrics

    def __getitem__(self, name: str) -> Fabric:
        if name in self._fabrics:
            return self._fabrics[name]
        close = difflib.get_close_matches(str(name).lower(), self._fabrics, 3)
        hint = (
            f"did you mean {' or '.join(map(repr, close))}?"
            if close
            else f"known: {', '.join(self._fabrics)}"
        )
        raise InvalidInput(f"there is no fabric {name!r}; {hint}")

    # Mapping.get() relies on a KeyError, but [] raises InvalidInput for an unknown name.
    def get(self, name: str, default: Any = None) -> Any:
        return self._fabrics.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self._fabrics

    def __iter__(self) -> Iterator[str]:
        return iter(self._fabrics)

    def __len__(self) -> int:
        return len(self._fabrics)

    def __repr__(self) -> str:
        return f"fabrics({', '.join(self._fabrics)})"


def _of_row(name: str, row: Row) -> Fabric:
    weft, warp, bias = row.bending
    material = ClothMaterial(
        weft_stiffness=row.weft,
        warp_stiffness=row.warp,
        shear_stiffness=row.shear,
        poisson=row.poisson,
        density=row.density,
        **bending_from_strips(weft=weft, warp=warp, bias=bias),
    )
    source = SOURCES[row.source]
    return Fabric(
        material,
        name=name,
        limits=row.limits,
        use=row.use,
        composition=row.composition,
        construction=row.construction,
        source=source.citation,
        licence=source.licence,
        caveats=row.caveats,
        band=BANDS.get(row.band),
    )


catalogue = Catalogue({name: _of_row(name, row) for name, row in FABRICS.items()})
