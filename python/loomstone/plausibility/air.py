"""Air that looks like a mistake: wind that does not act on cloth."""

from __future__ import annotations

import numpy as np

from .._core import Scene

__all__ = ["of_air"]


def of_air(scene: Scene) -> list[str]:
    """Returns a list with a sentence if wind has no effect, because drag or air density is 0."""
    air = scene.air
    if not scene.cloths or not np.any(air.wind):
        return []
    if air.density > 0.0 and (air.normal_drag > 0.0 or air.tangential_drag > 0.0):
        return []
    return [
        "scene.air: its wind has no effect, because normal_drag and tangential_drag are 0; give a"
        " normal_drag of about 1"
    ]
