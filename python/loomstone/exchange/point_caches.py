"""Point caches: positions of vertices over time in the formats Point Cache 2 (.pc2) and MDD.

A .pc2 file has a header of 32 bytes: "POINTCACHE2", version, number of points, first frame, frames
per sample and number of samples, followed by positions, all little-endian. An .mdd file has the
numbers of frames and points, times [s] and positions, all big-endian. Positions are in single
precision.
"""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError
from .surfaces import Floats

__all__ = ["mdd_header", "pc2_header", "read_mdd", "read_pc2", "write_positions"]

_TYPES = {".pc2": "<f4", ".mdd": ">f4"}


def pc2_header(points: int, first: float, step: float, samples: int) -> bytes:
    """Returns the header of a .pc2 file.

    first : index of the first frame
    step : frames per sample
    """
    return (
        b"POINTCACHE2\0"
        + np.array([1, points], "<i4").tobytes()
        + np.array([first, step], "<f4").tobytes()
        + np.array([samples], "<i4").tobytes()
    )


def mdd_header(points: int, times: Floats) -> bytes:
    """Returns the header of an .mdd file with the given times (f) [s]."""
    return np.array([len(times), points], ">i4").tobytes() + times.astype(">f4").tobytes()


def write_positions(file: IO[bytes], suffix: str, positions: Floats) -> None:
    """Appends the positions (n x 3) [m] of one frame, in the format with the given suffix."""
    file.write(np.ascontiguousarray(positions, _TYPES[suffix]).tobytes())


def read_pc2(path: Path) -> tuple[NDArray[Any], float]:
    """Returns positions (f x n x 3), memory-mapped, and the number of frames per sample.

    Raises CacheError if the file is not a point cache or is cut short.
    """
    head = _head(path)
    if head[:12] != b"POINTCACHE2\0" or len(head) < 32:
        raise CacheError(f"{path}: is not a point cache (.pc2)")
    points, samples = (int(n) for n in np.frombuffer(head, "<i4")[[4, 7]])
    frames = _mapped(path, "<f4", 32, samples, points)
    return frames, float(np.frombuffer(head, "<f4")[6])


def read_mdd(path: Path) -> tuple[NDArray[Any], Floats]:
    """Returns positions (f x n x 3), memory-mapped, and times (f) [s].

    Raises CacheError if the file is not a point cache or is cut short.
    """
    head = _head(path)
    samples, points = (int(n) for n in np.frombuffer(head[:8], ">i4")) if len(head) >= 8 else (0, 0)
    if samples < 1 or points < 1:
        raise CacheError(f"{path}: is not a point cache (.mdd)")
    frames = _mapped(path, ">f4", 8 + 4 * samples, samples, points)
    return frames, np.fromfile(path, ">f4", samples, offset=8).astype(float)


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(32)


def _mapped(path: Path, kind: str, offset: int, samples: int, points: int) -> NDArray[Any]:
    wanted, size = offset + 12 * samples * points, path.stat().st_size
    if samples < 1 or points < 1 or size < wanted:
        raise CacheError(
            f"{path}: must have {wanted} bytes for {samples} frames of {points} points, got {size};"
            " it is cut short"
        )
    return np.memmap(path, kind, "r", offset, (samples, points, 3))
