"""Conversion between the bending stiffness of a plate and rigidities of strips cut from it.

A strip with free edges that is bent along its length carries no transverse bending moment and no
twisting moment. Let D be the plate's rigidity for the curvatures (k11, k22, 2 k12), and S = D^-1. A
strip at the angle a to weft has the rigidity B(a) with

    1 / B(a) = S11 c^4 + S22 s^4 + (2 S12 + S33) c^2 s^2,    c = cos a, s = sin a

[Lekhnitskii1968]. `bending_from_strips` solves this for strips along weft, along warp and on the
bias (45 degrees): S11 = 1 / B(0), S22 = 1 / B(90) and S33 = 4 / B(45) - S11 - S22 - 2 S12, where
S12 is minus the given Poisson ratio times S11.

Without a strip on the bias, the twisting rigidity is that of Huber's orthotropic plate, D33 =
(sqrt(D11 D22) - D12) / 2 [Huber1923]. ClothMaterial has the same default. This relation is exact
for isotropic plates. If the Poisson ratio is 0, it gives strips the rigidities

    1 / sqrt(B(a)) = c^2 / sqrt(B(0)) + s^2 / sqrt(B(90))
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._core import ClothMaterial, InvalidInput
from ..base.arguments import takes
from ..base.quantities import in_unit

__all__ = ["bending_from_strips", "strip_rigidity"]


@takes(weft="N m", warp="N m", bias="N m", poisson="1")
def bending_from_strips(
    *, weft: Any, warp: Any, bias: Any = None, poisson: float = 0.0
) -> dict[str, float]:
    """Returns the bending parameters of a ClothMaterial, as keywords, from rigidities of strips.

    weft, warp, bias : rigidity of strips cut along weft, along warp and at 45 degrees [N m], or
        quantities with a unit. Without `bias`, the twisting rigidity is estimated from weft and
        warp by Huber's relation for orthotropic plates, (sqrt(D11 D22) - D12) / 2. For the fabrics
        of ls.fabrics, strips on the bias then have 0.72 to 1.29 times their tabulated rigidity.
    poisson : Poisson ratio of bending: minus the ratio of transverse to longitudinal curvature of a
        strip along weft [1]; near 0 for fabrics

    Raises InvalidInput if a rigidity is not positive, or if no plate has strips with these
    rigidities: |poisson| must be below sqrt(weft / warp), and 4 / bias must exceed
    1 / weft + 1 / warp - 2 poisson / weft.

    >>> import loomstone as ls
    >>> bending = ls.fabrics.bending_from_strips(weft=8e-6, warp=1.2e-5, bias=9e-6)
    >>> material = ls.ClothMaterial(**bending)
    >>> round(ls.fabrics.strip_rigidity(material, angle_degrees=45), 12)
    9e-06
    >>> estimated = ls.ClothMaterial(**ls.fabrics.bending_from_strips(weft=8e-6, warp=1.2e-5))
    >>> round(ls.fabrics.strip_rigidity(estimated, angle_degrees=45), 8)
    9.7e-06
    """
    given = {
        name: _rigidity(name, value)
        for name, value in (("weft", weft), ("warp", warp), ("bias", bias))
        if not (name == "bias" and value is None)
    }
    s11, s22 = 1.0 / given["weft"], 1.0 / given["warp"]
    if not (math.isfinite(poisson) and poisson**2 * s11 < s22):
        raise InvalidInput(
            "bending_from_strips: poisson must be below sqrt(weft / warp) ="
            f" {math.sqrt(s22 / s11):.4g} in magnitude, got {poisson}"
        )
    s12 = -poisson * s11
    determinant = s11 * s22 - s12**2
    d11, d22, d12 = s22 / determinant, s11 / determinant, -s12 / determinant
    if "bias" in given:
        s33 = 4.0 / given["bias"] - s11 - s22 - 2.0 * s12
        if not s33 > 0.0:
            raise InvalidInput(
                f"bending_from_strips: no plate has a bias rigidity of {given['bias']:.4g} [N m]"
                f" with {given['weft']:.4g} along weft and {given['warp']:.4g} along warp; bias"
                f" must be below {4.0 / (s11 + s22 + 2.0 * s12):.4g}"
            )
        d33 = 1.0 / s33
    else:
        d33 = _hubers_twist(d11, d22, d12)
    return {
        "bending_weft": d11,
        "bending_warp": d22,
        "bending_twist": d33,
        "bending_coupling": d12,
    }


@takes(angle_degrees="degrees")
def strip_rigidity(material: ClothMaterial, *, angle_degrees: float = 0.0) -> float:
    """Returns the rigidity [N m] of a strip cut at an angle to weft.

    angle_degrees : 0 for weft, 90 for warp and 45 for the bias

    Raises InvalidInput unless the material resists bending in every direction.
    """
    d11, d22, d12, d33 = (
        material.bending_weft,
        material.bending_warp,
        material.bending_coupling,
        material.bending_twist,
    )
    if d33 < 0.0:
        d33 = _hubers_twist(d11, d22, d12)
    determinant = d11 * d22 - d12**2
    if not (determinant > 0.0 and d33 > 0.0):
        raise InvalidInput(
            "strip_rigidity: the material must resist bending along weft, along warp and twisting,"
            " but one is 0"
        )
    angle = np.radians(angle_degrees)
    c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
    return float(1.0 / ((d22 * c**2 + d11 * s**2 - 2.0 * d12 * c * s) / determinant + c * s / d33))


def _hubers_twist(d11: float, d22: float, d12: float) -> float:
    """Returns the twisting rigidity D33 of Huber's orthotropic plate [N m]."""
    return 0.5 * (math.sqrt(d11 * d22) - d12)


def _rigidity(name: str, value: Any) -> float:
    number = in_unit(value, "N m", f"bending_from_strips: {name}")
    if not isinstance(number, (int, float, np.number)) or not (np.isfinite(number) and number > 0):
        raise InvalidInput(f"bending_from_strips: {name} must be > 0 [N m], got {value!r}")
    return float(number)
