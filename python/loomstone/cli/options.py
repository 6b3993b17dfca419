"""Arguments and options shared by several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["Parameters", "Render", "RunArgument", "SceneArgument", "Threads", "Trust"]

SceneArgument = Annotated[Path, typer.Argument(help="Python file with a function scene()")]
RunArgument = Annotated[Path, typer.Argument(help="directory of a run")]
Parameters = Annotated[
    list[str],
    typer.Option("-p", "--parameter", help="parameter of scene() as name=value; may be repeated"),
]
Threads = Annotated[int, typer.Option(help="number of threads; 0: all processors", min=0)]
Render = Annotated[bool, typer.Option("--render", help="draw every frame and make a video")]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        help="run the program stored in the run even if it differs from the scene file at hand",
    ),
]
