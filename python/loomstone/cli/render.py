"""The command loomstone render."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
import typer

from .._core import Camera, InvalidInput, RenderOptions
from ..pictures import cameras
from ..pictures.directory import drawn_with
from ..pictures.drawing import render_run
from ..pictures.passes import Pass, write_passes
from ..pictures.video import encode
from ..runs.cache import Run
from ..runs.scene_file import stored_options
from .application import app, refuse_options, session
from .options import Quiet, RunArgument, one_of

FIELDS = (
    "cloth",
    "stretch",
    "strain_weft",
    "strain_warp",
    "strain_shear",
    "strain_split",
    "contact",
)
Pixels = Annotated[int | None, typer.Option(help="size of the picture [pixels]")]
ColorBy = Annotated[
    str | None,
    typer.Option(
        help=f"{' | '.join(FIELDS)}; several joined by +",
        autocompletion=one_of(FIELDS),
    ),
]
ColorMap = Annotated[
    str | None,
    typer.Option(help="viridis, magma, RdBu_r or another name of matplotlib, or diverging"),
]
Low = Annotated[float | None, typer.Option(help="value at the low end of the colour map")]
High = Annotated[float | None, typer.Option(help="value at the high end of the colour map")]
Pattern = Annotated[
    str | None,
    typer.Option(
        help="weave | checker | plain", autocompletion=one_of(("weave", "checker", "plain"))
    ),
]
Wireframe = Annotated[bool | None, typer.Option(help="draw the edges of the cloth's triangles")]
FieldLines = Annotated[int | None, typer.Option(help="number of magnetic field lines; 0: none")]
Eye = Annotated[
    tuple[float, float, float] | None,
    typer.Option(metavar="X Y Z", help="position of the camera [m]; switches fit off"),
]
LookAt = Annotated[
    tuple[float, float, float] | None,
    typer.Option("--target", metavar="X Y Z", help="point at which the camera looks [m]"),
]
FieldOfView = Annotated[float | None, typer.Option(help="vertical field of view [degrees]")]
Fit = Annotated[
    bool,
    typer.Option("--fit", help="fill the picture with cloth and bodies of all frames drawn"),
]
Turntable = Annotated[
    float | None,
    typer.Option(metavar="DEGREES", help="turn the camera by this angle over the run"),
]
CameraFile = Annotated[
    Path | None,
    typer.Option("--camera", metavar="FILE", help="JSON file with fields of Camera"),
]
BackgroundChoice = Annotated[
    str | None,
    typer.Option(
        help="backdrop | none: transparent, without a video",
        autocompletion=one_of(("backdrop", "none")),
    ),
]
Passes = Annotated[
    list[str],
    typer.Option(
        "--pass",
        help="write depth | normal | id as EXR files in place of pictures; may be repeated",
        autocompletion=one_of(("depth", "normal", "id")),
    ),
]
Frames = Annotated[list[int], typer.Option(help="only this frame (-1: the last); may be repeated")]
Target = Annotated[
    Path | None,
    typer.Option(
        help=(
            "directory for pictures and video; default: frames/ and video.mp4 in the run, passes/"
            " for passes"
        )
    ),
]
Jobs = Annotated[int, typer.Option(help="frames drawn in parallel; 0: one per processor", min=0)]
Again = Annotated[
    bool, typer.Option("--again", help="delete existing pictures and draw all frames")
]


_HELP = """Draws the frames of a run and makes a video.

Options that are not given are taken from the existing pictures in frames/, or else from the
scene file. Existing pictures (PNG) are kept, so an interrupted rendering continues. All
pictures in a directory have the same options; different ones require --out or --again. Single
frames (--frame) are always drawn, into the directory of the run unless --out is given. Without
a camera in the scene file, or with --fit, cloth and bodies of all frames drawn fill the
picture. An end of the colour map without --color-low or --color-high has the smallest or the
largest value of all frames.

Strain is U - I, as for strain limits. strain_split shows weft on the left half of each cloth
and warp on the right. contact is 1 in contact, and 2 where triangles were forced to intersect.
Several values of --color-by joined by + are drawn one below another.

Passes are 32-bit floats, taken at the middle of each pixel. depth: distance along the viewing
direction [m], inf without a surface. normal: unit normal in world axes. id: 0 without a
surface, from 1 the cloths, then bodies and obstacles.

\b
    loomstone render out/drape --color-by stretch --wireframe
    loomstone render out/disc --color-by strain_split+strain_shear --color-map diverging
    loomstone render out/drape --fit --turntable 360 --background none --out out/turn
    loomstone render out/drape --frame -1 --pass depth --pass id
