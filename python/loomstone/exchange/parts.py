"""A mesh over time, read from a file of another program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .._core import InvalidInput
from .surfaces import Floats, Indices

__all__ = ["MALFORMED", "Part", "sample_times"]

# Exceptions raised for malformed files, by libraries or by the conversion of the files' content.
# TypeError and AttributeError are not among them, because they are errors of this package.
MALFORMED = (
    KeyError,
    IndexError,
    ValueError,
    OverflowError,
    MemoryError,
    RecursionError,
)

_MOST = 100_000  # largest number of intervals between the samples of a motion


@dataclass(frozen=True)
class Part:
    """A mesh over time in world space, with z up."""

    name: str
    path: str  # names of the prims or nodes from the root to the mesh: "/body/arm"
    triangles: Indices  # (m x 3)
    frames: Floats  # (f x n x 3) vertices in each frame [m]


def sample_times(path: Path, length: float, rate: float) -> Floats:
    """Returns times from 0 up to `length` [s] with `rate` samples per second.

    If this gives only the time 0 and `length` is not 0, `length` is added. Raises InvalidInput if
    `length` times `rate` exceeds 100,000.
    """
    if not length * rate <= _MOST:
        raise InvalidInput(
            f"{path}: must have at most {_MOST} samples, but {length:g} s at {rate:g} per second"
            " have more; give a lower rate"
        )
    # Times in glTF files have single precision, so `length` can be slightly too short. A sample at
    # most 1e-3 of an interval after `length` is therefore included.
    times = np.arange(1 + int(np.floor(length * rate + 1e-3))) / rate
    return times if len(times) > 1 or length == 0.0 else np.array([0.0, length])
