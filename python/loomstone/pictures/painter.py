"""Draws single frames. No picture depends on the frames drawn before it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .. import _core
from .._core import Frame, RenderOptions
from ..magnetics.lines import frame_curves

__all__ = ["Painter", "Ranges", "colors_need_all_frames"]

Ranges = list[tuple[float, float]]


def colors_need_all_frames(options: RenderOptions) -> bool:
    """Returns whether the colours span the values of all frames.

    In this case, no frame can be drawn before the last one is known.
    """
    return options.color_low == options.color_high and not {"cloth", "contact"}.issuperset(
        options.color_by.split("+")
    )


class Painter:
    """Draws frames of one run. No picture depends on the frames drawn before it.

    first : frame to which a fitted camera is fitted; None: the first frame drawn
    lines : number of field lines, 0: none
    simulation : simulation of the scene, which provides the magnets; needed for field lines
    value_ranges : for each field of color_by, the (minimum, maximum) that automatic colours span;
        None: each frame has its own range
    """

    def __init__(
        self,
        renderer: _core.Renderer,
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
        curves = frame_curves(self._simulation, frame, self._lines) if self._lines else None
        _core.write_png(str(path), self._renderer.render(frame, curves, self._ranges))
