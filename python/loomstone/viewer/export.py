"""A run as a single HTML file that plays in a browser without a server."""

from __future__ import annotations

import os
from pathlib import Path

from .._core import CacheError, Camera, InvalidInput
from ..base.arguments import takes
from ..base.replacement import replacement
from ..runs.cache import Run
from .page import Page
from .surfaces import FIELDS

__all__ = ["write_html"]


@takes()
def write_html(
    run: Run | str | os.PathLike[str],
    path: str | os.PathLike[str],
    *,
    camera: Camera | None = None,
    color_by: str = "cloth",
    limits: tuple[float, float] = (1.0, 1.1),
    every: int = 1,
) -> Path:
    """Writes a page that plays a run, as one HTML file that needs no server, and returns its path.

    camera : Camera at the start; None: one that shows all of the first frame except floors
    color_by : cloth | stretch | strain_weft | strain_warp | strain_shear | contact
    limits : values at the two ends of the colour scale [1]
    every : only every n-th frame is stored

    Raises InvalidInput for an unknown `color_by` or if `every` < 1, CacheError if the run has no
    frames or the page cannot be written, and Unsupported if viser is not installed.
    """
    source = run if isinstance(run, Run) else Run(run)
    if color_by not in FIELDS:
        raise InvalidInput(f"color_by must be {' | '.join(FIELDS)}, got {color_by!r}")
    if every < 1:
        raise InvalidInput(f"every must be >= 1, got {every}")
    if not len(source):
        raise CacheError(f"{source.directory} has no frames yet; export it later")
    target = Path(path)
    page = Page(
        source.directory.name, source.topology, source[0], camera=camera or Camera(), port=0
    )
    try:
        recording = page.server.get_scene_serializer()
        for i in range(0, len(source), every):
            page.surfaces.show(source[i], color_by, limits)
            recording.insert_sleep(every / source.rate)
        text = recording.as_html()
    finally:
        page.stop()
    with replacement(target, "the page") as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    return target
