"""Pictures that notebooks show for a Scene, a Frame, a Run and a Garment (`_repr_png_`)."""

from __future__ import annotations

import tempfile
import weakref
from pathlib import Path

from .. import _core
from .._core import Camera, Error, Frame, FrameTopology, RenderOptions, Scene
from .renderer import Renderer

__all__ = ["picture_of_frame", "picture_of_scene", "remember"]

# Topologies of frames from simulations and runs. A Frame does not contain its topology.
_topologies: weakref.WeakKeyDictionary[Frame, FrameTopology] = weakref.WeakKeyDictionary()


def remember(frame: Frame, topology: FrameTopology) -> Frame:
    """Records the topology of a frame, so that a notebook can draw the frame; returns the frame."""
    _topologies[frame] = topology
    return frame


def picture_of_frame(frame: Frame, topology: FrameTopology | None = None) -> bytes | None:
    """Returns a picture (PNG) of a frame; None if its topology is unknown or drawing fails.

    topology : topology of the frame; None: the one recorded by `remember`, if any
    """
    known = topology or _topologies.get(frame)
    if known is None:
        return None
    options = RenderOptions(width=640, height=480, camera=Camera())
    try:
        pixels = Renderer(known, options).render(frame)
    except Error:  # for example without an OpenGL library; the notebook shows text
        return None
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "picture.png"
        _core.write_png(str(path), pixels)
        return path.read_bytes()


def picture_of_scene(scene: Scene) -> bytes | None:
    """Returns a picture (PNG) of the start of a scene; None if simulation or drawing fails."""
    try:
        simulation = _core.Simulation(scene, threads=1)
    except Error:
        return None
    return picture_of_frame(simulation.frame(), simulation.topology)


Frame._repr_png_ = picture_of_frame  # type: ignore[attr-defined]
Scene._repr_png_ = picture_of_scene  # type: ignore[attr-defined]
