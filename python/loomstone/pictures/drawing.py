"""Pictures and videos of a run.

A directory of pictures holds frame-00000.png and so on of one run, all drawn with the options that
its options.json tells.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from .._core import CacheError, Camera, Frame, InvalidInput, RenderOptions
from ..runs.cache import Run
from ..magnetics.lines import frame_curves

__all__ = [
    "Painter",
    "claim",
    "colours_need_all_frames",
    "drawn_with",
    "encode",
    "options_from_dict",
    "picture",
    "render_run",
]

Ranges = list[tuple[float, float]]


def options_from_dict(values: dict[str, Any]) -> RenderOptions:
    """RenderOptions from what to_dict() gave."""
    return (
        RenderOptions(**(values | {"camera": Camera(**values["camera"])}))
        if "camera" in values
        else RenderOptions(**values)
    )


def picture(directory: Path, index: int) -> Path:
    """Where the picture of a frame lies."""
    return directory / f"frame-{index:05d}.png"


def colours_need_all_frames(options: RenderOptions) -> bool:
    """Whether colours span the values of all frames, so that nothing can be drawn before the last
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


# ---- what a directory of pictures holds


def _note(directory: Path) -> dict[str, Any]:
    try:
        found = json.loads((directory / "options.json").read_text())
        options_from_dict(found["options"])
    except (OSError, ValueError, TypeError, KeyError):  # none, or of another version
        return {}
    return found if isinstance(found, dict) else {}


def _write_note(directory: Path, note: dict[str, Any]) -> None:
    unfinished = directory / "unfinished-options.json"
    unfinished.write_text(json.dumps(note))
    unfinished.replace(directory / "options.json")


def _pictures(directory: Path) -> list[Path]:
    return list(directory.glob("frame-*.png"))


def drawn_with(directory: Path) -> RenderOptions | None:
    """The options that the pictures of a directory are drawn with; None where it is no directory of
    pictures.
    """
    note = _note(directory)
    return options_from_dict(note["options"]) if note else None


def claim(
    directory: Path, options: RenderOptions, metadata: str, *, again: bool = False, advice: str
) -> dict[str, Any]:
    """Makes a directory one of pictures of a run with these options, or finds that it is; returns
    its note.

    metadata : of the run, as in its cache; again : what was drawn otherwise is deleted, else it is
        refused with the advice
    """
    _make(directory)
    wanted = {
        "options": json.loads(json.dumps(options.to_dict())),
        "run": hashlib.sha256(metadata.encode()).hexdigest()[:16],
    }
    note, there = _note(directory), _pictures(directory)
    same = all(note.get(name) == value for name, value in wanted.items())
    if not again and not same and (note or there):
        if not note:
            found = "pictures, and no options.json that tells how they were drawn"
        elif note.get("run") != wanted["run"]:
            found = "pictures of another run"
        else:
            differing = [k for k, v in wanted["options"].items() if note["options"].get(k, v) != v]
            found = "pictures drawn with other options" + "".join(
                f", {k} {note['options'].get(k)!r} instead of {wanted['options'][k]!r}"
                for k in differing[:1]
            )
        raise InvalidInput(f"{directory} holds {found}; {advice}")
    if again or not same:
        for path in there:
            path.unlink()
        note = wanted
        _write_note(directory, note)
    return note


def _make(directory: Path) -> None:
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CacheError(
            f"{directory} must be a directory that can be written: {error.strerror}; give another"
        ) from error


# ---- drawing


_ADVICE = "give another directory by --out, or draw all anew by --again"


