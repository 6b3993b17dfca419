"""A cloth pinned at two corners swings for a second, with a selectable method of strain limiting.
The scene serves to measure how the cost of limits grows with the number of triangles.

All methods enforce the same limits, except for "none", which sets no limits, and "edges", which
cannot distinguish shear from stretch. With this scene, tests/benchmarks/limits.py measures sweeps
and times, as in table 3.1 of [Thomaszewski2010], and the remaining excess.

    loomstone run scenes/limit_scaling.py -p triangles=3600 -p method=jacobi -p in_solve=false
"""

from typing import Literal

import loomstone as ls

duration = 1.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=4e-3)
render = ls.RenderOptions(camera=ls.Camera(eye=(1.2, -0.9, 0.2)))

LIMITS = (0.1, 0.1, 0.2)

Method = Literal["gauss-seidel", "gauss-seidel-random", "jacobi", "edges", "none"]


def scene(
    triangles: int = 3600,
    method: Method = "gauss-seidel",
    in_solve: bool = True,
    max_sweeps: int = 100,
) -> ls.Scene:
    """method: a value of LimitOptions.method, or "none"; in_solve: whether the implicit solve
    enforces limits before the sweeps do. With "edges", only the sweeps enforce limits.
    """
    mesh = ls.meshes.irregular(size=(0.5, 0.5), triangles=triangles)
    material = ls.ClothMaterial(
        weft_stiffness=500.0,
        warp_stiffness=500.0,
        shear_stiffness=250.0,
        density=0.3,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    cloth = ls.Cloth(
        name="cloth",
        mesh=mesh,
        material=material,
        pins=ls.meshes.nearest_vertices(mesh, [(-0.25, 0.25, 0.0), (0.25, 0.25, 0.0)]),
        strain_limit=None if method == "none" else ls.StrainLimit(*LIMITS),
    )
    limits = ls.LimitOptions(
        method="gauss-seidel" if method == "none" else method,
        in_solve=in_solve,
        max_sweeps=max_sweeps,
    )
    return ls.Scene(cloths=[cloth], limits=limits, collisions=False)


def check(run: ls.Run) -> None:
    assert run[-1].positions[:, 2].mean() < -0.1, "the cloth hangs or swings below its pins"
