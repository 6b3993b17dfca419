"""Air that looks like a mistake: wind that does not act on cloth."""

from __future__ import annotations

import numpy as np

from .._core import Scene

__all__ = ["of_air"]


def of_air(scene: Scene) -> list[str]:
    """Returns a sentence for each reason why wind has no effect on cloth: no density, no drag."""
    air = scene.air
    if not scene.cloths or not np.any(air.wind):
        return []
    missing = []
    if not air.density > 0.0:
        missing.append(("density is", "a density of 1.2 kg/m^3"))
    if not (air.normal_drag > 0.0 or air.tangential_drag > 0.0):
        missing.append(("normal_drag and tangential_drag are", "a normal_drag of about 1"))
    return [
        f"scene.air: its wind has no effect, because {zero} 0; give {remedy}"
        for zero, remedy in missing
    ]
