"""Options with which simulations are run."""

from __future__ import annotations

from dataclasses import dataclass

from .._core import RenderOptions
from ..base.arguments import takes

__all__ = ["RunOptions"]


@takes(duration="s", rate="1/s")
@dataclass(frozen=True)
class RunOptions:
    """Length of a run, and what is written, drawn and checked.

    duration : simulated time [s]
    rate : frames per second of simulated time [1/s]
    render : options of the pictures, which are drawn during the run, or at its end if their colours
        or a fitted camera depend on all frames; None: no pictures
    verify : whether the intersections of every frame are counted exactly
    record_tasks : n, to record the motion of surfaces in every n-th step for `loomstone replay`; 0,
        to record none
    compression : level of the deflate compression of frames, 0 (none) to 9; a resumed run keeps
        the level with which it began. docs/cache.md gives its cost.
    """

    duration: float
    rate: float = 25.0
    render: RenderOptions | None = None
    verify: bool = False
    record_tasks: int = 0
    compression: int = 0
