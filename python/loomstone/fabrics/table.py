"""Numbers of the fabrics in `loomstone.fabrics`, in SI units, and their sources.

The sources of FABRICS are [Wang2011], [Li2021] and [Feng2022]. docs/fabrics.md describes how the
numbers in FABRICS were derived from published ones. No table of a source is reproduced here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

__all__ = ["BANDS", "FABRICS", "LEVELS", "SOURCES", "Band", "Level", "Row", "Source"]


@dataclass(frozen=True)
class Source:
    """A publication from which numbers of fabrics are derived.

    citation : bibliographic reference
    licence : terms stated by the rights holders
    mapping : conversion of the published numbers to those of a ClothMaterial
    """

    citation: str
    licence: str
    mapping: str


@dataclass(frozen=True)
class Band:
    """Published range of Cusick's drape coefficient [%] for a kind of fabric."""

    low: float
    high: float
    citation: str


@dataclass(frozen=True)
class Row:
    """Description and numbers of a fabric, with its Poisson ratio nu12 [1] and density [kg/m^2].

    source, band : keys of SOURCES and BANDS; band is "" if no range is given
    weft, warp : Young's modulus along weft or warp, times the thickness [N/m]
    shear : shear modulus times thickness, the load per engineering shear [N/m]
    bending : rigidities of strips cut along weft, along warp and on the bias [N m]
    limits : largest strain along weft and warp, and largest shear strain e12 [1]; inf if unknown.
        The strain is U - I with the right stretch tensor U.
    """

    source: str
    use: str
    composition: str
    construction: str
    weft: float
    warp: float
    shear: float
    poisson: float
    density: float
    bending: tuple[float, float, float]
    limits: tuple[float, float, float]
    caveats: tuple[str, ...] = ()
    band: str = ""


SOURCES = {
    "Wang 2011": Source(
        "H. Wang, J. F. O'Brien, R. Ramamoorthi: Data-Driven Elastic Models for Cloth, ACM Trans."
        " Graph. 30(4):71, 2011 (Berkeley Garment Library)",
        "as is; publications that use the measurements shall cite the paper",
        "stiffness at zero strain as ARCSim simulates it (twice the tabulated values, negative"
        " coupling set to 0); bending = hinge coefficient / 4 at small curvature; limit = strain"
        " at 150 gf/cm (147 N/m) on the curve between the measurements at 0 and 16.7 %, if it"
        " reaches this load",
    ),
    "Codim-IPC": Source(
        "M. Li, D. M. Kaufman, C. Jiang: Codimensional Incremental Potential Contact, ACM Trans."
        " Graph. 40(4):170, 2021 (source code); bending: median of fabrics of that weight among"
        " 618 of X. Feng, W. Huang, W. Xu, H. Wang: Learning-Based Bending Stiffness Parameter"
        " Estimation by a Drape Tester, ACM Trans. Graph. 41(6), 2022",
        "Apache-2.0; of the 618 fabrics only medians are used",
        "orthotropic moduli times thickness, coupling included; limits of Green strain as strains"
        " of U - I; bending along warp: the median, along weft 0.635 and on the bias 0.832 of it,"
        " the ratios of the medians of all 618",
    ),
}

_COTTON = Band(60, 76, "Gan, Ly, Steven 1991 (measured 68.4)")
_DENIM = Band(70, 90, "Cusick, heavy twill")
BANDS = {
    "cotton": _COTTON,
    "wool": Band(40, 70, "studies of worsted wool"),
    "silk": Band(20, 40, "Matsudaira, Yang 2003; Hu et al. 2020"),
    "denim": _DENIM,
}

_MEDIAN = "bending is a median of fabrics of its weight, not measured on this fabric"
_COUPLED = (
    "the source sets the coupling to half of one modulus and does not say where its moduli come"
    " from"
)
_GSM = "the source's density is read as g/m^2: as kg/m^3 it would be far too light"
_ASSUMED = (_MEDIAN, _COUPLED, _GSM)
_FACTOR = (
    "stiffness is ambiguous by a factor of 2 (labelled or simulated); the simulated, larger one is"
    " used"
)
_KE = (
    "bending is ambiguous by a factor of 4 (ARCSim also reads the hinge coefficient as the rigidity"
    " itself)"
)
_SATURATED = "stiffness looks like a saturated fit, nearly the same for two fabrics: a lower bound"
_OPEN = "the load of 150 gf/cm is not reached within the 16.7 % measured: no limit along weft"
_OPEN_BOTH = "the load of 150 gf/cm is not reached within the 16.7 % measured: no limits"
_NEGATIVE = "the fit's negative coupling is set to 0"


def _bending(warp: float) -> tuple[float, float, float]:
    """Returns the rigidities of strips along weft, along warp and on the bias [N m].

    The ratios to `warp` are those of the medians of all fabrics in [Feng2022].

    warp : rigidity along warp [N m]: the median of those fabrics in [Feng2022] that have a similar
        mass per area
    """
    return 0.6354 * warp, warp, 0.8316 * warp


Numbers = tuple[float, float, float, float, float]  # weft, warp, shear, Poisson ratio, density


def _woven(
    use: str,
    numbers: Numbers,
    warp_bending: float,
    limits: tuple[float, float, float],
    band: str = "",
) -> Row:
    return Row(
        "Codim-IPC", use, "", "woven", *numbers, _bending(warp_bending), limits, _ASSUMED, band
    )


