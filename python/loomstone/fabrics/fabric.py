"""Real fabrics by name, and fabrics by named levels for artists.

>>> import loomstone as ls
>>> cotton = ls.fabrics["cotton"]
>>> cloth = ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), triangles=200), material=cotton)
>>> print(f"{cotton.density:g} kg/m^2, {cotton.warp_stiffness:g} N/m along warp")
0.1036 kg/m^2, 3801 N/m along warp

Numbers and sources are in fabric_table.py; how they were mapped and what to beware of, in
docs/fabrics.md.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from math import inf, isfinite
from typing import Any

from .._core import ClothMaterial, InvalidInput, StrainLimit
from .table import BANDS, FABRICS, LEVELS, SOURCES, Band, Level, Row
from .rigidity import bending_from_strips, strip_rigidity
from ..units import number_in

__all__ = ["Fabric", "ModeFit", "fabric_of_levels", "fabrics"]


@dataclass(frozen=True)
class ModeFit:
    """One mode fitted to a curve.

    stiffness : [N/m], of bending [N m]; limit : largest strain [1], inf for bending
    misfit : root mean square difference from the curve over its largest load [1]; points : of the
        curve that were used
    """

    stiffness: float
    limit: float
    misfit: float
    points: int


class Fabric(ClothMaterial):
    """A ClothMaterial with its limits of strain and where its numbers come from.

    Used as Cloth(material=fabric), or Cloth(material=fabric, strain_limit=fabric.strain_limit).

    name, use, composition, construction : texts
    limits : largest strain along weft and warp, and largest shear strain e12 [1]; inf where none is
        known
    source, licence : where the numbers come from
    caveats : what to beware of, a sentence each
    band : published range of the drape coefficient of such fabrics, or None
    fits : how each mode was fitted, for fabrics made by fit_fabric
    """

    __slots__ = ("_about", "_fits", "_material")

    def __init__(
        self,
        material: ClothMaterial,
        *,
        name: str,
        limits: tuple[float, float, float] = (inf, inf, inf),
        use: str = "",
        composition: str = "",
        construction: str = "",
        source: str = "",
        licence: str = "",
        caveats: tuple[str, ...] = (),
        band: Band | None = None,
        fits: Mapping[str, ModeFit] | None = None,
    ) -> None:
        super().__init__(**{field: getattr(material, field) for field in ClothMaterial.field_names})
        self._material = material
        self._fits = dict(fits or {})
        self._about: dict[str, Any] = {
            "name": name,
            "use": use,
            "composition": composition,
            "construction": construction,
            "limits": limits,
            "source": source,
            "licence": licence,
            "caveats": caveats,
            "band": band,
        }

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self._material, self._about | {"fits": self._fits})

    @property
    def material(self) -> ClothMaterial:
        """The plain ClothMaterial."""
        return self._material

    @property
    def name(self) -> str:
        """Name of the fabric."""
        return str(self._about["name"])

    @property
    def use(self) -> str:
        """Typical use."""
        return str(self._about["use"])

    @property
    def composition(self) -> str:
        """Fibres, or empty where unknown."""
        return str(self._about["composition"])

    @property
    def construction(self) -> str:
        """woven, knit, or empty where unknown."""
        return str(self._about["construction"])

    @property
    def limits(self) -> tuple[float, float, float]:
        """Largest strain U - I along weft and warp, and largest e12 [1]; inf: none known."""
        limits: tuple[float, float, float] = self._about["limits"]
        return limits

    @property
    def strain_limit(self) -> StrainLimit | None:
        """The limits for a Cloth, compression free; None where none is known."""
        return StrainLimit(*self.limits) if any(map(isfinite, self.limits)) else None

    @property
    def source(self) -> str:
        """Citation."""
        return str(self._about["source"])

    @property
    def licence(self) -> str:
        """What the holders of the source say."""
        return str(self._about["licence"])

    @property
    def caveats(self) -> tuple[str, ...]:
        """What to beware of."""
        caveats: tuple[str, ...] = self._about["caveats"]
        return caveats

    @property
    def band(self) -> Band | None:
        """Published range of Cusick's drape coefficient [%] of such fabrics, or None."""
        band: Band | None = self._about["band"]
        return band

    @property
    def fits(self) -> dict[str, ModeFit]:
        """How each mode was fitted; empty for other fabrics than those of fit_fabric."""
        return dict(self._fits)

    def __repr__(self) -> str:
        kind = f" ({self.construction})" if self.construction else ""
        bending = (
            (1e6 * strip_rigidity(self, angle_degrees=angle) for angle in (0, 90, 45))
            if self.bending_weft > 0
            else ()
        )
        limits = ", ".join(
            f"{100 * limit:.3g} %" if isfinite(limit) else "none" for limit in self.limits
        )
        return (
            f"<Fabric {self.name!r}{kind}: {1e3 * self.density:.4g} g/m^2; weft, warp, shear "
            f"{self.weft_stiffness:.4g}, "
            f"{self.warp_stiffness:.4g}, {self.shear_stiffness:.4g} N/m, limits {limits}; "
            f"bending weft, warp, bias {', '.join(f'{b:.3g}' for b in bending)} uN m>"
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON: the fields of the material, and about the fabric; no limit is
        None.
        """
        band = self.band
        about = self._about | {
            "limits": dict(zip(("weft", "warp", "shear"), map(_or_none, self.limits), strict=True)),
            "caveats": list(self.caveats),
            "fits": {
                mode: asdict(fit) | {"limit": _or_none(fit.limit)}
                for mode, fit in self._fits.items()
            },
            "band": (
                {"low": band.low, "high": band.high, "citation": band.citation} if band else None
            ),
        }
        fields: dict[str, Any] = self._material.to_dict()
        return (
            about
            | {
                "bending_bias": (
                    strip_rigidity(self, angle_degrees=45) if self.bending_weft > 0 else 0.0
                )
            }
            | fields
        )


def _rebuilt(material: ClothMaterial, about: dict[str, Any]) -> Fabric:
    return Fabric(material, **about)


def _or_none(limit: float) -> float | None:
    return limit if isfinite(limit) else None


class _Fabrics(Mapping[str, Fabric]):
    """Fabrics by name, fixed."""

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

    def get(
        self, name: str, default: Any = None
    ) -> Any:  # not through [], which raises no KeyError
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


fabrics: Mapping[str, Fabric] = _Fabrics(
    {name: _of_row(name, row) for name, row in FABRICS.items()}
)


def fabric_of_levels(
    *,
    weft: str = "medium",
    warp: str = "medium",
    shear: str = "medium",
    bending: str = "medium",
    density: Any = 0.15,
) -> Fabric:
    """A fabric by levels: "very soft", "soft", "medium", "firm" or "stiff" for each mode (thesis
    3.3.3).

    weft, warp, shear : each sets a stiffness and a limit of strain; bending : rigidity in all
        directions
    density : [kg/m^2], or with a unit

    >>> fabric_of_levels(weft="soft", warp="stiff").limits
    (0.15, 0.02, 0.15)
    """
    levels = {mode: _level(mode, level) for mode, level in
              (("weft", weft), ("warp", warp), ("shear", shear), ("bending", bending))}  # fmt: skip
    material = ClothMaterial(
        weft_stiffness=levels["weft"].stiffness,
        warp_stiffness=levels["warp"].stiffness,
        shear_stiffness=levels["shear"].shear,
        bending_weft=levels["bending"].bending,
        bending_warp=levels["bending"].bending,
        density=number_in(density, "kg/m^2", "fabric_of_levels: density"),
    )
    limits = (levels["weft"].limit, levels["warp"].limit, levels["shear"].shear_limit)
    name = f"{weft} weft, {warp} warp, {shear} shear, {bending} bending"
    return Fabric(
        material,
        name=name,
        limits=limits,
        source="levels for artists: our choice, bending by percentiles of 618 fabrics",
    )


def _level(mode: str, level: str) -> Level:
    if level not in LEVELS:
        raise InvalidInput(
            f"fabric_of_levels: {mode} must be one of {', '.join(LEVELS)}, got {level!r}"
        )
    return LEVELS[level]