"""


@app.command(help=_HELP)
def render(
    run: RunArgument,
    width: Pixels = None,
    height: Pixels = None,
    color_by: ColorBy = None,
    color_map: ColorMap = None,
    color_low: Low = None,
    color_high: High = None,
    pattern: Pattern = None,
    wireframe: Wireframe = None,
    field_lines: FieldLines = None,
    background: BackgroundChoice = None,
    camera: CameraFile = None,
    eye: Eye = None,
    target: LookAt = None,
    fov: FieldOfView = None,
    fit: Fit = False,
    turntable: Turntable = None,
    passes: Passes = [],  # noqa: B006
    frame: Frames = [],  # noqa: B006
    out: Target = None,
    jobs: Jobs = 0,
    again: Again = False,
    quiet: Quiet = False,
) -> None:
    """Draws the frames of a run and makes a video."""
    given = {name: value for name, value in locals().items() if value is not None}
    with session(parallel=False):
        _refuse_ineffective(given)
        chosen = _chosen(source := Run(run), frame)
        options = _look(source, given)
        with typer.progressbar(
            length=len(chosen or source), label="rendering", hidden=quiet or not sys.stdout.isatty()
        ) as bar:
            if passes:
                paths = write_passes(
                    source,
                    options,
                    cast("list[Pass]", passes),
                    out=out,
                    frames=chosen,
                    progress=bar.update,
                )
            else:
                paths = render_run(
                    source,
                    options,
                    out=out,
                    frames=chosen,
                    jobs=jobs,
                    again=again,
                    progress=bar.update,
                )
        told = [_told("passes" if passes else "pictures", paths)]
        if not frame and not passes and options.background != "none":
            video = (out or source.directory) / "video.mp4"
            path = encode(paths[0].parent, video, frames=len(paths), rate=source.rate)
            told.append(f"video: {path}")
        if not quiet:
            print("\n".join(told))


def _refuse_ineffective(given: dict[str, Any]) -> None:
    """Raises WrongCommand for options that have no effect with --frame or with --pass."""
    again = {"--again": given["again"]}
    if given["frame"]:
        refuse_options(again, "has no effect with --frame")
    if given["passes"]:
        refuse_options(again | {"--jobs": given["jobs"] > 0}, "has no effect with --pass")


def _told(what: str, paths: list[Path]) -> str:
    return f"{what}: {paths[0] if len(paths) == 1 else f'{paths[0].parent} ({len(paths)})'}"


# Fields of RenderOptions that are set by command-line options of the same names.
_FIELDS = (
    *("width", "height", "color_by", "color_map", "color_low", "color_high", "pattern"),
    *("wireframe", "field_lines", "background"),
)


def _look(run: Run, given: dict[str, Any]) -> RenderOptions:
    """Returns the options of the pictures, changed by the command-line options `given`.

    The unchanged options are those of existing pictures, or else of the run, or else the defaults.
    """
    options = drawn_with(run.directory / "frames")
    options = options or (stored_options(run)[3] if "render" in run.metadata else RenderOptions())
    camera = _camera(run, options.camera, given)
    return options.replace(
        camera=camera, **{name: given[name] for name in _FIELDS if name in given}
    )


def _camera(run: Run, camera: Camera, given: dict[str, Any]) -> Camera:
    """Returns the camera of --camera, or else `camera`, changed by the other options in `given`."""
    if "camera" in given:
        camera = cameras.read_camera(given["camera"])
    if "target" in given and "eye" not in given and np.array_equal(camera.eye, Camera().eye):
        raise InvalidInput("--target needs --eye, because no camera gives a position of the eye")
    if "eye" in given or "target" in given:
        none = np.empty((0, 3))
        camera = camera.replace(fit=False, times=[], eyes=none, targets=none)
    sight: dict[str, Any] = {name: given[name] for name in ("eye", "target") if name in given}
    if "fov" in given:
        sight["field_of_view_degrees"] = given["fov"]
    if given["fit"]:
        sight["fit"] = True
        if camera.times:
            camera = _at_start(camera)
    camera = _upright(camera.replace(**sight))
    if "turntable" in given:
        camera = cameras.turntable(run, camera, degrees=given["turntable"])
    return camera


def _at_start(camera: Camera) -> Camera:
    """Returns the first keyframe of a camera, as a camera without keyframes."""
    target = camera.targets[0] if len(camera.targets) else camera.target
    none = np.empty((0, 3))
    return camera.replace(eye=camera.eyes[0], target=target, times=[], eyes=none, targets=none)


def _upright(camera: Camera) -> Camera:
    """Returns `camera`, with y as its `up` if it has no keyframes and looks along its `up`."""
    sight = np.subtract(camera.target, camera.eye)
    size = float(np.linalg.norm(sight) * np.linalg.norm(camera.up))
    if camera.times or size == 0.0 or np.linalg.norm(np.cross(sight, camera.up)) > 1e-6 * size:
        return camera
    return camera.replace(up=(0.0, 1.0, 0.0))


def _chosen(run: Run, frames: list[int]) -> list[int] | None:
    """Returns the chosen frames as indices counted from the start, or None for all frames."""
    for i in frames:
        if not -len(run) <= i < len(run):
            raise InvalidInput(
                f"--frame must be in [0, {len(run) - 1}], or count from the end, got {i}"
            )
    return list(dict.fromkeys(i % len(run) for i in frames)) or None
