"""The commands loomstone check and loomstone info."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..runs.cache import Run
from ..runs.scene_file import SceneFile, parse_parameters
from .application import app, session
from .inspection import check_run, check_scene, describe
from .options import Parameters


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="scene file, or directory of a run")],
    p: Parameters = [],  # noqa: B006
    render: Annotated[
        Path | None,
        typer.Option(help="picture (PNG) of the start, vertices of intersecting triangles marked"),
    ] = None,
) -> None:
    """Checks a scene before it is run, or the claims of a run.

    A scene is checked for whether it can be simulated, and for triangles that intersect at its
    start. A run is checked for triangles that intersect in any frame, and by check() of its scene
    file. The exit code is 1 if a check fails.

    \b
        loomstone check scenes/drape.py --render start.png
        loomstone check out/drape
    """
    with session(parallel=False):
        if path.is_dir():
            good = check_run(Run(path))
        else:
            good = check_scene(SceneFile.open(path, parse_parameters(p)), render)
        if not good:
            raise typer.Exit(1)


@app.command()
def info(
    path: Annotated[Path, typer.Argument(help="run, .vtkhdf file, checkpoint, mesh or scene file")],
) -> None:
    """Describes the content of a run, cache file, checkpoint, mesh or scene file.

    \b
        loomstone info out/drape
    """
    with session(parallel=False):
        describe(path)
