"""The command loomstone export."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..exchange.export import FORMATS, export_run, format_of
from ..exchange.selection import parse_frames
from ..runs.cache import Run
from .application import app, command_line, session
from .options import RunArgument, one_of


@app.command()
def export(
    run: RunArgument,
    to: Annotated[
        str | None,
        typer.Option(
            help=f"{' | '.join(FORMATS)}; default: that of the suffix of --out",
            autocompletion=one_of(FORMATS),
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="file, or directory for pc2, mdd, obj, ply; default: in directory RUN"),
    ] = None,
    frames: Annotated[
        str | None, typer.Option(metavar="A:B", help="only frames A to B - 1; default: all")
    ] = None,
    every: Annotated[int, typer.Option(help="only every N-th of these frames", metavar="N")] = 1,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="replace an earlier export")
    ] = False,
) -> None:
    """Writes a run for other programs, such as Blender and Houdini.

    usd stores points and poses over time, uv and materials. gltf stores morph targets, animated
    nodes, uv and materials. alembic stores points and poses over time, uv and colours. pc2 and mdd
    write an OBJ file for each surface, and a point cache for each surface that moves. obj and ply
    write a mesh file for each frame of a surface that moves, and a single mesh file for each other
    surface. Lengths are in metres. z points up, except in gltf and alembic, where y points up.

    \b
        loomstone export out/drape --to usd
        loomstone export out/drape --to obj --out seq --frames 10:50 --every 2
    """
    with session(parallel=False):
        with command_line():
            chosen_format = format_of(to)
        source = Run(run)
        chosen = None if frames is None else parse_frames(frames, len(source))
        count = len(range(0, len(chosen or source), max(every, 1)))
        with typer.progressbar(
            length=2 * count, label="exporting", hidden=not sys.stdout.isatty()
        ) as bar:
            paths = export_run(
                source,
                out,
                to=chosen_format,
                frames=chosen,
                every=every,
                overwrite=overwrite,
                progress=bar.update,
            )
        size = sum(path.stat().st_size for path in paths) / 2**20
        place = paths[0] if len(paths) == 1 else f"{paths[0].parent} ({len(paths)} files)"
        print(f"exported: {place}, {size:.3g} MiB")
