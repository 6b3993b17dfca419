"""Simulation of cloth, collisions, rigid bodies and magnets, with storage and rendering.

Quantities are in SI units, unless another unit is stated.

>>> import loomstone as ls
>>> scene = ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), triangles=200), pins=[0])])
>>> sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3))
>>> for frame in sim.frames(duration=0.04, rate=25):
...     print(f"{frame.time:.2f} s")
0.00 s
0.04 s
"""

from typing import TYPE_CHECKING, Any

from .base import interruption  # noqa: F401  # imported first, to catch Ctrl-C during the rest

# isort: split
from .base import waiting  # noqa: F401  # precedes the core, because it sets how threads wait

# isort: split
from .base import explained  # noqa: F401  # must precede modules that import functions of the core

# isort: split
from . import collision, garments, limits, magnetics, meshes, obstacles, pictures, ranks, viewer
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
    Error,
    Frame,
    FrameTopology,
    InvalidInput,
    LimitOptions,
    Look,
    Magnet,
    Obstacle,
    RenderOptions,
    RigidBody,
    Scene,
    SolverFailure,
    State,
    StepReport,
    StrainLimit,
    TriangleMesh,
    Unsupported,
    __version__,
)
from .base import pickling  # noqa: F401
from .base.cautions import SceneWarning
from .fabrics.curve_fit import fit as fit_fabric
from .garments import garment
from .integrators import (
    BDF2,
    Asynchronous,
    BackwardEuler,
    ExplicitEuler,
    ImplicitMidpoint,
    Integrator,
    NonlinearMidpoint,
    SemiImplicitEuler,
    SymplecticEuler,
)
from .meshes import grid
from .obstacles import capsule, floor, sphere
from .runs.cache import Run
from .simulation import Simulation
from .versions import show_versions

if TYPE_CHECKING:
    from .base.registry import units
    from .fabrics.room import FabricsRoom

    fabrics: FabricsRoom
else:
    from . import fabrics

__all__ = [
    "BDF2",
    "Air",
    "Asynchronous",
    "Attachment",
    "BackwardEuler",
    "Bearing",
    "CacheError",
    "Camera",
    "Checkpoint",
    "Cloth",
    "ClothMaterial",
    "Coil",
    "Error",
    "ExplicitEuler",
    "Frame",
    "FrameTopology",
    "ImplicitMidpoint",
    "Integrator",
    "InvalidInput",
    "LimitOptions",
    "Look",
    "Magnet",
    "NonlinearMidpoint",
    "Obstacle",
    "RenderOptions",
    "RigidBody",
    "Run",
    "Scene",
    "SceneWarning",
    "SemiImplicitEuler",
    "Simulation",
    "SolverFailure",
    "State",
    "StepReport",
    "StrainLimit",
    "SymplecticEuler",
    "TriangleMesh",
    "Unsupported",
    "__version__",
    "capsule",
    "collision",
    "fabrics",
    "fit_fabric",
    "floor",
    "garment",
    "garments",
    "grid",
    "limits",
    "magnetics",
    "meshes",
    "obstacles",
    "pictures",
    "ranks",
    "show_versions",
    "sphere",
    "units",
    "viewer",
]


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> Any:
    if name != "units":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .base.registry import units  # a late import, because Pint loads slowly

    globals()["units"] = units
    return units
