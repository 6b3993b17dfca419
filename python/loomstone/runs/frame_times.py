"""Times of the frames of a run: one frame at the start, and one after every 1/rate [s]."""

from __future__ import annotations

import warnings

import numpy as np

from .._core import InvalidInput
from ..base.cautions import SceneWarning

__all__ = [
    "frame_count",
    "frames_due",
    "time_of_frame",
    "told_of_part_frame",
    "warn_of_part_frame",
]

MOST_FRAMES = 1_000_000

# A duration counts as a whole number of frames if it differs from such a number by at most
# _ROUNDED_BY frames or by at most the fraction _ROUNDED_BY_FRACTION of itself, but never by more
# than _MOST_ROUNDED_BY frames. Rates and durations of videos, such as 29.97 frames/s for
# 30000/1001, are rounded by a millionth.
_ROUNDED_BY, _ROUNDED_BY_FRACTION, _MOST_ROUNDED_BY = 1e-3, 2e-6, 0.05


def _whole(frames: float) -> bool:
    tolerance = min(max(_ROUNDED_BY, _ROUNDED_BY_FRACTION * frames), _MOST_ROUNDED_BY)
    return bool(abs(frames - round(frames)) <= tolerance)


def frame_count(duration: float, rate: float) -> int:
    """Returns the number of frames of a run: one at the start, and one after every 1/rate [s].

    A duration that is a thousandth of a frame too short still counts as a whole number of frames.
    Raises InvalidInput for an invalid duration or rate, or if their product exceeds MOST_FRAMES.
    """
    for name, value in (("duration", duration), ("rate", rate)):
        if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
            raise InvalidInput(f"{name} must be a number, got {value!r}")
    if not (np.isfinite(duration) and duration >= 0):
        raise InvalidInput(f"duration must be finite and >= 0 [s], got {duration}")
    if not (np.isfinite(rate) and rate > 0):
        raise InvalidInput(f"rate must be finite and > 0 [1/s], got {rate}")
    if duration * rate > MOST_FRAMES:
        raise InvalidInput(
            f"a run may have at most {MOST_FRAMES} frames, got duration {duration:g} s at {rate:g}"
            " frames/s; lower one of them"
        )
    frames = duration * rate
    return (round(frames) if _whole(frames) else int(np.floor(frames))) + 1


def frames_due(time: float, rate: float) -> int:
    """Returns the number of frames up to a time [s]. A tolerance absorbs rounding errors."""
    return int(np.floor(time * rate + 1e-6)) + 1


def time_of_frame(index: int, rate: float, time: float) -> float:
    """Returns the time of a frame that is due at `time` (see frames_due()), at most `time` [s]."""
    return min(index / rate, time)


def told_of_part_frame(duration: float, rate: float) -> str:
    """Returns a message if a duration is not a whole number of frames, or else an empty string.

    A positive duration that is rounded to 0 intervals between frames also gets a message.
    """
    whole = frame_count(duration, rate) - 1
    if _whole(duration * rate) and (whole > 0 or duration == 0):
        return ""
    end = "no step is taken" if whole == 0 else f"the simulation ends at {whole / rate:.6g} s"
    return (
        f"duration {duration:g} s is {duration * rate:.4g} frames at {rate:g} frames/s, so {end};"
        f" {(whole + 1) / rate:.7g} s is a whole number of frames"
    )


def warn_of_part_frame(duration: float, rate: float, stacklevel: int = 1) -> None:
    """Issues the message of told_of_part_frame(), if there is one, as a SceneWarning.

    stacklevel : 1 if the line to blame is in the caller of this function, 2 if it is in the
        caller's caller, and so on
    """
    if told := told_of_part_frame(duration, rate):
        warnings.warn(told, SceneWarning, stacklevel=stacklevel + 1)
