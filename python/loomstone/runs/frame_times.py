"""Times of the frames of a run: one at the start and one every 1/rate."""

from __future__ import annotations

import numpy as np

from .._core import InvalidInput

__all__ = ["frame_count", "frames_due"]

MOST_FRAMES = 1_000_000


def frame_count(duration: float, rate: float) -> int:
    """Returns the number of frames of a run: one at the start and one every 1/rate."""
    if not (np.isfinite(duration) and duration >= 0):
        raise InvalidInput(f"duration must be >= 0 [s], got {duration}; correct this value")
    if not (np.isfinite(rate) and rate > 0):
        raise InvalidInput(f"rate must be > 0 [1/s], got {rate}; correct this value")
    if duration * rate > MOST_FRAMES:
        raise InvalidInput(
            f"a run may have at most {MOST_FRAMES} frames, got duration {duration:g} s at {rate:g}"
            " frames/s; lower one of them"
        )
    return int(np.floor(duration * rate + 1e-6)) + 1


def frames_due(time: float, rate: float) -> int:
    """Returns the number of frames up to a time. A tolerance absorbs rounding of summed steps."""
    return int(np.floor(time * rate + 1e-6)) + 1