def _measured(
    about: tuple[str, str, str],
    numbers: Numbers,
    bending: tuple[float, float, float],
    limits: tuple[float, float],
    caveats: tuple[str, ...] = (),
    band: str = "",
) -> Row:
    """Returns the row of a fabric of [Wang2011].

    about : use, composition, construction
    """
    caveats = (_FACTOR, _KE, *caveats)
    return Row(
        "Wang 2011",
        *about,
        *numbers,
        bending,
        (*limits, inf),
        caveats,
        band,
    )


FABRICS = {
    "cotton": _woven(
        "shirts", (2365, 3801, 96.84, 0.3111, 0.1036), 5.98e-6, (0.1314, 0.1314, 0.0631), "cotton"
    ),
    "wool": _woven(
        "coats", (2175, 2108, 237.4, 0.516, 0.4806), 7.5e-5, (0.4142, 0.4967, 0.1209), "wool"
    ),
    "canvas": _woven(
        "bags, sails", (2651, 9785, 532.4, 0.1355, 0.294), 1.96e-5, (0.1045, 0.0649, 0.0591)
    ),
    "silk": _woven(
        "scarves, flags",
        (326.6, 755.2, 51.3, 0.5, 0.083),
        5.98e-6,
        (0.3491, 0.2961, 0.1107),
        "silk",
    ),
    "denim": _woven(
        "jeans", (1673, 3152, 807.8, 0.5, 0.4), 4.67e-5, (0.249, 0.249, 0.0501), "denim"
    ),
    "rib knit": _measured(
        ("underwear", "95 % cotton, 5 % spandex", "knit"),
        (85.74, 130.3, 83.18, 0.0, 0.276),
        (8.061e-6, 1.156e-5, 7.504e-6),
        (inf, inf),
        (_OPEN_BOTH, _NEGATIVE),
    ),
    "blanket": _measured(
        ("blanket", "100 % polyester", ""),
        (211.2, 341.3, 30.25, 0.4331, 0.228),
        (1.494e-5, 2.927e-5, 2.188e-5),
        (inf, 0.1634),
        (_OPEN,),
    ),
    "tablecloth": _measured(
        ("tablecloth", "100 % polyester", ""),
        (4004, 4055, 19.19, 0.0002, 0.128),
        (7.821e-6, 1.293e-5, 1.016e-5),
        (0.0345, 0.0341),
        (_SATURATED,),
    ),
    "sweater": _measured(
        ("sweater", "96 % polyester, 4 % spandex", "knit"),
        (24.97, 6.545, 17.62, 0.0, 0.224),
        (1.141e-5, 1.487e-5, 1.002e-5),
        (inf, inf),
        (_OPEN_BOTH, _NEGATIVE),
    ),
    "ponte": _measured(
        ("jacket", "60 % polyester, 40 % rayon", "knit"),
        (62.29, 88.06, 31.9, 0.0, 0.284),
        (9.289e-6, 9.087e-6, 8.253e-6),
        (inf, inf),
        (_OPEN_BOTH, _NEGATIVE),
    ),
    "t-shirt": _measured(
        ("T-shirt", "60 % cotton, 40 % polyester", "knit"),
        (33.19, 68.95, 36.86, 0.0, 0.187),
        (3.567e-6, 5.798e-6, 6.187e-6),
        (inf, 0.1553),
        (_OPEN, _NEGATIVE),
    ),
    "stretch denim": _measured(
        ("jeans", "99 % cotton, 1 % spandex", "woven"),
        (410.5, 2027, 53.39, 0.0101, 0.324),
        (2.424e-5, 1.605e-5, 1.835e-5),
        (inf, 0.065),
        (_OPEN,),
        "denim",
    ),
    "swimsuit": _measured(
        ("swimsuit", "87 % nylon, 13 % spandex", "knit"),
        (95.05, 207.3, 60.77, 0.0653, 0.204),
        (1.275e-5, 1.506e-5, 1.47e-5),
        (inf, inf),
        (_OPEN_BOTH,),
    ),
    "jacket": _measured(
        ("jacket", "100 % polyester", ""),
        (51.64, 205.6, 14.31, 0.3172, 0.113),
        (5.086e-6, 3.573e-6, 5.488e-6),
        (inf, 0.1534),
        (_OPEN,),
    ),
    "pants": _measured(
        ("trousers", "65 % cotton, 35 % polyester", ""),
        (4033, 4070, 104.8, 0.0045, 0.22),
        (3.135e-5, 3.135e-5, 2.7e-5),
        (0.0343, 0.034),
        (_SATURATED,),
    ),
}


@dataclass(frozen=True)
class Level:
    """The numbers that a level such as "soft" stands for; see of_levels() in levels.py.

    stiffness, limit : stiffness [N/m] and largest strain [1] along weft or warp
    shear, shear_limit : stiffness [N/m] and largest strain e12 [1] in shear
    bending : bending rigidity [N m]
    """

    stiffness: float
    limit: float
    shear: float
    shear_limit: float
    bending: float


# The bending rigidities are the percentiles 5, 25, 50, 75 and 95 of those that [Feng2022] measured
# along warp on 618 fabrics. Stiffness and limits are chosen, not measured. Figure 3.5 of
# [Thomaszewski2010] shows limits of 2, 5 and 15 % strain.
LEVELS = {
    "very soft": Level(50.0, 0.30, 20.0, 0.30, 1.1e-6),
    "soft": Level(150.0, 0.15, 40.0, 0.20, 4.1e-6),
    "medium": Level(500.0, 0.10, 80.0, 0.15, 1.4e-5),
    "firm": Level(1500.0, 0.05, 200.0, 0.10, 3.6e-5),
    "stiff": Level(5000.0, 0.02, 500.0, 0.05, 1.1e-4),
}
