"""Estimate of the memory that a run needs, made before the simulation is built."""

from __future__ import annotations

from .._core import Scene
from ..integrators import Integrator

__all__ = ["memory_of", "memory_text"]

# Memory that a run needs [bytes]: PROGRAM for the program itself, OF_CLOTH per triangle of cloth
# (OF_CLOTH_BY_METHOD for some integrators), OF_FACTOR more per triangle of cloth with a direct
# solver, OF_SURFACE per triangle of bodies and obstacles, and twice the size of
# Obstacle.vertex_positions. The constants were measured in the first six steps of drapes of 14,450
# to 200,000 triangles.
PROGRAM = 60e6
OF_CLOTH = 4.1e3
OF_CLOTH_BY_METHOD = {
    "explicit-euler": 3.7e3,
    "symplectic-euler": 3.7e3,
    "asynchronous": 5.0e3,
    "backward-euler": 6.7e3,
    "nonlinear-midpoint": 6.7e3,
}
OF_FACTOR = 3.8e3  # additional memory per triangle of cloth with a direct solver
OF_SURFACE = 0.8e3


def memory_of(scene: Scene, integrator: Integrator) -> float:
    """Returns an estimate of the memory that a run of a scene needs [bytes]."""
    cloth = sum(each.mesh.n_triangles for each in scene.cloths)
    surfaces = sum(each.mesh.n_triangles for each in scene.bodies)
    surfaces += sum(each.mesh.n_triangles for each in scene.obstacles)
    sequences = sum(each.vertex_positions.nbytes for each in scene.obstacles)
    rate = OF_CLOTH_BY_METHOD.get(integrator.method, OF_CLOTH)
    if getattr(integrator, "linear_solver", "") in ("direct", "supernodal"):
        rate += OF_FACTOR
    return PROGRAM + rate * cloth + OF_SURFACE * surfaces + 2.0 * sequences


def memory_text(scene: Scene, integrator: Integrator) -> str:
    """Returns a text about the size of a scene and the memory that a run of it needs."""
    cloth = sum(each.mesh.n_triangles for each in scene.cloths)
    needed = memory_of(scene, integrator)
    text = f"building {cloth} triangles of cloth"
    if scene.bodies:
        text += f" and {len(scene.bodies)} bodies"
    text += f": about {_shown(needed)} of memory"
    available = _available()
    if available is not None and needed > available:
        text += f", more than the {_shown(available)} that are free"
    return text


def _shown(size: float) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"


def _available() -> float | None:
    """Returns the memory that is still free for programs [bytes]; None if it is unknown."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            for line in lines:
                if line.startswith("MemAvailable:"):
                    return 1024.0 * float(line.split()[1])
    except (OSError, ValueError):
        return None
    return None
