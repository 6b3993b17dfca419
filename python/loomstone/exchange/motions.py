"""How the surfaces of a run move: not at all, as rigid bodies, or by deforming."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from .._core import Frame
from .surfaces import Floats, Surface

__all__ = ["Motion", "motions_of"]

# Largest deviation of a coordinate from a rigid motion at which a surface other than cloth counts
# as rigid, as a fraction of the longest edge of its bounding box in the first frame. The value
# allows for rounding to single precision.
_RIGID = 1e-6


@dataclass
class Motion:
    """Motion of a surface over the frames that are exported."""

    first: Floats  # (n x 3) vertices in the first frame [m]
    still: bool
    rigid: bool  # also True if still
    centre: Floats  # (3) mean of the vertices in the first frame [m]
    rotations: Floats  # (f x 3 x 3) rotations from the first frame; not used unless rigid
    centres: Floats  # (f x 3) place of `centre` in each frame [m]; not used unless rigid

    @property
    def local(self) -> Floats:
        """(n x 3) vertices of the first frame relative to `centre` [m]."""
        return self.first - self.centre

    @property
    def quaternions(self) -> Floats:
        """(f x 4) `rotations` as quaternions x, y, z, w.

        Their signs are chosen so that interpolation between frames follows the shorter arc.
        """
        from scipy.spatial.transform import Rotation

        q: Floats = Rotation.from_matrix(self.rotations).as_quat()
        signs = np.sign(np.einsum("ij,ij->i", q[1:], q[:-1]))
        return q * np.cumprod(np.r_[1.0, np.where(signs < 0.0, -1.0, 1.0)])[:, None]


def motions_of(
    surfaces: list[Surface],
    frames: Callable[[], Iterable[Frame]],
    count: int,
    progress: Callable[[int], None],
) -> list[Motion]:
    """Returns the motions of surfaces over `count` frames. Each frame is read once.

    A surface is rigid if a rotation and a translation map its vertices in the first frame to those
    in each frame, up to _RIGID. Cloth never counts as rigid or still.

    frames : returns an iterator over the frames
    progress : called with 1 after each frame
    """
    motions: list[Motion] = []
    for index, frame in enumerate(frames()):
        for number, surface in enumerate(surfaces):
            positions = surface.positions(frame)
            if index == 0:
                motions.append(_begun(surface, positions, count))
            else:
                _extend(motions[number], index, positions)
        progress(1)
    return motions


def _begun(surface: Surface, positions: Floats, count: int) -> Motion:
    centre = positions.mean(0)
    return Motion(
        first=positions.copy(),
        still=not surface.is_cloth,
        rigid=not surface.is_cloth,
        centre=centre,
        rotations=np.tile(np.eye(3), (count, 1, 1)),
        centres=np.tile(centre, (count, 1)),
    )


def _extend(motion: Motion, index: int, positions: Floats) -> None:
    if not motion.rigid or (motion.still and np.array_equal(positions, motion.first)):
        return
    motion.still = False
    local, centre = motion.local, positions.mean(0)
    rotation = _best_rotation(local, positions - centre)
    deviation = np.abs(local @ rotation.T + centre - positions).max()
    motion.rigid = bool(deviation <= _RIGID * np.ptp(motion.first, axis=0).max())
    motion.rotations[index], motion.centres[index] = rotation, centre


def _best_rotation(before: Floats, after: Floats) -> Floats:
    """Returns the rotation that maps `before` to `after` with the least sum of squared deviations.

    Kabsch, "A solution for the best rotation to relate two sets of vectors", 1976.
    """
    u, _, vt = np.linalg.svd(after.T @ before)
    turn: Floats = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return turn
