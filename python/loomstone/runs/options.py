"""How a run is made."""

from __future__ import annotations

from dataclasses import dataclass

from .._core import RenderOptions
from ..base.arguments import takes

__all__ = ["RunOptions"]


@takes(duration="s", rate="1/s")
@dataclass(frozen=True)
class RunOptions:
    """duration [s], rate [1/s], how pictures look, exact count of intersections in every frame.

    Pictures are drawn while it runs, but at its end where their colours span the values of all
    frames.
    """

    duration: float
    rate: float = 25.0
    render: RenderOptions | None = None
    verify: bool = False
