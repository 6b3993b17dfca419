"""Strain of cloth and strain limiting on arrays, without a scene.

>>> import numpy as np
>>> import loomstone as ls
>>> mesh = ls.grid(size=(1.0, 1.0), cells=(8, 8))
>>> pulled = np.asarray(mesh.vertices) * (1.3, 1.0, 1.0)
>>> bool(np.allclose(ls.limits.strain(pulled, mesh), (0.3, 0.0, 0.0)))
True
>>> points, report = ls.limits.limit(pulled, mesh, ls.StrainLimit(0.1, 0.1, 0.2))
>>> report.beyond, bool(ls.limits.strain(points, mesh)[:, :2].max() <= 0.1 + 0.002)
(0, True)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import (
    LimitOptions,
    LimitReport,
    StrainLimit,
    TriangleMesh,
    corotational_strain,
    limit_strain,
)
from .base.arguments import takes

if TYPE_CHECKING:
    from ._core import LimitMethod

__all__ = ["LimitReport", "limit", "strain"]

_D = LimitOptions()


def __dir__() -> list[str]:
    return __all__


@takes(points="m")
def strain(
    points: ArrayLike, mesh: TriangleMesh, *, rest: Literal["uv", "mesh"] = "uv", threads: int = 0
) -> NDArray[np.float64]:
    """Returns the co-rotational strain U - I [1] of each triangle, (m, 3): weft, warp and shear.

    For small strains, the shear e12 is half the engineering shear.

    points : (n, 3) positions of the mesh vertices [m]
    rest : source of the rest lengths: "uv" (the pattern [m]) or "mesh"
    threads : number of threads; 0: OMP_NUM_THREADS or all processors
    """
    return corotational_strain(points, mesh, rest=rest, threads=threads)


@takes(points="m", masses="kg", tolerance="1")
def limit(
    points: ArrayLike,
    mesh: TriangleMesh,
    strain_limit: StrainLimit,
    *,
    masses: ArrayLike | None = None,
    fixed: Sequence[int] = (),
    method: LimitMethod = _D.method,
    tolerance: float = _D.tolerance,
    max_sweeps: int = _D.max_sweeps,
    active_set: bool = _D.active_set,
    seed: int = _D.seed,
    rest: Literal["uv", "mesh"] = "uv",
    threads: int = 0,
) -> tuple[NDArray[np.float64], LimitReport]:
    """Moves points until no triangle exceeds the strain limit by more than the tolerance.

    Stops after `max_sweeps` sweeps at the latest. With method="edges", or if strain_limit.edge is
    given, limits the elongation of edges instead of the strain of triangles.

    Returns the new points (n, 3) [m] and a LimitReport, which contains the remaining excess of
    triangles.

    points : (n, 3) positions of the mesh vertices [m]
    masses : (n,) masses of the vertices [kg]; None: for each vertex, a third of the mass of the
        triangles around it, at 1 kg/m^2 of rest area
    fixed : indices of the vertices that do not move
    method, tolerance, max_sweeps, active_set, seed : as in LimitOptions
    rest, threads : as in strain()
    """
    options = LimitOptions(
        method=method, tolerance=tolerance, max_sweeps=max_sweeps, active_set=active_set, seed=seed
    )
    return limit_strain(
        points,
        mesh,
        strain_limit,
        masses=masses,
        fixed=list(fixed),
        options=options,
        rest=rest,
        threads=threads,
    )
