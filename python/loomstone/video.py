"""Pictures and videos of a run."""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from . import _core
from ._core import CacheError, Camera, InvalidInput, RenderOptions
from .cache import Run
from .magnetics.lines import frame_curves

__all__ = ["encode", "options_from_dict", "render_run"]


def options_from_dict(values: dict[str, Any]) -> RenderOptions:
    """RenderOptions from what to_dict() gave."""
    return RenderOptions(**(values | {"camera": Camera(**values["camera"])})) if "camera" in values else RenderOptions(**values)


def render_run(
    run: Run,
    options: RenderOptions,
    *,
    jobs: int = 0,
    again: bool = False,
    frames: Sequence[int] | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Path]:
    """Draws frames of a run into its directory `frames`, several at once; those already there are kept.

    jobs : processes, 0 means one a processor; again : draws all anew; frames : indices, default all
    Pictures are drawn anew wherever the options differ from those of the last time.
    """
    directory = run.directory / "frames"
    directory.mkdir(exist_ok=True)
    wanted = list(range(len(run)) if frames is None else frames)
    if any(not 0 <= i < len(run) for i in wanted):
        raise InvalidInput(f"frames must be in [0, {len(run) - 1}], got {wanted}; the run has {len(run)} frames")
    settings = json.dumps(options.to_dict())
    note = directory / "options.json"
    if again or not note.exists() or note.read_text() != settings:
        for path in directory.glob("frame-*.png"):
            path.unlink()
        note.write_text(settings)
    paths = [directory / f"frame-{i:05d}.png" for i in wanted]
    missing = [i for i, path in zip(wanted, paths) if not path.exists()]
    jobs = max(1, min(jobs or _core.default_thread_count(), len(missing)))
    if progress:
        progress(len(wanted) - len(missing))
    work = [(str(run.directory), settings, i) for i in missing]
    if jobs == 1:
        _notify(map(_draw, work), progress)
    else:
        with multiprocessing.get_context("spawn").Pool(jobs) as pool:
            _notify(pool.imap_unordered(_draw, work), progress)
    return paths


def _notify(done: Iterable[int], progress: Callable[[int], None] | None) -> None:
    for _ in done:
        if progress:
            progress(1)


# One run and one renderer a process; where field lines are drawn, the scene that has the magnets.
_open: dict[tuple[str, str], tuple[Run, _core.Renderer, _core.Simulation | None]] = {}


def _draw(part: tuple[str, str, int]) -> int:
    directory, settings, index = part
    if (directory, settings) not in _open:
        run = Run(directory)
        options = options_from_dict(json.loads(settings))
        _open.clear()
        _open[directory, settings] = run, _core.Renderer(run.topology, options), _magnets(run) if options.field_lines else None
    run, renderer, simulation = _open[directory, settings]
    frame = run[index]
    curves = frame_curves(simulation, frame, json.loads(settings)["field_lines"]) if simulation else None
    _core.write_png(str(Path(directory) / "frames" / f"frame-{index:05d}.png"), renderer.render(frame, curves))
    return index


def _magnets(run: Run) -> _core.Simulation:
    from .scene_file import SceneFile  # which needs this module

    return _core.Simulation(SceneFile.of_run(run).scene(), threads=1)


def encode(directory: str | os.PathLike[str], *, rate: float = 25.0, name: str = "video.mp4") -> str:
    """Makes a video of the pictures of a run by ffmpeg, as imageio-ffmpeg brings it; returns its path.

    directory : of the run; rate : pictures a second
    """
    import imageio_ffmpeg

    if not list((Path(directory) / "frames").glob("frame-*.png")):
        raise CacheError(f"{directory} must hold pictures in frames/, but has none; render it first")
    target = Path(directory) / name
    unfinished = target.with_name("unfinished-" + name)
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", "-framerate", str(rate)]
    command += ["-i", str(Path(directory) / "frames" / "frame-%05d.png"), "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18"]
    command += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", str(unfinished)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CacheError(f"{target}: ffmpeg could not make the video: {done.stderr.strip()[-500:]}")
    unfinished.replace(target)
    return str(target)
