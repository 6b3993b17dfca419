"""The command loomstone demo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..ranks import launched_rank
from .application import app
from .options import Threads
from .render import render
from .run import Overwrite, run
from .scenes import scene_files


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="directory for the results")] = Path("out/demo"),
    threads: Threads = 0,
    overwrite: Overwrite = False,
) -> None:
    """Drapes a cloth over a sphere, and draws pictures and a video of it.

    The scene is `drape` of `loomstone scenes`, with 3,528 triangles. The command takes less than a
    minute on two processors.

    \b
        loomstone demo
        loomstone view out/demo
    """
    run(
        scene_files()["drape"],
        out=out,
        p=["triangles=3600"],
        threads=threads,
        overwrite=overwrite,
    )
    if launched_rank() == 0:
        render(out, width=640, height=360)
