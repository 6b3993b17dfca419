"""Reads patterns of GarmentCode (pygarment): JSON with panels, edges, stitches and placements.

The format is that of [Korosteleva2023]. The unit of length is (1 / units_in_meter) m, y points up,
and rotations are in degrees about the fixed axes x, y and z, in this order. Control points of
curved edges are given along and across the chord, relative to its length, unless the file sets
curvature_coords to "absolute". No code of GarmentCode is used or needed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import CacheError, InvalidInput
from ..base.arguments import takes
from .edges import Edge, cubic, line, quadratic
from .panel import Panel
from .placement import Plane, Vector
from .seams import Pattern, Seam

__all__ = ["read_garmentcode"]

Floats = NDArray[np.float64]

# Rotates y, which points up in the file, to z. The garment's front, which faces z in the file, then
# faces -y.
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@takes()
def read_garmentcode(path: str | os.PathLike[str]) -> Pattern:
    """Reads panels, seams and placements of a GarmentCode specification.

    Edges are named "edge_0", "edge_1" and so on, by their index in the panel. An edge in two
    stitches would join three layers. It is read, but sewing the pattern raises InvalidInput. Raises
    CacheError if the file cannot be read, and InvalidInput naming the file if its content is
    missing or malformed.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise CacheError(f"{path}: cannot be read: {error}") from error
    except json.JSONDecodeError as error:
        raise InvalidInput(f"{path}: is not JSON: {error}") from error
    try:
        return _pattern(content)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        kind = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
        raise InvalidInput(
            f"{path}: is not a readable GarmentCode pattern: {kind}{error}"
        ) from error


def _pattern(content: Mapping[str, Any]) -> Pattern:
    properties = content.get("properties", {})
    scale = 1.0 / float(properties.get("units_in_meter", 100))
    absolute = properties.get("curvature_coords", "relative") == "absolute"
    pattern = content["pattern"]
    panels = tuple(
        _panel(name, panel, scale, absolute) for name, panel in pattern["panels"].items()
    )
    seams = []
    for stitch in pattern.get("stitches", []):
        first, second = (f"{_name(side['panel'])}.edge_{int(side['edge'])}" for side in stitch[:2])
        # A stitch joins panels whose outsides face the same way. If its third entry is
        # "right_wrong", the outside (right side) of one panel continues the inside of the other.
        seams.append(Seam(first, second, not (len(stitch) > 2 and stitch[2] == "right_wrong")))
    return Pattern(panels, tuple(seams))


def _panel(name: str, panel: Mapping[str, Any], scale: float, absolute: bool) -> Panel:
    vertices = scale * np.array(panel["vertices"], float).reshape(-1, 2)
    edges = [_edge(i, edge, vertices, scale, absolute) for i, edge in enumerate(panel["edges"])]
    rotation = _rotation(panel.get("rotation", (0, 0, 0)))
    origin = UPRIGHT @ (scale * np.array(panel.get("translation", (0, 0, 0)), float))
    across, up = UPRIGHT @ rotation[:, 0], UPRIGHT @ rotation[:, 1]
    # Edges must run counter-clockwise as seen from outside the garment. If they run clockwise, the
    # file shows the panel as seen from inside, so its x axis is reversed.
    outline = np.concatenate([edge.curve()[:-1] for edge in edges])
    x, y = outline.T
    if (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() < 0:
        edges = [Edge(e.name, e.kind, tuple((-a, b) for a, b in e.points)) for e in edges]
        across = -across
    return Panel(
        _name(name), tuple(edges), place=Plane(_vector(origin), _vector(across), _vector(up))
    )


def _edge(
    index: int, edge: Mapping[str, Any], vertices: Floats, scale: float, absolute: bool
) -> Edge:
    name = f"edge_{index}"
    start, end = vertices[list(edge["endpoints"])]
    curvature = edge.get("curvature")
    if not curvature:
        return line(name, start, end)
    if isinstance(curvature, list):  # older files contain just one control point
        curvature = {"type": "quadratic", "params": [curvature]}
    kind, values = str(curvature["type"]), curvature["params"]
    if kind == "circle":
        return _arc(name, start, end, scale * float(values[0]), bool(values[1]), bool(values[2]))
    chord = end - start
    frame = np.array([chord, (-chord[1], chord[0])])
    control = [
        scale * np.array(v, float) if absolute else start + np.array(v, float) @ frame
        for v in values
    ]
    if kind == "quadratic" and len(control) == 1:
        return quadratic(name, start, control[0], end)
    if kind == "cubic" and len(control) == 2:
        return cubic(name, start, control[0], control[1], end)
    raise ValueError(f"{name}: curvature {kind!r} with {len(control)} points is unknown")


def _arc(name: str, start: Floats, end: Floats, radius: float, large: bool, right: bool) -> Edge:
    """Returns an arc from its radius [m] and the two flags of SVG arcs, but with y up.

    If `large`, the arc is longer than a half circle. If `right`, it runs counter-clockwise, and its
    middle lies to the right of the chord.
    """
    chord = end - start
    half = float(np.linalg.norm(chord)) / 2
    if radius < half * (1 - 1e-6):
        raise ValueError(f"{name}: radius {radius:.4g} m is less than half the chord {half:.4g} m")
    sagitta = radius + (1 if large else -1) * np.sqrt(max(0.0, radius**2 - half**2))
    normal = np.array([chord[1], -chord[0]]) / (2 * half)  # points to the right of the chord
    middle = (start + end) / 2 + (1 if right else -1) * sagitta * normal
    points = tuple((float(x), float(y)) for x, y in (start, middle, end))
    return Edge(name, "arc", points)


def _rotation(degrees: Any) -> Floats:
    from scipy.spatial.transform import Rotation

    matrix: Floats = Rotation.from_euler(
        "xyz", np.asarray(degrees, float), degrees=True
    ).as_matrix()
    return matrix


def _vector(v: Floats) -> Vector:
    return float(v[0]), float(v[1]), float(v[2])


def _name(name: str) -> str:
    return str(name).replace(".", "_")
