"""Simulated laboratory tests: Cusick's drape test and the cantilever test of ASTM D1388.

>>> import loomstone as ls
>>> strip = ls.fabrics.measurements.cantilever(ls.fabrics["denim"], angle_degrees=0)
>>> abs(strip.error) < 0.01
True
"""

from .bending_test import CantileverResult, cantilever
from .drape_test import CusickResult, cusick
from .report import FabricReport, report_fabrics
from .rest import Rest, bring_to_rest

__all__ = [
    "CantileverResult",
    "CusickResult",
    "FabricReport",
    "Rest",
    "bring_to_rest",
    "cantilever",
    "cusick",
    "report_fabrics",
]


def __dir__() -> list[str]:
    return __all__
