"""Creates and saves figures of matplotlib, which is an optional package."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from .._core import CacheError, Unsupported
from .replacement import replacement, written


def new_figure(size: tuple[float, float]) -> Any:
    """Returns an empty figure of matplotlib. Raises Unsupported if matplotlib is missing.

    size : width and height [inches]
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise Unsupported(
            "plots need matplotlib, which is not installed; pip install matplotlib"
        ) from None
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Any, path: str | os.PathLike[str], *, dpi: float) -> Path:
    """Writes a figure to `path`, with .png added if it has no suffix, and returns the path written.

    An existing file is replaced when the new one is complete. Raises CacheError if the figure
    cannot be written.
    """
    target = Path(path)
    target = target if target.suffix else Path(f"{target}.png")
    try:
        if target.exists() and not target.is_file():  # a device cannot be replaced
            with written(target, "the plot"):
                figure.savefig(target, dpi=dpi)
        else:
            with replacement(target, "the plot") as unfinished:
                figure.savefig(unfinished, dpi=dpi)
    except ValueError as error:
        raise CacheError(f"{target}: the plot cannot be written: {error}") from error
    return target


def plain(text: str) -> str:
    """Returns a text that Matplotlib shows as it is: dollar signs do not begin a formula."""
    return text.replace("$", r"\$")
