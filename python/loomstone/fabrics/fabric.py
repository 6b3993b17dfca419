"""A material with its strain limits and the source of its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import inf, isfinite
from typing import Any

from .._core import ClothMaterial, InvalidInput, StrainLimit
from .rigidity import strip_rigidity
from .table import Band

__all__ = ["Fabric", "ModeFit"]


@dataclass(frozen=True)
class ModeFit:
    """The fit of one mode of deformation to a measured curve.

    stiffness : stiffness [N/m], or bending rigidity [N m]
    limit : strain limit [1]: e12 for shear, inf for bending
    misfit : root mean square deviation from the curve up to the limit, relative to the largest load
        (for bending: moment) in this range [1]
    points : number of points of the curve up to the limit, to which the stiffness was fitted
    """

    stiffness: float
    limit: float
    misfit: float
    points: int


class Fabric(ClothMaterial):
    """A ClothMaterial with its strain limits and the source of its numbers.

    It is passed to a cloth as Cloth(material=fabric) or, with strain limits, as
    Cloth(material=fabric, strain_limit=fabric.strain_limit).

    name, use, composition, construction : descriptions in words
    limits : largest strain along weft and warp, and largest shear strain e12 [1]; inf if unknown
    source, licence : source of the numbers and its licence
    caveats : limitations of the numbers
    band : published range of the drape coefficient [%] of similar fabrics, or None
    fits : fit of each mode of deformation by name ("weft"), for fabrics made by ls.fit_fabric
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
        """The same material as a plain ClothMaterial."""
        return self._material

    @property
    def name(self) -> str:
        """Name of the fabric, such as "cotton"."""
        return str(self._about["name"])

    @property
    def use(self) -> str:
        """Typical use."""
        return str(self._about["use"])

    @property
    def composition(self) -> str:
        """Fibres; empty if unknown."""
        return str(self._about["composition"])

    @property
    def construction(self) -> str:
        """Construction, such as woven or knit; empty if unknown."""
        return str(self._about["construction"])

    @property
    def limits(self) -> tuple[float, float, float]:
        """Largest strain along weft and warp, and largest shear strain e12 [1]; inf if unknown.

        The strain is U - I with the right stretch tensor U.
        """
        limits: tuple[float, float, float] = self._about["limits"]
        return limits

    @property
    def strain_limit(self) -> StrainLimit | None:
        """StrainLimit for a Cloth, without limits on compression; None if no limit is known."""
        return StrainLimit(*self.limits) if any(map(isfinite, self.limits)) else None

    @property
    def source(self) -> str:
        """Bibliographic reference or other source of the numbers."""
        return str(self._about["source"])

    @property
    def licence(self) -> str:
        """Licence of the numbers; empty if none is stated."""
        return str(self._about["licence"])

    @property
    def caveats(self) -> tuple[str, ...]:
        """Limitations of the numbers."""
        caveats: tuple[str, ...] = self._about["caveats"]
        return caveats

    @property
    def band(self) -> Band | None:
        """Published range of Cusick's drape coefficient [%] of similar fabrics, or None."""
        band: Band | None = self._about["band"]
        return band

    @property
    def fits(self) -> dict[str, ModeFit]:
        """Fit of each mode of deformation by name ("weft"); empty without measured curves."""
        return dict(self._fits)

    def __repr__(self) -> str:
        kind = f" ({self.construction})" if self.construction else ""
        rigidities = self._strip_rigidities()
        bending = ", ".join(f"{1e6 * rigidity:.3g}" for rigidity in rigidities)
        limits = ", ".join(
            f"{100 * limit:.3g} %" if isfinite(limit) else "none" for limit in self.limits
        )
        return (
            f"<Fabric {self.name!r}{kind}: {1e3 * self.density:.4g} g/m^2; weft, warp, shear "
            f"{self.weft_stiffness:.4g}, "
            f"{self.warp_stiffness:.4g}, {self.shear_stiffness:.4g} N/m, limits {limits}; "
            f"bending weft, warp, bias {bending + ' uN m' if rigidities else 'not all defined'}>"
        )

    def _strip_rigidities(self) -> tuple[float, ...]:
        """Returns the rigidities of strips along weft, warp and bias [N m].

        Returns an empty tuple unless the material resists bending in every direction.
        """
        try:
            return tuple(strip_rigidity(self, angle_degrees=angle) for angle in (0, 90, 45))
        except InvalidInput:
            return ()

    def to_dict(self) -> dict[str, Any]:
        """Returns plain values for JSON: the fields of material and fabric, and `bending_bias`.

        `bending_bias` is the rigidity of a strip on the bias [N m]; it is 0 unless the material
        resists bending in every direction. An infinite limit is None.
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
        return about | {"bending_bias": (self._strip_rigidities() or (0.0,))[-1]} | fields


def _rebuilt(material: ClothMaterial, about: dict[str, Any]) -> Fabric:
    return Fabric(material, **about)


def _or_none(limit: float) -> float | None:
    return limit if isfinite(limit) else None
