"""Fits a fabric to measured curves, as in section 3.3.3 of [Thomaszewski2010].

Each mode of deformation is described by a stiffness and, except for bending, a limit: the strain at
which the measured curve first reaches a given load (default 150 gf/cm). The shear limit can also be
given directly. The stiffness is fitted to the curve up to the limit (for bending, to the whole
curve), by least squares in closed form. The model has the stiffnesses E and G [N/m] and the bending
rigidity B [N m]. In equilibrium, its load P [N/m] or moment M [N] per width is as follows, where
(2.23) is an equation of [Thomaszewski2010]:

    weft, warp:  P = E l (l^2 - 1) / 2,  l = 1 + strain   uniaxial: (2.23) without transverse load
    shear:       P = G g,  g = tan(angle)                 engineering shear g, to first order
    bending:     M = B k                                  curvature k

The shear limit is given as the component e12 of U - I, where U is the right stretch tensor. In a
simple shear g, e12 is g / sqrt(4 + g^2). Tensile tests of the Kawabata system clamp a short and
wide sample. They therefore measure E / (1 - nu12 nu21) instead of E, where nu12 and nu21 are the
Poisson ratios. These two stiffnesses are equal here, because the Poisson ratios of fitted materials
are 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import ClothMaterial, InvalidInput
from ..base.arguments import takes
from ..base.quantities import in_unit, is_angle, number_in
from .fabric import Fabric, ModeFit
from .rigidity import bending_from_strips

__all__ = ["fit"]

Floats = NDArray[np.float64]
TENSILE, BENDING = ("weft", "warp", "shear"), ("bending_weft", "bending_warp", "bending_bias")
LOAD = 150 * 0.980665  # 150 gf/cm [N/m]


@takes(density="kg/m^2", load="N/m", shear_limit="1")
def fit(
    curves: Mapping[str, Any],
    *,
    density: Any,
    load: Any = LOAD,
    shear_limit: float | None = None,
    name: str = "fitted",
) -> Fabric:
    """Returns a Fabric whose stiffness and limits are fitted to measured curves.

    curves : curves by name: "weft", "warp", "shear" and, if strips were bent, "bending_weft" and
        "bending_warp", with or without "bending_bias". Each is a pair (strain, load) of arrays of
        equal length, or an (n x 2) array. Weft and warp: strain [1], load per width [N/m]. Shear:
        engineering shear [1] or angle (ls.units["deg"]), load per width [N/m]. Bending: curvature
        [1/m], moment per width [N]. Arrays may carry units: (ls.units["%"] * strain,
        ls.units["gf/cm"] * load).
    density : mass per area [kg/m^2], or a quantity with a unit
    load : load per width that defines the limits [N/m], or a quantity with a unit
    shear_limit : largest shear strain e12, in (0, 1) [1]; None: the strain at which the shear curve
        first reaches `load`

    Raises InvalidInput for curves that cannot be fitted, for instance if values are not finite
    numbers, strain does not increase, fewer than four points up to the limit have a strain other
    than 0, or a curve that defines a limit never reaches `load`. Without bending curves, the
    material has the default bending rigidities of ClothMaterial.

    >>> import numpy as np
    >>> strain = np.linspace(0, 0.1, 40)
    >>> loads = {"weft": 2000 * strain, "warp": 4000 * strain, "shear": 80 * strain}
    >>> curves = {mode: (strain, load) for mode, load in loads.items()}
    >>> fabric = fit(curves, density=0.15, shear_limit=0.2)
    >>> [round(limit, 4) for limit in fabric.limits]
    [0.0735, 0.0368, 0.2]
    """
    _check_names(curves)
    reached, shear_limit = _limits(load, shear_limit)
    fits = {mode: _fit_stretch(mode, curves[mode], reached) for mode in ("weft", "warp")}
    fits["shear"] = _fit_shear(curves["shear"], reached, shear_limit)
    fits |= {mode: _fit_bending(mode, curves[mode]) for mode in BENDING if mode in curves}
    material = ClothMaterial(
        weft_stiffness=fits["weft"].stiffness,
        warp_stiffness=fits["warp"].stiffness,
        shear_stiffness=fits["shear"].stiffness,
        density=number_in(density, "kg/m^2", "fit: density"),
        **_bending(fits),
    )
    caveats = (
        ()
        if any(mode in fits for mode in BENDING)
        else ("bending was not measured: the default of ClothMaterial",)
    )
    limits = (fits["weft"].limit, fits["warp"].limit, fits["shear"].limit)
    return Fabric(
        material,
        name=name,
        limits=limits,
        source="fitted to measured curves",
        caveats=caveats,
        fits=fits,
    )


def _limits(load: Any, shear_limit: Any) -> tuple[float, float | None]:
    """Checks the load and the shear limit (None: not given), and returns them in SI units."""
    reached = number_in(load, "N/m", "fit: load")
    if not (np.isfinite(reached) and reached > 0):
        raise InvalidInput(f"fit: load must be > 0 [N/m], got {load}")
    if shear_limit is None:
        return reached, None
    largest = number_in(shear_limit, "1", "fit: shear_limit")
    if not 0 < largest < 1:
        raise InvalidInput(f"fit: shear_limit must be in (0, 1) as e12, got {largest}")
    return reached, largest


def _check_names(curves: Mapping[str, Any]) -> None:
    if not isinstance(curves, Mapping):
        raise InvalidInput(
            f"fit: curves must be a dict of curves by name, got a {type(curves).__name__}"
        )
    if unknown := [key for key in curves if key not in TENSILE + BENDING]:
        raise InvalidInput(
            f"fit: there is no curve {unknown[0]!r}; known: {', '.join(TENSILE + BENDING)}"
        )
    if missing := [key for key in TENSILE if key not in curves]:
        raise InvalidInput(
            f"fit: the curve {missing[0]!r} is missing; weft, warp and shear are needed"
        )


def _fit_stretch(mode: str, curve: Any, load: float) -> ModeFit:
    strain, measured = _read(mode, curve, "1", "N/m")
    if strain.max() > 2.0:
        raise InvalidInput(
            f"fit: {mode}: strain must be a pure number, got up to {strain.max():g}; for"
            " percent give strain * ls.units['%']"
        )
    limit = _crossing(mode, strain, measured, load)
    below = strain <= limit
    return _through_origin(
        mode, lambda e: (1 + e) * ((1 + e) ** 2 - 1) / 2, strain[below], measured[below], limit
    )


def _fit_shear(curve: Any, load: float, limit: float | None) -> ModeFit:
    shear, measured = _read("shear", curve, "1", "N/m")
    if shear.max() > 2.0:
        raise InvalidInput(
            f"fit: shear: must be tan(angle), got up to {shear.max():g}; for degrees give"
            " angle * ls.units['deg']"
        )
    if limit is None:
        if measured.max() < load:
            raise InvalidInput(
                f"fit: shear: the curve never reaches the load of {load:.4g} [N/m], but"
                f" only {measured.max():.4g} at a shear of {shear.max():.3g}; give"
                " shear_limit, or a lower load"
            )
        largest = _crossing("shear", shear, measured, load)
        limit = largest / np.sqrt(4 + largest**2)
    else:
        largest = 2 * limit / np.sqrt(1 - limit**2)
    below = shear <= largest
    return _through_origin("shear", lambda g: g, shear[below], measured[below], float(limit))


def _fit_bending(mode: str, curve: Any) -> ModeFit:
    curvature, moment = _read(mode, curve, "1/m", "N")
    return _through_origin(mode, lambda k: k, curvature, moment, inf)


def _bending(fits: dict[str, ModeFit]) -> dict[str, float]:
    given = {
        mode.removeprefix("bending_"): fits[mode].stiffness for mode in BENDING if mode in fits
    }
    if len(given) == 3:
        return bending_from_strips(**given)
    if "bias" in given:
        raise InvalidInput(
            "fit: bending_bias needs bending_weft and bending_warp too; give all three curves"
        )
    if len(given) == 1:
        raise InvalidInput(
            "fit: bending_weft and bending_warp belong together; give both curves, or none"
        )
    return {f"bending_{direction}": rigidity for direction, rigidity in given.items()}


def _read(mode: str, curve: Any, x_unit: str, y_unit: str) -> tuple[Floats, Floats]:
    """Checks a curve; returns its two columns in SI units. Shear angles become their tangents."""
    if not isinstance(curve, (tuple, list)) and np.ndim(curve) == 2 and np.shape(curve)[1] == 2:
        curve = tuple(np.asarray(curve).T)
    if not isinstance(curve, (tuple, list)) or len(curve) != 2:
        raise InvalidInput(
            f"fit: {mode} must be a pair of arrays (strain, load) or an (n x 2) array, got "
            f"{type(curve).__name__}"
        )
    columns = []
    for column, unit in zip(curve, (x_unit, y_unit), strict=True):
        turned = in_unit(column, unit, f"fit: {mode}")
        if mode == "shear" and is_angle(column):
            turned = np.tan(turned)
        try:
            columns.append(np.asarray(turned, float))
        except (TypeError, ValueError):
            raise InvalidInput(f"fit: {mode} must hold numbers, got {column!r}"[:300]) from None
    x, y = columns
    if x.ndim != 1 or x.shape != y.shape:
        raise InvalidInput(
            f"fit: {mode}: strain and load must have the same length, got shapes {x.shape} and"
            f" {y.shape}"
        )
    if len(x) == 0:
        raise InvalidInput(f"fit: {mode} must have points, got none")
    for what, values in (("strain", x), ("load", y)):
        if (bad := np.flatnonzero(~np.isfinite(values))).size:
            raise InvalidInput(
                f"fit: {mode}: {what} {bad[0]} must be finite, got {values[bad[0]]}; remove"
                " the point"
            )
    if (bad := np.flatnonzero(np.diff(x) <= 0)).size:
        i = int(bad[0])
        raise InvalidInput(
            f"fit: {mode}: strain must increase from point to point, got {x[i]:g} then"
            f" {x[i + 1]:g} at point {i + 1}; give only the loading branch"
        )
    return x, y


def _crossing(mode: str, strain: Floats, load: Floats, wanted: float) -> float:
    """Returns the strain at which the curve first reaches the load `wanted` [N/m].

    Interpolates linearly between points. Raises InvalidInput if the curve does not reach this load,
    if its first point is at or above it, or if the strain found is not positive.
    """
    above = np.flatnonzero(load >= wanted)
    if above.size == 0:
        raise InvalidInput(
            f"fit: {mode}: the curve never reaches the load of {wanted:.4g} [N/m], but"
            f" only {load.max(initial=0.0):.4g}; extend the measurement, or give a lower load"
        )
    i = int(above[0])
    if i == 0:
        raise InvalidInput(
            f"fit: {mode}: the curve starts above the load of {wanted:.4g} [N/m]; begin"
            " it at zero load"
        )
    share = (wanted - load[i - 1]) / (load[i] - load[i - 1])
    limit = float(strain[i - 1] + share * (strain[i] - strain[i - 1]))
    if limit <= 0:
        raise InvalidInput(
            f"fit: {mode}: the load of {wanted:.4g} [N/m] is reached at a strain of"
            f" {limit:.3g}; strain must start at 0"
        )
    return limit


def _through_origin(
    mode: str, shape: Callable[[Floats], Floats], x: Floats, y: Floats, limit: float
) -> ModeFit:
    """Fits the stiffness k of y = k shape(x) by least squares, to all points given.

    The misfit is the root mean square residual, relative to the largest |y|.
    """
    if np.count_nonzero(x) < 4:
        raise InvalidInput(
            f"fit: {mode}: at least 4 points other than 0 must lie below the limit, got"
            f" {np.count_nonzero(x)}"
        )
    basis = shape(x)
    stiffness = float(basis @ y / (basis @ basis))
    if not stiffness > 0:
        raise InvalidInput(
            f"fit: {mode}: the load must increase with strain, got a fitted stiffness of"
            f" {stiffness:.3g}"
        )
    misfit = float(np.sqrt(np.mean((y - stiffness * basis) ** 2)) / np.abs(y).max())
    return ModeFit(stiffness, limit, misfit, len(x))
