"""Colour legends. They are drawn onto finished pictures, so lighting does not change them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .._core import legend_width

__all__ = ["bar_labels", "bar_place", "draw_color_bar", "field_title"]

Bytes = NDArray[np.uint8]

_INK = (38, 40, 44)

_NO_BREAK = "\N{NO-BREAK SPACE}"
_TITLES = {
    "strain_split": "strain weft / warp",
    "contact": f"contact{_NO_BREAK}1 / intersecting{_NO_BREAK}2",
}


def field_title(name: str) -> str:
    """Returns the title of the legend for a scalar field."""
    return _TITLES.get(name, name.replace("_", " "))


def bar_labels(low: float, high: float) -> list[tuple[float, str]]:
    """Returns labels at both ends of a range, and at round numbers in it that are not near an end.

    Each label is a pair of its place along the bar (0: lower end, 1: upper end) and its text.
    """
    span = high - low
    power = 10.0 ** math.floor(math.log10(span / 4.0))
    step = next((f * power for f in (1.0, 2.0, 5.0) if span / (f * power) <= 5.0), 10.0 * power)
    decimals = math.ceil(-math.log10(step) - 1e-9)
    end_decimals = max(decimals, math.ceil(2.0 - math.log10(span) - 1e-9))

    def text(value: float, places: int) -> str:
        if places <= 5 and span < 1e5:
            return f"{value + 0.0:.{max(0, places)}f}"
        digits = places + 1 + (math.floor(math.log10(abs(value))) if value else 0)
        return f"{value + 0.0:.{max(1, digits)}g}"

    def end_text(value: float) -> str:
        is_round = abs(value / step - round(value / step)) < 1e-6
        return text(value, decimals if is_round else end_decimals)

    labels = [(0.0, end_text(low))]
    for k in range(math.ceil(low / step), math.ceil(high / step)):
        share = (k * step - low) / span
        if 0.09 < share < 0.91:
            labels.append((share, text(k * step, decimals)))
    return [*labels, (1.0, end_text(high))]


def _font_size(height: int) -> float:
    return max(11.0, 0.026 * height)


def bar_place(width: int, height: int) -> tuple[int, int, int, int]:
    """Returns the left and top edges, and the width and height, of the coloured strip [pixels]."""
    size = _font_size(height)
    long, wide = max(2, int(0.42 * height)), max(2, int(0.9 * size))
    return max(0, int(width - legend_width(height))), (height - long) // 2, wide, long


def draw_color_bar(image: Bytes, table: Bytes, limits: tuple[float, float], title: str) -> Bytes:
    """Returns a copy of a picture (height x width x 3 or 4) with a legend at its right edge.

    image : the picture
    table : (256 x 3) colours from the low to the high end of the range
    limits : values at the low and the high end
    """
    from PIL import Image, ImageDraw, ImageFont

    height, width = image.shape[:2]
    size = _font_size(height)
    font = ImageFont.load_default(size)
    left, top, wide, long = bar_place(width, height)
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    draw.rectangle((left - 1, top - 1, left + wide, top + long), fill=_INK)
    for row in range(long):
        color = table[round(255.0 * (1.0 - row / (long - 1)))]
        draw.line((left, top + row, left + wide - 1, top + row), fill=tuple(map(int, color)))
    tick = max(2, int(0.25 * size))
    for share, label in bar_labels(*limits):
        y = round(top + (1.0 - share) * (long - 1))
        draw.line((left + wide, y, left + wide + tick, y), fill=_INK)
        draw.text((left + wide + tick + 0.35 * size, y), label, _INK, font, anchor="lm")
    lines, size = _title_lines(title, width - left - 2, size)
    font = ImageFont.load_default(size)
    for above, line in enumerate(reversed(lines)):
        text = line.replace(_NO_BREAK, " ")
        draw.text((left - 1, top - (0.8 + 1.2 * above) * size), text, _INK, font, anchor="ls")
    return np.array(picture)


def _title_lines(title: str, room: float, size: float) -> tuple[list[str], float]:
    """Returns the lines of a title and its font size [pixels].

    The title is divided at spaces so that lines are not longer than `room`. If a word is longer,
    the font becomes smaller, but not smaller than 8 pixels.

    room : largest length of a line [pixels]
    size : preferred font size [pixels]
    """
    from PIL import ImageFont

    def long(text: str) -> float:
        return ImageFont.load_default(size).getlength(text)

    lines: list[str] = []
    for word in title.split(" "):
        if lines and long(f"{lines[-1]} {word}") <= room:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines, max(8.0, size * min(1.0, room / max(map(long, lines))))
