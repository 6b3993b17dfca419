"""Selection of the frames of a run."""

from __future__ import annotations

import re

from .._core import CacheError, InvalidInput
from ..base.arguments import whole

__all__ = ["parse_frames", "selected"]


def parse_frames(text: str, count: int) -> range:
    """Returns the frames given by "A:B": A to B - 1, where A defaults to 0 and B to `count`.

    count : number of frames of the run

    Raises InvalidInput for any other text, and unless 0 <= A < B <= count.
    """
    found = re.fullmatch(r"(\d*):(\d*)", text.strip())
    first, end = (int(found[1] or 0), int(found[2] or count)) if found else (0, 0)
    if not 0 <= first < end <= count:
        raise InvalidInput(
            f"--frames must be A:B with 0 <= A < B <= {count}, which selects frames A to B - 1, got"
            f" {text!r}"
        )
    return range(first, end)


def selected(count: int, frames: range | None, every: int) -> range:
    """Returns every `every`-th of the given frames (None: all) of a run that has `count` frames.

    Raises CacheError if the run has no frames, and InvalidInput if `frames` is not an ascending
    range of indices of the run's frames or `every` is not in [1, 1,000,000].
    """
    if count == 0:
        raise CacheError("the run must have frames, but has none yet; export it later")
    if frames is None:
        frames = range(count)
    if not isinstance(frames, range):
        raise InvalidInput(f"frames must be a range, such as range(10, 50), got {frames!r}")
    if len(frames) == 0 or frames.step < 1 or frames[0] < 0 or frames[-1] >= count:
        raise InvalidInput(
            f"frames must be an ascending range within the frames 0 to {count - 1} of the run, got"
            f" {frames}"
        )
    return frames[:: whole("every", every, 1, 1_000_000)]
