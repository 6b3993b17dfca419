"""Collision queries on arrays, without a scene: candidate pairs, exact continuous collision
detection and exact intersection tests.

>>> import numpy as np
>>> from loomstone import collision
>>> face = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
>>> query = [[[0.25, 0.25, 1.0], *face, [0.25, 0.25, -1.0], *face]]
>>> hit, time = collision.continuous("vertex-face", query)
>>> bool(hit[0]), bool(0.49 < time[0] <= 0.5)
(True, True)
"""

from ._core import Collisions, Detector, candidates, continuous, intersecting_pairs

__all__ = ["Collisions", "Detector", "candidates", "continuous", "intersecting_pairs"]


def __dir__() -> list[str]:
    return __all__
