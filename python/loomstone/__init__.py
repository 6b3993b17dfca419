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

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .base import interruption  # noqa: F401  # imported first, to catch Ctrl-C during the rest

# isort: split
from .base import waiting  # noqa: F401  # precedes the core, because it sets how threads wait

# isort: split
from .base import explained  # noqa: F401  # must precede modules that import functions of the core

# isort: split
from . import collision, limits, magnetics, meshes, obstacles, pictures, ranks
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
    from . import garments, viewer
    from .base.registry import units
    from .fabrics.curve_fit import fit as fit_fabric
    from .fabrics.room import FabricsRoom
    from .garments import garment

    fabrics: FabricsRoom

# Modules that load when they are first used, so that commands start quickly. For an object of a
# module, its name in the module follows.
_LATE = {
    "fabrics": (".fabrics", ""),
    "fit_fabric": (".fabrics.curve_fit", "fit"),
    "garment": (".garments", "garment"),
    "garments": (".garments", ""),
    "units": (".base.registry", "units"),
    "viewer": (".viewer", ""),
}

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
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    path, inside = _LATE[name]
    module = import_module(path, __name__)
    found = getattr(module, inside) if inside else module
    globals()[name] = found
    return found
