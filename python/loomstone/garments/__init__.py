"""Garments: flat panels, seams between their edges, and sewn meshes whose uv are the pattern.

Lengths are in metres.

>>> import loomstone as ls
>>> dress = ls.garments.dress(triangles=1500)
>>> len(dress.panel_names), len(dress.openings())
(13, 4)
"""

from dataclasses import replace

from .closing import close_seams
from .edges import Edge, arc, circle, cubic, line, polyline, quadratic
from .garmentcode import read_garmentcode
from .panel import Panel
from .placement import Cone, Cylinder, Placement, Plane, Ribbon
from .seams import Pattern, Seam
from .sewing import Garment, garment
from .sewn_meshes import read, sewn
from .strap_dress import dress, dress_pattern
from .t_shirt import tshirt, tshirt_pattern

__all__ = [
    "Cone",
    "Cylinder",
    "Edge",
    "Garment",
    "Panel",
    "Pattern",
    "Placement",
    "Plane",
    "Ribbon",
    "Seam",
    "arc",
    "circle",
    "close_seams",
    "cubic",
    "dress",
    "dress_pattern",
    "garment",
    "line",
    "polyline",
    "quadratic",
    "read",
    "read_garmentcode",
    "replace",
    "sewn",
    "tshirt",
    "tshirt_pattern",
]


def __dir__() -> list[str]:
    return __all__
