"""Meshes: generators, files and queries.

Flat cloth lies in z = 0, centred at the origin, with weft along x. Spheres, boxes, capsules and
cylinders are centred at the origin.

>>> import loomstone as ls
>>> ls.meshes.sphere(radius=0.1, subdivisions=2).n_triangles
320
"""

from .._core import MassProperties, SpatialQuery, TriangleMesh, mass_properties
from .decomposition import convex_parts
from .files import read, write
from .flat import disc, grid, irregular, strip
from .queries import nearest_vertices, quality
from .solids import box, capsule, cylinder, floor, funnel, sphere, wave_bar

__all__ = [
    "MassProperties",
    "SpatialQuery",
    "TriangleMesh",
    "box",
    "capsule",
    "convex_parts",
    "cylinder",
    "disc",
    "floor",
    "funnel",
    "grid",
    "irregular",
    "mass_properties",
    "nearest_vertices",
    "quality",
    "read",
    "sphere",
    "strip",
    "wave_bar",
    "write",
]


def __dir__() -> list[str]:
    return __all__
