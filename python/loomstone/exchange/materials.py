"""Writes the colours and textures of surfaces as materials of OBJ files (.mtl).

The format does not define a colour space. Colours are written in linear RGB, as Blender writes and
reads them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .surfaces import Surface, png_bytes

__all__ = ["library_name", "material_ranges", "write_materials"]


def library_name(surface: Surface) -> str:
    """Returns the name of the .mtl file that write_materials writes."""
    return f"{surface.identifier}.mtl"


def material_ranges(surface: Surface) -> list[tuple[int, str]]:
    """Returns the ranges of consecutive triangles that have the same material.

    Each range is a pair: the index of its first triangle, and the name of the material. A name
    appears again if the triangles of its material are not in one range.
    """
    changes = np.flatnonzero(np.diff(surface.material, prepend=-1))
    return [(int(i), _name(surface, int(surface.material[i]))) for i in changes]


def write_materials(directory: Path, surface: Surface) -> list[Path]:
    """Writes NAME.mtl and, for a surface with a texture, NAME.png; returns their paths.

    NAME is the identifier of the surface.
    """
    lines = ["# written by loomstone; colours in linear RGB"]
    image = directory / f"{surface.identifier}.png"
    written = [directory / library_name(surface)]
    for number, color in enumerate(surface.colors):
        textured = surface.texture is not None and number == 0
        # Programs may multiply the image by the colour, so a textured material is white.
        shown = np.ones(3) if textured else color
        lines.append(f"newmtl {_name(surface, number)}")
        lines.append("Kd " + " ".join(f"{channel:.6g}" for channel in shown))
        lines.append(f"Pr {surface.roughness:.6g}")
        if textured:
            lines.append(f"map_Kd {image.name}")
    written[0].write_text("\n".join(lines) + "\n", encoding="ascii")
    if surface.texture is not None:
        image.write_bytes(png_bytes(surface.texture))
        written.append(image)
    return written


def _name(surface: Surface, number: int) -> str:
    return f"{surface.identifier}_{number}"
