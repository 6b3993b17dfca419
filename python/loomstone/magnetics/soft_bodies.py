"""Bodies that magnetise in the field they are in: soft iron, para- and diamagnets, superconductors.

`soft_sphere`, `soft_cuboid`, `soft_cylinder` and `soft_mesh` return a `SoftBody` with poses as
magnets have them; `induce` finds how they magnetise in a field and in one another's, and returns
them as magnets.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

from numpy.typing import ArrayLike

from .. import _core
from .._core import MagneticBody, SoftBody, TriangleMesh
from ..base.arguments import takes
from .sources import Bodies, as_list

__all__ = ["Induced", "induce", "soft_cuboid", "soft_cylinder", "soft_mesh", "soft_sphere"]


class Induced(NamedTuple):
    """Bodies as they are magnetised, in the order given; relative residual of the linear system,
    and its iterations.
    """

    bodies: list[MagneticBody]
    residual: float
    iterations: int


@takes(radius="m", susceptibility="1", saturation="T")
def soft_sphere(
    *, radius: float, susceptibility: float, saturation: float = 0.0, degree: int = 0
) -> SoftBody:
    """Linear sphere: radius [m], susceptibility chi = mu_r - 1 >= -1 [1] (inf: ideal iron, -1:
    superconductor).

    It answers exactly, by solid harmonics up to `degree`; 0: as many as the tolerance of `induce`
    and what is near ask for (up to 400), in scenes 1, a point dipole. saturation mu0 M_s [T],
    0: none; see `induce`.
    """
    return _core.soft_sphere(
        radius=radius, susceptibility=susceptibility, saturation=saturation, degree=degree
    )


@takes(size="m", susceptibility="1", saturation="T", focus="m")
def soft_cuboid(
    *,
    size: ArrayLike,
    susceptibility: float,
    saturation: float = 0.0,
    cells: int = 12,
    focus: float = 0.0,
    threads: int = 0,
) -> SoftBody:
    """Linear cuboid: edges `size` (3) [m], susceptibility chi = mu_r - 1 >= -1 [1] (inf: ideal
    iron, -1: superconductor).

    cells: panels along every edge, a multiple of 4 from 8 to 48; finer towards the edges, where the
    charge is singular. The answers of three grids are extrapolated: moments of cubes err by 2e-4
    with 12 cells, 5e-5 with 20 (9e-5 of superconductors). focus [m]: half the width of what is near
    the middle of wide faces, 0: nothing; panels are finer there then, and two grids are
    extrapolated. Charge varies within panels as the field of magnets does, whose poles may touch:
    one on a plate five times as wide feels the force of its image within 1.5 % with 8 cells, within
    0.2 % with 12 and a focus, at any gap. The equation is factored here, once; poses and fields
    cost no more of it. saturation mu0 M_s [T], 0: none; see `induce`.
    """
    return _core.soft_cuboid(
        size=size,
        susceptibility=susceptibility,
        saturation=saturation,
        cells=cells,
        focus=focus,
        threads=threads,
    )


@takes(radius="m", height="m", susceptibility="1", inner_radius="m", saturation="T")
def soft_cylinder(
    *,
    radius: float,
    height: float,
    susceptibility: float,
    inner_radius: float = 0.0,
    saturation: float = 0.0,
    cells: int = 8,
    threads: int = 0,
) -> SoftBody:
    """Linear cylinder about the z axis: radius and height [m]; inner_radius > 0: a ring;
    susceptibility chi = mu_r - 1 >= -1 [1].

    cells: panels along the side, a multiple of 4 from 8 to 24 (some more of a slender one), twice
    as many around it; finer towards the rims, where the charge is singular. The answers of three
    grids are extrapolated: with 8 cells moments err by 1e-4 where the height is about the diameter,
    by 1e-3 where one is ten times the other or a ring's wall half its radius, by up to 5e-2 (2e-3
    with 20) where height or wall is a tenth of the radius or less. Raises Unsupported below a
    fiftieth. The equation is factored here, once; poses and fields cost no more of it. saturation
    mu0 M_s [T], 0: none; see `induce`.
    """
    return _core.soft_cylinder(
        radius=radius,
        height=height,
        susceptibility=susceptibility,
        inner_radius=inner_radius,
        saturation=saturation,
        cells=cells,
        threads=threads,
    )


@takes(susceptibility="1", saturation="T")
def soft_mesh(
    mesh: TriangleMesh,
    *,
    susceptibility: float,
    saturation: float = 0.0,
    panels: int = 1500,
    threads: int = 0,
) -> SoftBody:
    """Linear body of any shape inside a closed `TriangleMesh` [m]; susceptibility chi = mu_r - 1 >=
    -1 [1].

    The triangles are halved until there are at least `panels` (at most 8000); the equation of all
    of them is factored here, once. The error falls as 1 / panels. The centre is that of the volume.
    saturation mu0 M_s [T], 0: none; see `induce`.
    """
    return _core.soft_mesh(
        mesh, susceptibility=susceptibility, saturation=saturation, panels=panels, threads=threads
    )


@takes(field="T", tolerance="1", density="1/m^3")
def induce(
    soft: SoftBody | Sequence[SoftBody],
    *,
    by: Bodies = (),
    field: ArrayLike = (0.0, 0.0, 0.0),
    tolerance: float = 1e-6,
    response: Literal["mutual", "explicit"] = "mutual",
    density: float = 0.0,
    threads: int = 0,
) -> Induced:
    """How bodies magnetise in the field of others, in a uniform one, and in that of one another.

    by: magnets and currents; field (3): uniform flux density [T]; tolerance [1]: relative residual
    of the linear system, and error that the degree of spheres leaves. The bodies that come back
    give fields and forces as magnets do (a uniform field acts on them by moment x B besides);
    spheres may have been turned. Inside of bodies of panels `field` gives B as mu0 H of their
    charge alone.

    A body with saturation J_s follows M = chi H / (1 + chi |H| / M_s) in its means over the volume,
    as if its susceptibility were chi (1 - |M| / M_s) everywhere.

    response "explicit": the thesis' own way, as dipole cells of `density` [1/m^3] that answer as
    lone spheres do (those of a superconductor with M = -B / mu0), to `by` and `field` alone. It
    errs by a quarter and more for chi >> 1.

    threads 0: all processors; the result does not depend on it. Raises InvalidInput for bodies that
    overlap, and SolverFailure where no equilibrium is found.

    >>> import loomstone as ls
    >>> ball = ls.magnetics.soft_sphere(radius=0.01, susceptibility=1000)
    >>> magnet = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    >>> magnet = magnet.moved((0, 0, 0.02))
    >>> induced = ls.magnetics.induce(ball, by=magnet)
    >>> print(f"{ls.magnetics.force(on=induced.bodies[0], by=magnet).force[2]:.3f} N")
    1.314 N
    """
    bodies = [soft] if isinstance(soft, SoftBody) else list(soft)
    if response == "explicit":
        return Induced(
            [_core.explicit_response(body, density, as_list(by), field) for body in bodies], 0.0, 0
        )
    if response != "mutual":
        raise _core.InvalidInput(f'response must be "mutual" or "explicit", got "{response}"')
    if density != 0.0:
        raise _core.InvalidInput("density belongs to the explicit response; leave it out")
    return Induced(*_core.induce(bodies, as_list(by), field, tolerance, threads))
