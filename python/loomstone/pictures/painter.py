"""Draws single frames of a run, in any order."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Curves, Frame, RenderOptions
from ..magnetics.lines import frame_curves
from .renderer import Renderer

__all__ = ["Painter", "Ranges", "colors_need_all_frames", "is_fitted", "needs_all_frames"]

Ranges = list[tuple[float, float]]


def needs_all_frames(options: RenderOptions) -> bool:
    """Returns whether drawing a frame requires that all frames of the run are known."""
    return is_fitted(options) or colors_need_all_frames(options)


def is_fitted(options: RenderOptions) -> bool:
    """Returns whether the camera must be fitted to the frames."""
    return options.camera.fit and not options.camera.times


def colors_need_all_frames(options: RenderOptions) -> bool:
    """Returns whether the range of the colours follows from the values of all frames.

    This is so if color_low or color_high is not given, and a field other than contact is drawn.
    """
    return None in (options.color_low, options.color_high) and not {"cloth", "contact"}.issuperset(
        options.color_by.split("+")
    )


class Painter:
    """Draws frames of one run. With `first`, no picture depends on the frames drawn before it.

    first : frame that determines the region that a fitted camera shows, the scale of shading and
        the sharp edges of bodies; None: the first frame drawn
    lines : number of field lines, 0: none
    simulation : simulation that provides the magnets; needed for field lines
    value_ranges : for each field of color_by, the (minimum, maximum) from which automatic colours
        follow; None: the extremes in each frame, or 0 to 2 for the field contact
    """

    def __init__(
        self,
        renderer: Renderer,
        *,
        first: Frame | None,
        lines: int,
        simulation: Any = None,
        value_ranges: Ranges | None = None,
    ) -> None:
        self._renderer, self._lines, self._simulation, self._ranges = (
            renderer,
            lines,
            simulation,
            value_ranges,
        )
        if first is not None:
            renderer.fit(first)

    def draw(self, path: Path, frame: Frame) -> None:
        """Draws a frame and writes the picture (PNG)."""
        _core.write_png(str(path), self._renderer.render(frame, self._curves(frame), self._ranges))

    def surfaces(
        self, frame: Frame
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
        """Returns depth, normal and surface number of each pixel, as Renderer.surfaces does."""
        return self._renderer.surfaces(frame, self._curves(frame))

    def _curves(self, frame: Frame) -> Curves | None:
        return frame_curves(self._simulation, frame, self._lines) if self._lines else None
