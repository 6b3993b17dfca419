"""Makes videos from directories of pictures, by ffmpeg."""

from __future__ import annotations

import subprocess
from pathlib import Path

from .._core import CacheError
from ..base.arguments import takes
from .directory import is_whole, picture

__all__ = ["encode"]


@takes(rate="1/s")
def encode(directory: Path, target: Path, *, frames: int, rate: float = 25.0) -> str:
    """Encodes the pictures of a directory as a video, by imageio-ffmpeg; returns the video's path.

    frames : number of pictures, which the directory must contain from index 0 on
    rate : pictures per second [1/s]

    Raises CacheError if a picture is missing or incomplete, or if ffmpeg fails.
    """
    import imageio_ffmpeg

    if missing := [i for i in range(frames) if not is_whole(picture(directory, i))]:
        raise CacheError(
            f"{directory} must hold the pictures of {frames} frames, but has none of frame"
            f" {missing[0]}; render it first"
        )
    unfinished = target.with_name("unfinished-" + target.name)
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", "-framerate", str(rate)]
    # ffmpeg runs in the directory, because the directory's name may contain characters that are
    # special in input patterns, such as %. ffmpeg takes the text after "file:" as a path.
    command += [
        "-i",
        "frame-%05d.png",
        "-frames:v",
        str(frames),
        "-c:v",
        "libx264",
        "-pix_fmt",
        "yuv420p",
    ]
    command += [
        "-crf",
        "18",
        "-vf",
        "pad=ceil(iw/2)*2:ceil(ih/2)*2",
        f"file:{unfinished.resolve()}",
    ]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CacheError(
            f"{target}: ffmpeg could not make the video: {done.stderr.strip()[-500:]}; the pictures"
            " are kept: make the video by loomstone render"
        )
    unfinished.replace(target)
    return str(target)
