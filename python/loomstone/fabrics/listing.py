"""The fabrics of loomstone.fabrics as a text table or as JSON."""

from __future__ import annotations

import json
from math import isfinite

from .fabric import Fabric
from .named_fabrics import catalogue
from .rigidity import strip_rigidity

__all__ = ["fabrics_json", "fabrics_text"]

HEADER = (
    f"{'':14s} {'':>6s} {'stiffness [N/m]':^23s} {'limits [%]':^20s} {'bending [uN m]':^20s}\n"
    f"{'fabric':14s} {'g/m^2':>6s} {'weft':>7s} {'warp':>7s} {'shear':>7s}"
    f" {'weft':>6s} {'warp':>6s} {'shear':>6s} {'weft':>6s} {'warp':>6s} {'bias':>6s}"
    f"  {'band %':>6s}  use"
)


def fabrics_text() -> str:
    """Returns a table with one line per fabric, followed by the sources of the numbers."""
    sources = list(dict.fromkeys(fabric.source for fabric in catalogue.values()))
    lines = [
        HEADER,
        *(f"{_line(fabric)} [{sources.index(fabric.source) + 1}]" for fabric in catalogue.values()),
        "",
    ]
    for number, source in enumerate(sources, 1):
        licence = next(fabric.licence for fabric in catalogue.values() if fabric.source == source)
        lines += [f"[{number}] {source}", f"    {licence}"]
    lines.append(
        "limits: largest strain (shear: e12), - if unknown; band: published drape"
        " coefficients of similar fabrics"
    )
    lines.append("caveats: loomstone fabrics --json")
    return "\n".join(lines)


def fabrics_json() -> str:
    """Returns a JSON object that maps the name of each fabric to its fields."""
    return json.dumps(
        {name: fabric.to_dict() for name, fabric in catalogue.items()}, indent=1, allow_nan=False
    )


def _line(fabric: Fabric) -> str:
    stiffness = " ".join(
        f"{x:7.4g}" for x in (fabric.weft_stiffness, fabric.warp_stiffness, fabric.shear_stiffness)
    )
    limits = " ".join(
        f"{100 * limit:6.3g}" if isfinite(limit) else f"{'-':>6s}" for limit in fabric.limits
    )
    bending = " ".join(
        f"{1e6 * strip_rigidity(fabric, angle_degrees=angle):6.3g}" for angle in (0, 90, 45)
    )
    band = f"{fabric.band.low:g}-{fabric.band.high:g}" if fabric.band else "-"
    numbers = f"{1e3 * fabric.density:6.4g} {stiffness} {limits} {bending}"
    return f"{fabric.name:14s} {numbers}  {band:>6s}  {fabric.use}"
