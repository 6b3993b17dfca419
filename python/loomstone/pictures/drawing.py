"""Pictures of the frames of a run, drawn in parallel."""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._core import CacheError, InvalidInput, RenderOptions
from ..base.arguments import takes
from ..base.safe_path import safe_path
from .cameras import fitted_camera
from .directory import (
    claim,
    is_whole,
    make_directory,
    note_of,
    options_from_dict,
    picture,
    pictures_in,
    write_note,
)
from .frames import FramesOfRun, check_frames
from .painter import Painter, Ranges, colors_need_all_frames, is_fitted
from .renderer import Renderer

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

__all__ = ["framed", "painter_of", "render_run"]


_ADVICE = "give another directory by --out, or draw all pictures again by --again"


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
    """Draws the frames of a run in parallel, and returns the paths of their pictures.

    out : directory of the pictures, by default `frames` in the run's directory. Raises InvalidInput
        if it has pictures of another run or with other options, unless `again` is True.
    frames : indices of frames to draw or redraw; None: all frames without complete pictures. With
        indices, `out` defaults to the run's directory, and must not have pictures of a whole run.
    jobs : number of processes, 0: one per processor
    again : delete existing pictures of a whole run first. Without it, they are deleted only if new
        frames change the automatic colours or the fit of the camera.
    progress : function called with each increment of the number of finished pictures
    stop : called before every picture if one process draws; drawing ends if it returns True
    simulation : source of magnets for field lines; None or several jobs: the run's stored magnets

    A fitted camera shows all drawn frames. For single frames, it is the camera of the pictures in
    the run's directory `frames` if these have equal options. Automatic colours use all frames.
    """
    check_frames(run, frames)
    shown = framed(run, options, frames)
    # The renderer checks the options before any picture is deleted.
    renderer = Renderer(run.topology, shown)
    ranges = _value_ranges(run, renderer) if colors_need_all_frames(options) else None
    directory = Path(out) if out else run.directory / ("frames" if frames is None else "")
    if frames is None:
        camera = shown.to_dict()["camera"] if is_fitted(options) else None
        found = json.loads(json.dumps({"value_ranges": ranges, "camera": camera}))
        _claim_all(run, options, directory, found, again)
    elif note_of(directory):
        raise InvalidInput(
            f"{directory} holds the pictures of a whole run; give another directory by --out for"
            " single frames"
        )
    else:
        make_directory(directory)
    every = [(i, picture(directory, i)) for i in (range(len(run)) if frames is None else frames)]
    missing = [(i, path) for i, path in every if frames is not None or not is_whole(path)]
    told = progress or (lambda _: None)
    told(len(every) - len(missing))
    jobs = max(1, min(jobs or _core.available_processors(), len(missing)))
    if jobs == 1:
        painter = painter_of(run, renderer, shown, ranges, simulation)
        for i, path in missing:
            if stop():
                break
            painter.draw(path, run[i])
            told(1)
    else:
        _draw_in_parallel(run, json.dumps([shown.to_dict(), ranges]), missing, jobs, told)
    return [path for _, path in every]


def framed(run: FramesOfRun, options: RenderOptions, frames: Sequence[int] | None) -> RenderOptions:
    """Returns the options. A camera to be fitted is replaced by one that shows all drawn frames.

    For single frames, the new camera is that of the pictures in the run's directory `frames` if
    these pictures have equal options.
    """
    if not is_fitted(options):
        return options
    note = note_of(run.directory / "frames") if frames is not None else {}
    if note.get("options") == json.loads(json.dumps(options.to_dict())) and note.get("camera"):
        return options_from_dict(note["options"] | {"camera": note["camera"]})
    return options.replace(camera=fitted_camera(run, options, frames=frames))


def _claim_all(
    run: FramesOfRun, options: RenderOptions, directory: Path, found: dict[str, Any], again: bool
) -> None:
    """Reserves a directory for the pictures of a whole run.

    Existing pictures are deleted if `again` is True, or if the range of automatic colours or the
    fitted camera differs from that in options.json.
    """
    note = claim(directory, options, run.metadata_text, again=again, advice=_ADVICE)
    if any(note.get(name) != value for name, value in found.items()):
        for path in pictures_in(directory):
            path.unlink()
        write_note(directory, note | found)


def _value_ranges(run: FramesOfRun, renderer: Renderer) -> Ranges:
    values = np.array([renderer.value_ranges(frame) for frame in run])
    return [
        (float(low), float(high))
        for low, high in zip(values[:, :, 0].min(0), values[:, :, 1].max(0), strict=True)
    ]


def painter_of(
    run: FramesOfRun,
    renderer: Renderer,
    options: RenderOptions,
    ranges: Ranges | None,
    simulation: Any = None,
) -> Painter:
    """Returns the painter of a run's frames; `ranges` are the `value_ranges` of Painter.

    simulation : source of the magnets for field lines; None: made from the run's stored magnets
    """
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
    # Late imports, because few commands need them.
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import active_children, get_context

    own: set[BaseProcess] = set()
    with safe_path():  # Python starts a process of its own here
        pool = ProcessPoolExecutor(
            jobs, get_context("spawn"), initializer=_prepare, initargs=(run, settings)
        )
    try:
        with safe_path():  # all drawing processes start here
            others = set(active_children())
            try:
                drawn = [pool.submit(_draw, part) for part in missing]
            finally:
                own = set(active_children()) - others
        for one in as_completed(drawn):
            one.result()
            told(1)
    except BaseException as error:
        for process in own:
            process.terminate()
        if isinstance(error, BrokenProcessPool):
            raise CacheError(
                f"{missing[0][1].parent}: a process that draws pictures was ended, perhaps for"
                " lack of memory; draw again, with fewer jobs if it happens again"
            ) from None
        raise
    finally:
        pool.shutdown(cancel_futures=True)


# The run and the painter of this worker process, or the error that prevented them.
_prepared: list[tuple[FramesOfRun, Painter] | Exception] = []


def _prepare(run: FramesOfRun, settings: str) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the process that started this one
    threading.Thread(target=_end_with_parent, daemon=True).start()
    values, ranges = json.loads(settings)
    options = options_from_dict(values)
    try:
        renderer = Renderer(run.topology, options)
        _prepared[:] = [(run, painter_of(run, renderer, options, ranges))]
    except Exception as error:
        _prepared[:] = [error]


def _end_with_parent() -> None:
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _draw(part: tuple[int, Path]) -> None:
    (prepared,), (index, path) = _prepared, part
    if isinstance(prepared, Exception):
        raise prepared
    run, painter = prepared
    painter.draw(path, run[index])
