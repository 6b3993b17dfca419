"""A mesh over time, read from a file of another program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .._core import InvalidInput, TriangleMesh
from .surfaces import Floats, Indices, uv_table

__all__ = ["MALFORMED", "NO_UV", "Part", "sample_times"]

# Exceptions raised for malformed files, by libraries or by the conversion of the files' content.
# TypeError and AttributeError are not among them, because they indicate errors in this package.
MALFORMED = (
    KeyError,
    IndexError,
    ValueError,
    OverflowError,
    MemoryError,
    RecursionError,
)

NO_UV = (  # how to read a file without its texture coordinates, for messages
    "with_uv=False of meshes.read or a look without texture leaves out the texture coordinates"
)

_MOST = 100_000  # largest number of intervals between the samples of a motion


@dataclass(frozen=True)
class Part:
    """A mesh over time in world space, with z up."""

    name: str
    path: str  # names of the prims or nodes from the root to the mesh: "/body/arm"
    triangles: Indices  # (m x 3)
    frames: Floats  # (f x n x 3) vertices in each frame [m]
    corner_uv: Floats  # (m x 3 x 2) texture coordinates of the corners of triangles; NaN: none

    def first_mesh(self) -> TriangleMesh:
        """Returns the mesh in the first frame, with uv if all corners have them."""
        mesh = TriangleMesh(self.frames[0], self.triangles)
        if np.isnan(self.corner_uv).any():
            return mesh
        uv, uv_triangles = uv_table(self.triangles, self.corner_uv.reshape(-1, 2))
        try:
            return TriangleMesh(mesh.vertices, mesh.triangles, uv, uv_triangles=uv_triangles)
        except InvalidInput as error:
            raise InvalidInput(f"{error} ({NO_UV})") from None


def sample_times(path: Path, length: float, rate: float) -> Floats:
    """Returns times from 0 to `length` [s] with `rate` samples per second, and then `length`.

    If the last of these times differs from `length` by at most 1e-3 of an interval, `length` is
    left out. Raises InvalidInput if `length` times `rate` exceeds 100,000.
    """
    if not length * rate <= _MOST:
        raise InvalidInput(
            f"{path}: must have at most {_MOST} samples, but {length:g} s at {rate:g} per second"
            " have more; give a lower rate"
        )
    # Times in glTF files have single precision, so `length` can be slightly too short. A sample at
    # most 1e-3 of an interval after `length` is therefore included.
    times = np.arange(1 + int(np.floor(length * rate + 1e-3))) / rate
    ends = length == 0.0 or (len(times) > 1 and times[-1] > length - 1e-3 / rate)
    return times if ends else np.append(times, length)
