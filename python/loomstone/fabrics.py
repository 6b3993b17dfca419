"""Materials of real fabrics by name.

Woven "cotton", "wool", "canvas", "silk", "denim": stiffness along weft, warp and in shear, and area density as used by
Codim-IPC (Li, Kaufman, Jiang 2021); their bending rigidity is the median of 618 measured fabrics of that area density
(DrapeTester). All others: measured by Wang, O'Brien and Ramamoorthi 2011, at small strain.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from ._core import ClothMaterial, InvalidInput

__all__ = ["fabrics"]


class _Fabrics(Mapping[str, ClothMaterial]):
    """Materials by name, fixed."""

    def __init__(self, materials: dict[str, ClothMaterial]) -> None:
        self._materials = materials

    def __getitem__(self, name: str) -> ClothMaterial:
        if name in self._materials:
            return self._materials[name]
        close = difflib.get_close_matches(str(name), self._materials, 1)
        hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(self._materials)}"
        raise InvalidInput(f"there is no fabric {name!r}; {hint}")

    def get(self, name: str, default: Any = None) -> Any:  # not through [], which raises no KeyError
        return self._materials.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self._materials

    def __iter__(self) -> Iterator[str]:
        return iter(self._materials)

    def __len__(self) -> int:
        return len(self._materials)

    def __repr__(self) -> str:
        return f"fabrics({', '.join(self._materials)})"


def _woven(weft: float, warp: float, shear: float, density: float, bending: float) -> ClothMaterial:
    return ClothMaterial(
        weft_stiffness=weft,
        warp_stiffness=warp,
        shear_stiffness=shear,
        density=density,
        bending_weft=bending,
        bending_warp=bending,
    )


def _measured(
    c11: float, c22: float, c12: float, shear: float, density: float, bending_weft: float, bending_warp: float
) -> ClothMaterial:
    """Plane-stress matrix entries [N/m] to Young's moduli: E1 = C11 - C12^2 / C22, nu12 = C12 / C22."""
    return ClothMaterial(
        weft_stiffness=c11 - c12**2 / c22,
        warp_stiffness=c22 - c12**2 / c11,
        shear_stiffness=shear,
        poisson=c12 / c22,
        density=density,
        bending_weft=bending_weft,
        bending_warp=bending_warp,
    )


fabrics: Mapping[str, ClothMaterial] = _Fabrics(
    {
        "cotton": _woven(2800.26, 4500.72, 96.84, 0.1036, 5.98e-6),
        "wool": _woven(2931.2, 2840.32, 237.44, 0.4806, 7.5e-5),
        "canvas": _woven(2843.98, 10496.1, 532.385, 0.294, 1.96e-5),
        "silk": _woven(774.0, 1789.56, 51.3, 0.083, 5.98e-6),
        "denim": _woven(3163.38, 5959.14, 807.84, 0.4, 4.67e-5),
        "rib knit": _measured(85.742, 130.332, 0.0, 83.1756, 0.276, 8.06e-6, 1.156e-5),
        "blanket": _measured(303.008, 489.661, 212.056, 30.2502, 0.228, 1.494e-5, 2.927e-5),
        "tablecloth": _measured(4004.17, 4054.97, 0.691, 19.189, 0.128, 7.82e-6, 1.293e-5),
        "sweater": _measured(24.9727, 6.54487, 0.0, 17.6163, 0.224, 1.141e-5, 1.487e-5),
        "ponte": _measured(62.2924, 88.0573, 0.0, 31.8964, 0.284, 9.29e-6, 9.09e-6),
        "t-shirt": _measured(33.1877, 68.9542, 0.0, 36.8603, 0.187, 3.57e-6, 5.80e-6),
        "stretch denim": _measured(410.704, 2027.77, 20.4682, 53.3872, 0.324, 2.424e-5, 1.605e-5),
        "swimsuit": _measured(95.9424, 209.231, 13.669, 60.7737, 0.204, 1.275e-5, 1.506e-5),
        "jacket": _measured(86.1353, 342.85, 108.747, 14.3147, 0.113, 5.09e-6, 3.57e-6),
        "pants": _measured(4033.11, 4069.95, 18.341, 104.76, 0.22, 3.135e-5, 3.135e-5),
    }
)
