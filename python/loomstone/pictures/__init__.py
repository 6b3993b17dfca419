"""Pictures of frames, and pictures, plots and videos of runs.

>>> import loomstone as ls
>>> sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)), pins=[0, 4])]))
>>> drawn = ls.pictures.Renderer(sim.topology, ls.RenderOptions(width=64, height=48))
>>> drawn.render(sim.frame()).shape                                          # doctest: +SKIP
(48, 64, 3)
"""

from .._core import Camera, Curves, RenderOptions, write_png
from .cameras import fitted_camera, read_camera, turntable
from .drawing import render_run
from .passes import write_passes
from .plots import plot_steps
from .renderer import Renderer
from .video import encode

__all__ = [
    "Camera",
    "Curves",
    "RenderOptions",
    "Renderer",
    "encode",
    "fitted_camera",
    "plot_steps",
    "read_camera",
    "render_run",
    "turntable",
    "write_passes",
    "write_png",
]


def __dir__() -> list[str]:
    return __all__
