"""Depth, normal and surface number of each pixel as OpenEXR files, for compositing."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from .._core import FrameTopology, InvalidInput, RenderOptions
from ..base.arguments import takes
from ..exchange.extras import imported
from .directory import make_directory
from .drawing import framed, painter_of
from .frames import FramesOfRun, check_frames
from .renderer import Renderer

__all__ = ["PASSES", "Pass", "write_passes"]

Pass = Literal["depth", "normal", "id"]
PASSES: tuple[Pass, ...] = get_args(Pass)

_MEANINGS = {
    "depth": "Z: distance from the camera along its viewing direction [m]; inf: no surface",
    "normal": "R, G, B: x, y, z of the unit normal in world axes, on the visible side",
    "id": "id: number of the surface; 0: no surface",
}


@takes()
def write_passes(
    run: FramesOfRun,
    options: RenderOptions,
    passes: Sequence[Pass],
    *,
    out: str | os.PathLike[str] | None = None,
    frames: Sequence[int] | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Path]:
    """Writes depths, normals or surface numbers of pixels as OpenEXR files; returns their paths.

    The files are depth-00000.exr, normal-00000.exr, id-00000.exr and so on; existing ones are
    replaced. Values are 32-bit floats, taken at the middle of each pixel without anti-aliasing.

    passes : any of the following
        depth (channel Z) : distance along the viewing direction [m]; infinity without a surface
        normal (channels R, G, B) : x, y and z of the unit normal in world axes, on the visible
            side; zero without a surface
        id (channel id) : number of the visible surface; 0 without a surface. Cloths are numbered
            from 1, followed by bodies and obstacles in the order of the scene. All field lines
            share the last number. The attribute `surfaces` of a file lists the numbers with names.
    out : directory of the files, by default `passes` in the run's directory
    frames : indices of frames; None: all frames
    progress : function called with the number of frames finished since its last call

    Raises InvalidInput for an unknown pass or an index out of range, CacheError if the run has no
    frames or the directory cannot be made, and Unsupported without the package OpenEXR.
    """
    check_frames(run, frames)
    if unknown := [name for name in passes if name not in PASSES]:
        raise InvalidInput(f"pass must be {', '.join(PASSES)}, got {unknown[0]!r}")
    imported("OpenEXR", "a pass")
    topology, shown = run.topology, framed(run, options, frames)
    painter = painter_of(run, Renderer(topology, shown), shown, None)
    directory = Path(out) if out else run.directory / "passes"
    make_directory(directory)
    paths = []
    for i in range(len(run)) if frames is None else frames:
        arrays = dict(zip(PASSES, painter.surfaces(run[i]), strict=True))
        for name in dict.fromkeys(passes):
            paths.append(directory / f"{name}-{i:05d}.exr")
            _write(paths[-1], name, arrays[name], topology)
        if progress:
            progress(1)
    return paths


def _write(path: Path, name: Pass, values: NDArray[Any], topology: FrameTopology) -> None:
    exr: Any = imported("OpenEXR", path)
    header: dict[str, Any] = {
        "compression": exr.ZIP_COMPRESSION,
        "type": exr.scanlineimage,
        "comments": _MEANINGS[name],
    }
    if name == "id":
        names = [*topology.cloth_names, *topology.body_names, "field lines"]
        header["surfaces"] = "\n".join(f"{i} {each}" for i, each in enumerate(names, 1))
    channel = {"depth": "Z", "normal": "RGB", "id": "id"}[name]
    unfinished = path.with_name(f"unfinished-{path.name}")
    with exr.File(header, {channel: np.ascontiguousarray(values, np.float32)}) as file:
        file.write(str(unfinished))
    unfinished.replace(path)
