"""Real fabrics by name, and fabrics made from levels such as "soft" and "stiff".

>>> import loomstone as ls
>>> cotton = ls.fabrics["cotton"]
>>> cloth = ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), triangles=200), material=cotton)
>>> print(f"{cotton.density:g} kg/m^2, {cotton.warp_stiffness:g} N/m along warp")
0.1036 kg/m^2, 3801 N/m along warp

Further functions fit fabrics to measured curves, make fabrics from levels, convert rigidities of
strips and simulate laboratory tests. The numbers and their sources are in table.py. docs/fabrics.md
describes how the numbers were derived, and their limitations.
"""

import sys

from . import measurements
from .curve_fit import fit
from .fabric import Fabric, ModeFit
from .levels import of_levels
from .named_fabrics import catalogue
from .rigidity import bending_from_strips, strip_rigidity
from .room import FabricsRoom

__all__ = [
    "Fabric",
    "ModeFit",
    "bending_from_strips",
    "catalogue",
    "fit",
    "measurements",
    "of_levels",
    "strip_rigidity",
]


def __dir__() -> list[str]:
    return __all__


sys.modules[__name__].__class__ = FabricsRoom
