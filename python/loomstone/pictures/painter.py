"""Draws single frames, so that no picture depends on what was drawn before it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .. import _core
from .._core import Frame, RenderOptions
from ..magnetics.lines import frame_curves

__all__ = ["Painter", "Ranges", "colors_need_all_frames"]

Ranges = list[tuple[float, float]]


def colors_need_all_frames(options: RenderOptions) -> bool:
    """Whether colors span the values of all frames, so that nothing can be drawn before the last
    is known.
    """
    return options.color_low == options.color_high and not {"cloth", "contact"}.issuperset(
        options.color_by.split("+")
    )


class Painter:
    """Draws frames of one run, so that no picture depends on what was drawn before it.

    first : frame of the run, which a fitted camera shows; None: the first that is drawn
    value_ranges : what automatic colours span; simulation : the scene that has the magnets, where
        field lines are drawn
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
        """Writes a picture (PNG)."""
        curves = frame_curves(self._simulation, frame, self._lines) if self._lines else None
        _core.write_png(str(path), self._renderer.render(frame, curves, self._ranges))
