"""The command loomstone view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .._core import Camera, RenderOptions
from ..pictures.directory import drawn_with
from ..runs.cache import Run
from ..runs.parameters import given_parameters
from ..runs.scene_file import SceneFile
from .application import WrongCommand, app, command_line, refuse_options, session
from .options import Parameters, Threads

if TYPE_CHECKING:
    from ..viewer import Live, Player


HOST, PORT = "127.0.0.1", 8080


@app.command()
def view(
    source: Annotated[Path, typer.Argument(help="directory of a run, or scene file")],
    p: Parameters = [],  # noqa: B006
    threads: Threads = 0,
    port: Annotated[int, typer.Option(help="port of the page", min=0, max=65535)] = PORT,
    host: Annotated[
        str,
        typer.Option(help="address that serves the page; 0.0.0.0: accessible from all machines"),
    ] = HOST,
    paused: Annotated[bool, typer.Option("--paused", help="wait for the user to start")] = False,
    html: Annotated[
        Path | None, typer.Option(help="write to this file a page that needs no server, and exit")
    ] = None,
) -> None:
    """Shows a run on a web page, or simulates a scene there.

    A run is played with a timeline, which grows while the run is still in progress. A scene file is
    simulated as you watch: pull cloth, rigid bodies and obstacles with the left mouse button. To
    watch from another machine, first forward the port there: ssh -L 8080:localhost:8080 HOST.

    \b
        loomstone view out/drape
        loomstone view scenes/drape.py -p triangles=3600
        loomstone view out/drape --html drape.html
    """
    from ..viewer import live, play, write_html  # a late import, so that other commands start fast

    with session(parallel=False):
        if source.suffix == ".py":
            if html is not None:
                raise WrongCommand("--html needs a run, got a scene file; simulate it first")
            with command_line():
                given = given_parameters(p)
            file = SceneFile.open(source, given)
            shown: Live | Player = live(
                file.scene(),
                integrator=file.integrator,
                threads=threads,
                control=file.control,
                title=source.stem,
                camera=_camera(file.render),
                paused=paused,
                field_lines=file.render.field_lines if file.render else 0,
                host=host,
                port=port,
            )
        else:
            _refuse_for_runs(p, threads, paused)
            run = Run(source)
            camera = _camera(drawn_with(run.directory / "frames"))
            if html is not None:
                _refuse_for_html(host, port)
                print(f"page: {write_html(run, html, camera=camera)}")
                return
            shown = play(run, camera=camera, host=host, port=port)
        print(f"page: {shown.page.url} (Ctrl-C ends it)", flush=True)
        try:
            shown.wait()
        except KeyboardInterrupt:
            shown.stop()


def _refuse_for_runs(parameters: list[str], threads: int, paused: bool) -> None:
    """Raises WrongCommand for options that affect only the simulation of a scene."""
    given = {"--parameter": bool(parameters), "--threads": threads != 0, "--paused": paused}
    refuse_options(given, "is an option for scene files, not for runs")


def _refuse_for_html(host: str, port: int) -> None:
    """Raises WrongCommand for options of the server, which a page in a file does not need."""
    given = {"--host": host != HOST, "--port": port != PORT}
    refuse_options(given, "has no effect with --html")


def _camera(options: RenderOptions | None) -> Camera:
    return options.camera if options else Camera()
