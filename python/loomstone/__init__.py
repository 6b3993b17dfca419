"""Cloth, collisions and rigid bodies: described, simulated, stored and rendered.

SI units everywhere.

>>> import loomstone as ls
>>> scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), triangles=200), pins=[0])])
>>> sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3))
>>> for frame in sim.frames(duration=0.04, rate=25):
...     print(f"{frame.time:.2f} s")
0.00 s
0.04 s
"""

from . import collision, garments, limits, magnetics, meshes
from ._core import (
    Air,
    Attachment,
    Bearing,
    CacheError,
    Camera,
    Checkpoint,
    Cloth,
    ClothMaterial,
    Coil,
    Communicator,
    Error,
    Frame,
    FrameTopology,
    IntegratorOptions,
    InvalidInput,
    LimitOptions,
    Magnet,
    MassProperties,
    Obstacle,
    Renderer,
    RenderOptions,
    RigidBody,
    Scene,
    SolverFailure,
    SpatialQuery,
    State,
    StepReport,
    StrainLimit,
    TriangleMesh,
    Unsupported,
    __version__,
    intersecting_pairs,
    launched_by_mpi,
    mass_properties,
    mpi_communicator,
    single_communicator,
    write_png,
)
from .runs.cache import Run
from .meshes.decomposition import convex_parts
from .fabrics.curve_fit import fit_fabric
from .fabrics.fabric import Fabric, fabric_of_levels
from .garments import garment
from .integrators import (
    BDF2,
    BackwardEuler,
    ExplicitEuler,
    ImplicitMidpoint,
    SemiImplicitEuler,
    SymplecticEuler,
)
from .meshes.shapes import grid, read_mesh, write_mesh
from .obstacles.shapes import box, capsule, floor, funnel, obstacle, sphere, wave_bar
from .fabrics.rigidity import bending_from_strips, strip_rigidity
from .obstacles.sequences import obstacle_sequence
from .simulation import Simulation
from .units import Quantity, units
from .versions import show_versions
from .fabrics import measurements
from .fabrics.fabric import fabrics
from .base import pickling  # noqa: F401

__all__ = [
    "BDF2",
    "Air",
    "Attachment",
    "BackwardEuler",
    "Bearing",
    "CacheError",
    "Camera",
    "Checkpoint",
    "Cloth",
    "ClothMaterial",
    "Coil",
    "Communicator",
    "Error",
    "ExplicitEuler",
    "Fabric",
    "Frame",
    "FrameTopology",
    "ImplicitMidpoint",
    "IntegratorOptions",
    "InvalidInput",
    "LimitOptions",
    "Magnet",
    "MassProperties",
    "Obstacle",
    "Quantity",
    "RenderOptions",
    "Renderer",
    "RigidBody",
    "Run",
    "Scene",
    "SemiImplicitEuler",
    "Simulation",
    "SolverFailure",
    "SpatialQuery",
    "State",
    "StepReport",
    "StrainLimit",
    "SymplecticEuler",
    "TriangleMesh",
    "Unsupported",
    "__version__",
    "bending_from_strips",
    "box",
    "capsule",
    "collision",
    "convex_parts",
    "fabric_of_levels",
    "fabrics",
    "fit_fabric",
    "floor",
    "funnel",
    "garment",
    "garments",
    "grid",
    "intersecting_pairs",
    "launched_by_mpi",
    "limits",
    "magnetics",
    "mass_properties",
    "measurements",
    "meshes",
    "mpi_communicator",
    "obstacle",
    "obstacle_sequence",
    "read_mesh",
    "show_versions",
    "single_communicator",
    "sphere",
    "strip_rigidity",
    "units",
    "wave_bar",
    "write_mesh",
    "write_png",
]
