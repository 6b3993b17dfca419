"""Pictures of the frames of a run, drawn in parallel."""

from __future__ import annotations

import json
import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from .. import _core
from .._core import CacheError, Frame, FrameTopology, InvalidInput, RenderOptions, Scene
from ..base.arguments import takes
from .directory import (
    claim,
    make_directory,
    note_of,
    options_from_dict,
    picture,
    pictures_in,
    write_note,
)
from .painter import Painter, Ranges, colors_need_all_frames

__all__ = ["FramesOfRun", "render_run"]


class FramesOfRun(Protocol):
    """The interface of a run that drawing needs; loomstone.Run implements it."""

    directory: Path

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Frame: ...
    def __iter__(self) -> Iterator[Frame]: ...
    @property
    def topology(self) -> FrameTopology: ...
    @property
    def metadata_text(self) -> str: ...
    def magnetic_scene(self) -> Scene | None: ...


_ADVICE = "give another directory by --out, or draw all anew by --again"


@takes()
def render_run(
    run: FramesOfRun,
    options: RenderOptions,
    *,
    out: str | os.PathLike[str] | None = None,
    frames: Sequence[int] | None = None,
    jobs: int = 0,
    again: bool = False,
    progress: Callable[[int], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
    simulation: Any = None,
) -> list[Path]:
    """Draws all frames of a run in parallel, and keeps existing pictures.

    out : directory of the pictures, by default `frames` in the run's directory. Raises InvalidInput
        if it has pictures of another run or with other options, unless `again` is True.
    frames : indices of the frames to draw, even if they have pictures; None: all frames. With
        indices, `out` defaults to the run's directory and may not hold the pictures of a whole run.
    jobs : number of processes, 0: one per processor
    again : delete existing pictures first, as always if new frames change automatic colours
    progress : function called with the number of pictures finished since its last call
    stop : function called before every picture if jobs=1; drawing ends if it returns True
    simulation : simulation of the run, for field lines; default: made from the stored magnets
    A fitted camera is fitted to the first frame. Automatic colours span the values of all frames.
    """
    if not len(run):
        raise CacheError(f"{run.directory} must have frames, but has none yet; render it later")
    if any(not 0 <= i < len(run) for i in frames or ()):
        raise InvalidInput(
            f"frames must be in [0, {len(run) - 1}], got {list(frames or ())}; the run has"
            f" {len(run)} frames"
        )
    # The renderer checks the options before any picture is deleted.
    renderer = _core.Renderer(run.topology, options)
    ranges = _value_ranges(run, renderer) if colors_need_all_frames(options) else None
    directory = Path(out) if out else run.directory / ("frames" if frames is None else "")
    if frames is None:
        _claim_all(run, options, directory, ranges, again)
    elif note_of(directory):
        raise InvalidInput(
            f"{directory} holds the pictures of a whole run; give another directory by --out for"
            " single frames"
        )
    else:
        make_directory(directory)
    every = [(i, picture(directory, i)) for i in (range(len(run)) if frames is None else frames)]
    missing = [(i, path) for i, path in every if frames is not None or not path.exists()]
    told = progress or (lambda _: None)
    told(len(every) - len(missing))
    jobs = max(1, min(jobs or _core.default_thread_count(), len(missing)))
    if jobs == 1:
        painter = _painter(run, renderer, options, ranges, simulation)
        for i, path in missing:
            if stop():
                break
            painter.draw(path, run[i])
            told(1)
    else:
        _draw_in_parallel(run, json.dumps([options.to_dict(), ranges]), missing, jobs, told)
    return [path for _, path in every]


def _claim_all(
    run: FramesOfRun,
    options: RenderOptions,
    directory: Path,
    ranges: Ranges | None,
    again: bool,
) -> None:
    """Reserves a directory for the pictures of a whole run.

    Pictures whose automatic colours spanned another range are deleted.
    """
    note = claim(directory, options, run.metadata_text, again=again, advice=_ADVICE)
    if note.get("value_ranges") != (known := json.loads(json.dumps(ranges))):
        for path in pictures_in(directory):
            path.unlink()
        write_note(directory, note | {"value_ranges": known})


def _value_ranges(run: FramesOfRun, renderer: _core.Renderer) -> Ranges:
    values = np.array([renderer.value_ranges(frame) for frame in run])
    return [
        (float(low), float(high))
        for low, high in zip(values[:, :, 0].min(0), values[:, :, 1].max(0), strict=True)
    ]


def _painter(
    run: FramesOfRun,
    renderer: _core.Renderer,
    options: RenderOptions,
    ranges: Ranges | None,
    simulation: Any = None,
) -> Painter:
    if options.field_lines and simulation is None:
        scene = run.magnetic_scene()
        simulation = _core.Simulation(scene, threads=1) if scene else None
    return Painter(
        renderer,
        first=run[0],
        lines=options.field_lines if simulation else 0,
        simulation=simulation,
        value_ranges=ranges,
    )


def _draw_in_parallel(
    run: FramesOfRun,
    settings: str,
    missing: list[tuple[int, Path]],
    jobs: int,
    told: Callable[[int], None],
) -> None:
    prepared = {"initializer": _prepare, "initargs": (run, settings)}
    with multiprocessing.get_context("spawn").Pool(jobs, **prepared) as pool:  # type: ignore[arg-type]
        for _ in pool.imap_unordered(_draw, missing):
            told(1)


_prepared: list[tuple[FramesOfRun, Painter]] = []  # the run and the painter of this worker process


def _prepare(run: FramesOfRun, settings: str) -> None:
    values, ranges = json.loads(settings)
    options = options_from_dict(values)
    _prepared[:] = [(run, _painter(run, _core.Renderer(run.topology, options), options, ranges))]


def _draw(part: tuple[int, Path]) -> None:
    (run, painter), (index, path) = _prepared[0], part
    painter.draw(path, run[index])
