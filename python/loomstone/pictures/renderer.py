"""The renderer of the core, with colour maps and legends."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import Curves, Frame, FrameTopology, RenderOptions
from .color_bar import draw_color_bar, field_title
from .color_maps import color_table

__all__ = ["Renderer"]


class Renderer(_core.Renderer):
    """Draws frames of one run without a display, by the system's OSMesa or EGL, or by the OSMesa
    that wheels contain.

    topology : topology of the frames
    options : RenderOptions

    Raises Unsupported if none of these libraries can be used, and InvalidInput for options that
    cannot be drawn.
    """

    def __init__(self, topology: FrameTopology, options: RenderOptions | None = None) -> None:
        options = options or RenderOptions()
        self._rows = options.color_by.split("+")
        self._table, diverging = color_table(options.color_map)
        super().__init__(topology, options, self._table, diverging)

    def render(
        self, frame: Frame, curves: Curves | None = None, value_ranges: Any = None
    ) -> NDArray[np.uint8]:
        """Renders a frame to (height x width x 3) bytes, beginning with the top row.

        The height is `options.height` times the number of fields in color_by. With the background
        "none", pictures are (height x width x 4), with alpha.

        curves : curves that are drawn as tubes
        value_ranges : (minimum, maximum) that automatic colours span, for each field in color_by;
            by default the extremes in this frame, and 0 to 2 for the field contact
        """
        image = super().render(frame, curves, value_ranges)
        if all(row == "cloth" for row in self._rows):
            return image
        ranges = self.color_ranges(frame, value_ranges)
        parts = np.split(image, len(self._rows))
        return np.concatenate(
            [
                part
                if row == "cloth"
                else draw_color_bar(part, self._table, limits, field_title(row))
                for part, row, limits in zip(parts, self._rows, ranges, strict=True)
            ]
        )
