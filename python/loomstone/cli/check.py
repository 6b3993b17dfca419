"""The commands loomstone check and loomstone info."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..runs.cache import Run
from ..runs.parameters import given_parameters
from ..runs.scene_file import SceneFile
from .application import WrongCommand, app, command_line, refuse_options, session
from .facts import facts
from .inspection import check_run, check_scene, describe, print_source
from .options import AsJson, Parameters, Trust
from .words import Words


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="scene file, or directory of a run")],
    p: Parameters = [],  # noqa: B006
    render: Annotated[
        Path | None,
        typer.Option(help="picture (PNG) of the start; marks vertices of intersecting triangles"),
    ] = None,
    trust: Trust = False,
) -> None:
    """Checks a scene before it is run, or checks a run.

    A scene fails if it cannot be simulated, for example because cloth intersects itself or another
    surface at the start. A run fails if triangles of cloth intersect in any frame, or if check() of
    its scene file fails. The exit code is 1 if the scene or run fails. check() is part of the
    program that the run contains; see --trust.

    \b
        loomstone check scenes/drape.py --render start.png
        loomstone check out/drape
    """
    with session(parallel=False):
        if path.is_dir() or path.suffix == ".vtkhdf":
            if p or render:
                raise WrongCommand(
                    f"{'-p' if p else '--render'} is an option for scene files, but {path} is a"
                    " run; leave it out"
                )
            good = check_run(Run(path.absolute()), trust=trust)
        else:
            with command_line():
                given = given_parameters(p)
            good = check_scene(SceneFile.open(path, given), render)
        if not good:
            raise typer.Exit(1)


@app.command()
def info(
    path: Annotated[Path, typer.Argument(help="run, .vtkhdf file, checkpoint, mesh or scene file")],
    source: Annotated[
        bool, typer.Option("--source", help="print the scene program stored in a run")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Describes the content of a run, cache file, checkpoint, mesh or scene file.

    \b
        loomstone info out/drape
        loomstone info out/drape --json
    """
    with session(parallel=False):
        if source:
            refuse_options({"--json": as_json}, "has no effect with --source")
            print_source(path)
        elif as_json:
            with Words(as_json=True) as words:
                words.json(facts(path))
        else:
            describe(path)
