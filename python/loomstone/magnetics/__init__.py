"""Magnetic fields, forces and torques, from numpy arrays or from source objects.

All quantities are in SI units: T, A/m, N, N m. Equation numbers refer to [Thomaszewski2010].

>>> import loomstone as ls
>>> a = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
>>> field = ls.magnetics.field(a, [[0, 0, 0.01]])
>>> print(f"{field[0, 2]:.4f} T")
0.1348 T
"""

from .._core import MagneticBody, SoftBody
from .dipole_cells import cell_front, cell_level, cells
from .fields import field, gradient, potential
from .figures import ForceCurve, force_over_distance, plot_curve, plot_slice, torque_over_angle
from .formulas import (
    cuboid_field,
    cuboid_gradient,
    cylinder_field,
    cylinder_gradient,
    dipole_energy,
    dipole_field,
    dipole_forces,
    dipole_gradient,
    loop_field,
    loop_gradient,
    mesh_field,
    mesh_gradient,
    polyline_field,
    polyline_gradient,
    solenoid_field,
    solenoid_gradient,
    sphere_field,
    sphere_gradient,
)
from .interactions import (
    Force,
    Forces,
    energy,
    force,
    forces,
    induced_moments,
    mutual_inductance,
)
from .lines import FieldLines, LineEnd, curves_of, field_lines, frame_curves
from .soft_bodies import Induced, induce, soft_cuboid, soft_cylinder, soft_mesh, soft_sphere
from .sources import cuboid, cylinder, dipoles, loop, mesh, polyline, solenoid, sphere

MU0 = 1.2566370614359173e-06  # 4 pi 1e-7 [T m/A]

__all__ = [
    "MU0",
    "FieldLines",
    "Force",
    "ForceCurve",
    "Forces",
    "Induced",
    "LineEnd",
    "MagneticBody",
    "SoftBody",
    "cell_front",
    "cell_level",
    "cells",
    "cuboid",
    "cuboid_field",
    "cuboid_gradient",
    "curves_of",
    "cylinder",
    "cylinder_field",
    "cylinder_gradient",
    "dipole_energy",
    "dipole_field",
    "dipole_forces",
    "dipole_gradient",
    "dipoles",
    "energy",
    "field",
    "field_lines",
    "force",
    "force_over_distance",
    "forces",
    "frame_curves",
    "gradient",
    "induce",
    "induced_moments",
    "loop",
    "loop_field",
    "loop_gradient",
    "mesh",
    "mesh_field",
    "mesh_gradient",
    "mutual_inductance",
    "plot_curve",
    "plot_slice",
    "polyline",
    "polyline_field",
    "polyline_gradient",
    "potential",
    "soft_cuboid",
    "soft_cylinder",
    "soft_mesh",
    "soft_sphere",
    "solenoid",
    "solenoid_field",
    "solenoid_gradient",
    "sphere",
    "sphere_field",
    "sphere_gradient",
    "torque_over_angle",
]


def __dir__() -> list[str]:
    return __all__
