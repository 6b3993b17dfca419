"""The command loomstone render."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from .._core import InvalidInput, RenderOptions
from ..pictures.directory import drawn_with
from ..pictures.drawing import render_run
from ..pictures.video import encode
from ..runs.cache import Run
from ..runs.scene_file import stored_options
from .application import app, session
from .options import RunArgument

Pixels = Annotated[int | None, typer.Option(help="size of the picture [pixels]")]
ColorBy = Annotated[
    str | None,
    typer.Option(
        help=(
            "cloth | stretch | strain_weft | strain_warp | strain_shear | strain_split |"
            " contact; several joined by +"
        )
    ),
]
ColorMap = Annotated[str | None, typer.Option(help="viridis | magma | diverging")]
Low = Annotated[float | None, typer.Option(help="value at the low end of the colour map")]
High = Annotated[float | None, typer.Option(help="value at the high end of the colour map")]
Pattern = Annotated[str | None, typer.Option(help="weave | checker | plain")]
Wireframe = Annotated[bool | None, typer.Option(help="draw the edges of the cloth's triangles")]
FieldLines = Annotated[int | None, typer.Option(help="number of magnetic field lines; 0: none")]
Frames = Annotated[list[int], typer.Option(help="only this frame (-1: the last); may be repeated")]
Target = Annotated[
    Path | None,
    typer.Option(
        help="directory for pictures and video; default: frames/ and video.mp4 in the run"
    ),
]
Jobs = Annotated[int, typer.Option(help="frames drawn in parallel; 0: one per processor", min=0)]
Again = Annotated[
    bool, typer.Option("--again", help="delete existing pictures and draw all frames")
]


@app.command()
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
    frame: Frames = [],  # noqa: B006
    out: Target = None,
    jobs: Jobs = 0,
    again: Again = False,
) -> None:
    """Draws the frames of a run and makes a video.

    Options that are not given are taken from the existing pictures in frames/, or else from the
    scene file. Existing pictures (PNG) are kept, so an interrupted rendering continues. All
    pictures in a directory have the same options; different ones require --out or --again. Single
    frames (--frame) are always drawn, into the directory of the run unless --out is given. A fitted
    camera is fitted to the first frame. Colours without --color-low and --color-high span the
    values of all frames.

    Strain is U - I, as for strain limits. strain_split shows weft on the left half of each cloth
    and warp on the right. contact is 1 in contact, and 2 where triangles were forced to intersect.
    Several values of --color-by joined by + are drawn one below another.

    \b
        loomstone render out/drape --color-by stretch --wireframe
        loomstone render out/disc --color-by strain_split+strain_shear --color-map diverging
    """
    given = {
        "width": width,
        "height": height,
        "color_by": color_by,
        "color_map": color_map,
        "color_low": color_low,
        "color_high": color_high,
        "pattern": pattern,
        "wireframe": wireframe,
        "field_lines": field_lines,
    }
    with session(parallel=False):
        source = Run(run)
        options = _look(source, {name: value for name, value in given.items() if value is not None})
        wanted = _chosen(source, frame)
        with typer.progressbar(
            length=len(wanted or source), label="rendering", hidden=not sys.stdout.isatty()
        ) as bar:
            paths = render_run(
                source, options, out=out, jobs=jobs, again=again, frames=wanted, progress=bar.update
            )
        count = f"{paths[0].parent} ({len(paths)})"
        print(f"pictures: {paths[0] if len(paths) == 1 else count}")
        if not frame:
            target = (out or source.directory) / "video.mp4"
            path = encode(paths[0].parent, target, frames=len(paths), rate=source.rate)
            print(f"video: {path}")


def _look(run: Run, given: dict[str, Any]) -> RenderOptions:
    """Returns the given options, completed by those of existing pictures or of the scene file."""
    options = drawn_with(run.directory / "frames")
    options = options or (stored_options(run)[3] if "render" in run.metadata else RenderOptions())
    return options.replace(**given)


def _chosen(run: Run, frames: list[int]) -> list[int] | None:
    """Returns the chosen frames as indices counted from the start, or None for all frames."""
    for i in frames:
        if not -len(run) <= i < len(run):
            raise InvalidInput(
                f"--frame must be in [0, {len(run) - 1}], or count from the end, got {i}"
            )
    return [i % len(run) for i in frames] or None
