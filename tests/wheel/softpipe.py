"""Draws pictures of a scene, to compare softpipe (a software renderer of Mesa) with other drivers.

python tests/wheel/softpipe.py pictures.npz
"""

from __future__ import annotations

import sys
from pathlib import Path

import loomstone as ls
import numpy as np

# Largest fraction of pixels that may differ by more than 2/255. Where an edge passes through a
# sample, drivers may round the edge to either side of the sample. The bound is ten times the
# fraction of such pixels that docs/wheel.md reports.
ROUNDED = 2e-4


def scene() -> ls.Scene:
    mesh = ls.grid(size=(0.4, 0.4), cells=(12, 12)).moved((0.0, 0.0, 0.11))
    return ls.Scene(
        cloths=[ls.Cloth(mesh=mesh, material=ls.fabrics["cotton"])],
        obstacles=[ls.sphere(radius=0.1), ls.floor(height=-0.15)],
    )


def pictures() -> dict[str, np.ndarray]:
    """Returns two pictures of the scene at 0.16 s, by name."""
    simulation = ls.Simulation(scene(), integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
    frames = list(simulation.frames(duration=0.16, rate=12.5))
    plain = ls.RenderOptions(width=320, height=240)
    looks = {"weave": plain, "stretch": plain.replace(color_by="stretch")}
    found = {}
    for name, look in looks.items():
        renderer = ls.pictures.Renderer(simulation.topology, look)
        renderer.fit(frames[0])
        found[name] = renderer.render(frames[-1])
    return found


def differences(one: Path, other: Path) -> dict[str, float]:
    """Returns the share of pixels that differ by more than 2/255, for each picture."""
    a, b = np.load(one), np.load(other)
    return {
        name: float((abs(a[name].astype(int) - b[name]).max(axis=2) > 2).mean()) for name in a.files
    }


if __name__ == "__main__":
    np.savez(sys.argv[1], **pictures())