def render_run(
    run: Run,
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
    """Draws all frames of a run into a directory of pictures, several at once; those already there
    are kept.

    out : directory, default `frames` in that of the run. InvalidInput where it holds pictures drawn
        with other options; again deletes what it holds. Where the run has gone on and automatic
        colours with it, all are drawn anew
    frames : only these, anew, into a directory that is none of those, default that of the run
    jobs : processes, 0 means one a processor; stop : asked before every picture with jobs=1, True
        ends drawing
    simulation : of the run, for field lines; default: made from its scene file

    Every picture is the same whatever is drawn before, beside or without it: a fitted camera shows
    what it would of the run's first frame, and automatic colours span the values of all its frames.
    """
    if not len(run):
        raise CacheError(f"{run.directory} has no frames yet; draw it later")
    if any(not 0 <= i < len(run) for i in frames or ()):
        raise InvalidInput(
            f"frames must be in [0, {len(run) - 1}], got {list(frames or ())}; the run has"
            f" {len(run)} frames"
        )
    renderer = _core.Renderer(
        run.topology, options
    )  # refuses what cannot be drawn before anything is deleted
    ranges = _value_ranges(run, renderer) if colours_need_all_frames(options) else None
    directory = Path(out) if out else run.directory / ("frames" if frames is None else "")
    if frames is None:
        note = claim(directory, options, run.metadata_text, again=again, advice=_ADVICE)
        if note.get("value_ranges") != (known := json.loads(json.dumps(ranges))):
            for path in _pictures(directory):
                path.unlink()
            _write_note(directory, note | {"value_ranges": known})
    elif _note(directory):
        raise InvalidInput(
            f"{directory} holds the pictures of a whole run; give another directory by --out for"
            " single frames"
        )
    else:
        _make(directory)
    wanted = list(range(len(run)) if frames is None else frames)
    paths = [picture(directory, i) for i in wanted]
    missing = [
        (i, path)
        for i, path in zip(wanted, paths, strict=True)
        if frames is not None or not path.exists()
    ]
    jobs = max(1, min(jobs or _core.default_thread_count(), len(missing)))
    if progress:
        progress(len(wanted) - len(missing))
    if jobs == 1:
        painter = _painter(run, renderer, options, ranges, simulation)
        for i, path in missing:
            if stop():
                break
            painter.draw(path, run[i])
            if progress:
                progress(1)
    else:
        settings = json.dumps([options.to_dict(), ranges])
        work = [(str(run.directory), settings, i, str(path)) for i, path in missing]
        with multiprocessing.get_context("spawn").Pool(jobs) as pool:
            for _ in pool.imap_unordered(_draw, work):
                if progress:
                    progress(1)
    return paths


def _value_ranges(run: Run, renderer: _core.Renderer) -> Ranges:
    values = np.array([renderer.value_ranges(frame) for frame in run])
    return [
        (float(low), float(high))
        for low, high in zip(values[:, :, 0].min(0), values[:, :, 1].max(0), strict=True)
    ]


def _painter(
    run: Run,
    renderer: _core.Renderer,
    options: RenderOptions,
    ranges: Ranges | None,
    simulation: Any = None,
) -> Painter:
    if options.field_lines and simulation is None:
        from ..runs.scene_file import SceneFile  # which needs this module

        simulation = _core.Simulation(SceneFile.of_run(run).scene(), threads=1)
    return Painter(
        renderer,
        first=run[0],
        lines=options.field_lines,
        simulation=simulation,
        value_ranges=ranges,
    )


_open: dict[tuple[str, str], tuple[Run, Painter]] = {}  # one run and one painter a process


def _draw(part: tuple[str, str, int, str]) -> None:
    directory, settings, index, path = part
    if (directory, settings) not in _open:
        run = Run(directory)
        values, ranges = json.loads(settings)
        options = options_from_dict(values)
        _open.clear()
        _open[directory, settings] = (
            run,
            _painter(run, _core.Renderer(run.topology, options), options, ranges),
        )
    run, painter = _open[directory, settings]
    painter.draw(Path(path), run[index])


# ---- video


def encode(directory: Path, target: Path, *, frames: int, rate: float = 25.0) -> str:
    """Makes a video of a directory of pictures by ffmpeg, as imageio-ffmpeg brings it; returns its
    path.

    frames : how many pictures it must show; rate : pictures a second
    """
    import imageio_ffmpeg

    if missing := [i for i in range(frames) if not picture(directory, i).exists()]:
        raise CacheError(
            f"{directory} must hold the pictures of {frames} frames, but has none of frame"
            f" {missing[0]}; render it first"
        )
    unfinished = target.with_name("unfinished-" + target.name)
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", "-framerate", str(rate)]
    command += [
        "-i",
        str(directory / "frame-%05d.png"),
        "-frames:v",
        str(frames),
        "-c:v",
        "libx264",
        "-pix_fmt",
        "yuv420p",
    ]
    command += ["-crf", "18", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", str(unfinished)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CacheError(
            f"{target}: ffmpeg could not make the video: {done.stderr.strip()[-500:]}; the pictures"
            " are kept, loomstone render makes it"
        )
    unfinished.replace(target)
    return str(target)
