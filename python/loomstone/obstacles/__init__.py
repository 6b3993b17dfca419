"""Obstacles: surfaces that cloth and bodies collide with.

Obstacles are static, moved by keyframes, or deforming.

>>> import loomstone as ls
>>> ball = ls.obstacles.sphere(radius=0.15)
>>> ball.mesh.closed
True
"""

from .._core import Obstacle
from .baked_motion import baked
from .following import follow
from .sequences import sequence
from .shapes import box, capsule, floor, funnel, mesh, sphere, wave_bar

__all__ = [
    "Obstacle",
    "baked",
    "box",
    "capsule",
    "floor",
    "follow",
    "funnel",
    "mesh",
    "sequence",
    "sphere",
    "wave_bar",
]


def __dir__() -> list[str]:
    return __all__
