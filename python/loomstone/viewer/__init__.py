"""A web page that plays a run, or shows a running simulation that reacts to the mouse.

By default, viser serves the page only to browsers on this machine. To watch from another machine,
forward the port to it: run `ssh -L 8080:localhost:8080 HOST` there, where HOST is this machine.
"""

from __future__ import annotations

import os
from collections.abc import Callable

from .._core import Camera, Scene
from ..base.arguments import takes
from ..integrators import Integrator
from ..runs.cache import Run
from ..simulation import Simulation
from .export import write_html
from .live_page import Live
from .player import Player

__all__ = ["Live", "Player", "live", "play", "write_html"]


@takes()
def play(
    run: Run | str | os.PathLike[str],
    *,
    camera: Camera | None = None,
    host: str = "127.0.0.1",
    port: int = 8080,
) -> Player:
    """Serves a page that plays a run, and returns at once.

    New frames of a run in progress appear on the page.

    camera : Camera at the start; None: one that shows all of the first frame except floors
    host, port : address of the page. If the port is taken, the next free one is used.

    The result has `page.url`, `wait()` and `stop()`. Raises Unsupported if viser is not installed
    (`pip install "loomstone[view]"`), and CacheError if the run cannot be read or has no frames.
    """
    opened = run if isinstance(run, Run) else Run(run)
    return Player(opened, camera=camera or Camera(), host=host, port=port)


@takes()
def live(
    scene: Scene,
    *,
    integrator: Integrator | None = None,
    threads: int = 0,
    control: Callable[[Simulation], None] | None = None,
    title: str = "loomstone",
    camera: Camera | None = None,
    paused: bool = False,
    field_lines: int = 0,
    host: str = "127.0.0.1",
    port: int = 8080,
) -> Live:
    """Serves a page with a running simulation, and returns at once.

    On the page, the left mouse button pulls cloth, rigid bodies and obstacles. Cloth and rigid
    bodies are pulled by a force, and collisions and strain limits remain active. Obstacles follow
    the mouse, except floors and obstacles with `vertex_positions`. Simulated time keeps up with
    real time if the machine is fast enough.

    integrator, threads : as in Simulation
    control : function called before every step, as in Simulation.run
    title : title of the page
    camera : Camera at the start; None: one that shows all of the scene except floors
    paused : whether the simulation waits until the user starts it
    field_lines : number of magnetic field lines at the start
    host, port : address of the page. If the port is taken, the next free one is used.

    The result has `page.url`, `rates()`, `intersecting_pairs()`, `start()`, `pause()`, `wait()` and
    `stop()`. Raises Unsupported if viser is not installed (`pip install "loomstone[view]"`), and
    InvalidInput if the scene cannot be simulated.
    """
    return Live(
        scene,
        integrator=integrator,
        threads=threads,
        control=control,
        title=title,
        camera=camera or Camera(),
        paused=paused,
        lines=field_lines,
        host=host,
        port=port,
    )


def __dir__() -> list[str]:
    return __all__
