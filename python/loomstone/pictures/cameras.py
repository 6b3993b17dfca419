"""Cameras that are fitted to the frames of a run, turn about its scene, or follow keyframes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

from .._core import Camera, CameraFit, InvalidInput, RenderOptions
from ..base.arguments import takes
from .frames import FramesOfRun, check_frames

__all__ = ["fitted_camera", "read_camera", "turntable"]


@takes()
def fitted_camera(
    run: FramesOfRun, options: RenderOptions, *, frames: Sequence[int] | None = None
) -> Camera:
    """Returns a camera that shows the surfaces of all chosen frames as large as possible.

    Floors and hidden surfaces do not count. The direction of view and the field of view are those
    of `options.camera`, and the aspect ratio of the picture is that of `options`.

    frames : indices of the chosen frames; None: all frames

    Raises InvalidInput for a camera with keyframes or an index out of range, and CacheError if the
    run has no frames.
    """
    check_frames(run, frames)
    fit = CameraFit(run.topology, options)
    for i in range(len(run)) if frames is None else frames:
        fit.include(run[i])
    return fit.camera()


@takes(degrees="degrees")
def turntable(run: FramesOfRun, camera: Camera, *, degrees: float = 360.0) -> Camera:
    """Returns a camera that turns about the scene over a run, counter-clockwise as seen from above.

    The angle would reach `degrees` one frame after the last frame of the run, so that a video of
    whole turns repeats without a jump.

    Raises CacheError if the run has no frames.
    """
    check_frames(run, None)
    # Frames are equally spaced in time.
    spacing = run[1].time - run[0].time if len(run) > 1 else 1.0
    return camera.replace(turn=degrees / (spacing * len(run)))


@takes()
def read_camera(path: str | os.PathLike[str]) -> Camera:
    """Reads a camera from a JSON file that has fields of Camera, such as eye, target and times.

    If the file has the field `eye` but not `fit`, `fit` is False. Raises InvalidInput if the file
    cannot be read or does not describe a camera.
    """
    try:
        fields = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidInput(f"{path}: the camera cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InvalidInput(f"{path}: must be JSON with fields of Camera: {error}") from None
    if not isinstance(fields, dict):
        raise InvalidInput(
            f'{path}: must be a JSON object with fields of Camera, such as {{"eye": [1, -1, 1]}}'
        )
    if "eye" in fields:
        fields = {"fit": False} | fields
    try:
        return Camera(**fields)
    except (InvalidInput, TypeError) as error:
        raise InvalidInput(f"{path}: {error}") from None
