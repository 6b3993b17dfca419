"""Cases of the digests: all scene files at small size, and a falling sheet with all integrators and
with several variants of options.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile

SCENES = Path(__file__).resolve().parents[2] / "scenes"
Case = tuple[ls.Scene, ls.Integrator]

# Parameters of each scene file, for at most 2,000 triangles in each cloth. A colon in a key
# precedes the name of a variant.
SMALL: dict[str, dict[str, object]] = {
    "bending": {"triangles": 800},
    "bin": {"triangles": 150, "towels": 6},
    "card": {"triangles": 512, "boxes": 5},
    "clasp": {"triangles": 512},
    "disc": {"triangles": 1200},
    "dragon": {"spheres": 30, "cells": 300},
    "dragon:accurate": {"spheres": 12},
    "drape": {"triangles": 1800},
    "dress": {"triangles": 1500},
    "field_lines": {},
    "figures": {"figures": 2, "balls": 8},
    "figures:explicit": {"figures": 2, "balls": 8, "response": "explicit"},
    "flag": {"triangles": 1800},
    "fold": {"triangles": 800, "layers": 4},
    "funnel": {"triangles": 1800},
    "halbach": {"cubes": 5},
    "hanging": {"triangles": 1800},
    "incline": {"triangles": 128},
    "knot": {"triangles": 1800},
    "levitation": {},
    "levitation:cube": {"shape": "cube"},
    "lift": {},
    "limit_scaling": {"triangles": 1800},
    "motor": {},
    "obstacle_walk": {"triangles": 1200},
    "plunger": {},
    "pull": {"cells": 8},
    "ribbon": {"triangles": 800},
    "sphere_slide": {"triangles": 1800},
    "stack": {"triangles": 162, "sheets": 6},
    "swing": {"columns": 21, "rows": 29},
    "swing_integrators": {"triangles": 1000},
    "swing_limits": {"triangles": 1400},
    "table_cloth": {"triangles": 1200},
    "toy_magnets": {},
    "toy_magnets:parallel": {"case": "parallel"},
    "toy_magnets:free": {"case": "free"},
    "twist": {"triangles": 1800},
    "uneven": {"triangles": 600},
    "voice_coil": {"triangles": 800},
    "wave_bar": {"triangles": 1800},
}

INTEGRATORS: dict[str, ls.Integrator] = {
    "explicit": ls.ExplicitEuler(step=2e-5),
    "symplectic": ls.SymplecticEuler(step=1e-4),
    "semi-pcg": ls.SemiImplicitEuler(step=4e-3, linear_solver="pcg"),
    "semi-block-jacobi": ls.SemiImplicitEuler(step=4e-3, linear_solver="block-jacobi"),
    "semi-gauss-seidel": ls.SemiImplicitEuler(step=4e-3, linear_solver="gauss-seidel"),
    "semi-direct": ls.SemiImplicitEuler(step=4e-3, linear_solver="direct"),
    "semi-exact": ls.SemiImplicitEuler(step=4e-3, jacobian="exact"),
    "semi-bending": ls.SemiImplicitEuler(step=4e-3, bending="implicit"),
    "backward": ls.BackwardEuler(step=4e-3),
    "midpoint": ls.ImplicitMidpoint(step=2e-3),
    "nonlinear-midpoint": ls.NonlinearMidpoint(step=2e-3),
    "bdf2": ls.BDF2(step=2e-3),
    "asynchronous": ls.Asynchronous(),
    "asynchronous-queue": ls.Asynchronous(schedule="queue"),
}


def falling(
    *,
    limit: ls.StrainLimit | None = None,
    limits: ls.LimitOptions | None = None,
    response: str = "implicit",
    bending: str = "mid-edge",
) -> ls.Scene:
    """Returns a scene in which a sheet meets a sphere in the first steps.

    A box falls on the sheet, and a floor lies below.
    """
    mesh = ls.grid(size=(0.3, 0.3), triangles=450).moved((0, 0, 0.1015))
    cotton = ls.ClothMaterial(
        weft_stiffness=200,
        warp_stiffness=300,
        shear_stiffness=60,
        density=0.2,
        bending_weft=1e-5,
        bending_warp=2e-5,
    )
    cloth = ls.Cloth(
        name="c",
        mesh=mesh,
        material=cotton,
        friction=0.4,
        strain_limit=limit,
        velocities=np.tile((0.3, 0.0, -1.0), (len(mesh.vertices), 1)),
        bending=bending,
    )
    box = ls.RigidBody(
        name="b",
        mesh=ls.meshes.box(size=(0.03, 0.03, 0.03)),
        density=300,
        position=(0.05, 0.02, 0.14),
    )
    scene = ls.Scene(
        cloths=[cloth],
        obstacles=[ls.sphere(radius=0.1, friction=0.5), ls.floor(height=-0.1)],
        bodies=[box],
        response=response,
    )
    return scene if limits is None else scene.replace(limits=limits)


def variants() -> dict[str, Callable[[], Case]]:
    limit, euler = ls.StrainLimit(0.03, 0.05, 0.1), ls.SemiImplicitEuler(step=4e-3)
    made: dict[str, Callable[[], Case]] = {
        f"limits-{method}": lambda m=method: (  # type: ignore[misc]
            falling(limit=limit, limits=ls.LimitOptions(method=m)),
            euler,
        )
        for method in ("gauss-seidel", "gauss-seidel-random", "jacobi", "edges")
    }
    long, short = ls.SemiImplicitEuler(step=2e-2), ls.SymplecticEuler(step=1e-4)
    tight, after = ls.StrainLimit(0.01, 0.01, 0.02), ls.LimitOptions(in_solve=False)
    return made | {
        "limits-after": lambda: (falling(limit=limit, limits=after), euler),
        "limits-long": lambda: (falling(limit=tight), ls.SemiImplicitEuler(step=1.6e-2)),
        "impulse": lambda: (falling(response="impulse"), euler),
        "impulse-limits": lambda: (falling(response="impulse", limit=limit), euler),
        "hinge": lambda: (falling(bending="hinge"), euler),
        "hinge-bdf2": lambda: (falling(bending="hinge"), ls.BDF2(step=4e-3, bending="implicit")),
        "long-steps": lambda: (falling(), long),
        "bdf2-long": lambda: (falling(), ls.BDF2(step=2e-2)),
        "newton-limits": lambda: (falling(limit=limit), ls.BackwardEuler(step=8e-3)),
        "explicit-limits": lambda: (falling(limit=limit), short),
    }


def of_scene(name: str) -> Case:
    file = SceneFile.open(SCENES / f"{name.split(':')[0]}.py", SMALL[name])
    return file.scene(), file.integrator


def cases() -> Iterator[tuple[str, Callable[[], Case]]]:
    for name in SMALL:
        yield name, lambda name=name: of_scene(name)  # type: ignore[misc]
    for name, integrator in INTEGRATORS.items():
        yield f"falling/{name}", lambda i=integrator: (falling(), i)  # type: ignore[misc]
    for name, make in variants().items():
        yield f"falling/{name}", make
