"""Bodies magnetised by the field around them: soft iron, para- and diamagnets, superconductors.

`soft_sphere`, `soft_cuboid`, `soft_cylinder` and `soft_mesh` return a `SoftBody`, which has a pose
like a magnet. `induce` magnetises such bodies and returns them as magnets.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple

from numpy.typing import ArrayLike

from .. import _core
from .._core import MagneticBody, SoftBody, TriangleMesh
from ..base.arguments import takes
from .sources import Bodies, as_list

__all__ = ["Induced", "induce", "soft_cuboid", "soft_cylinder", "soft_mesh", "soft_sphere"]


class Induced(NamedTuple):
    """Magnetised bodies in the given order, with the relative residual of the linear system and
    the total number of GMRES iterations. For a single body and for the explicit response, residual
    and iterations are 0.
    """

    bodies: list[MagneticBody]
    residual: float
    iterations: int


@takes(radius="m", susceptibility="1", saturation="T")
def soft_sphere(
    *, radius: float, susceptibility: float, saturation: float = 0.0, degree: int = 0
) -> SoftBody:
    """Magnetisable sphere: radius [m], susceptibility chi = mu_r - 1 [1], at least -1 and not 0.

    chi = inf is ideal iron, and chi = -1 is a superconductor. The response is exact for solid
    harmonics up to `degree`. With degree 0, `induce` chooses the degree (up to 400) from its
    tolerance and the distance of other bodies, whereas scenes use degree 1, a point dipole.
    saturation: mu0 M_s [T], 0: none; see `induce`.
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
    cells: int = 16,
    focus: float = 0.0,
    threads: int = 0,
) -> SoftBody:
    """Magnetisable cuboid with edges `size` (3) [m].

    susceptibility: chi = mu_r - 1 [1], at least -1 and not 0. chi = inf is ideal iron, and chi = -1
    is a superconductor. saturation: mu0 M_s [T], 0: none; see `induce`.

    cells: number of panels of the finest grid along the shortest edge, a multiple of 4 from 8 to
    48. Longer edges can have more panels (an edge ten times as long: up to four times as many).
    Panels are finer towards the edges, where the charge is singular. The responses of three grids
    are extrapolated. If the edges are in a ratio of at most 10 : 5 : 1 and the gap to the magnet is
    at least a tenth of the shortest edge, the relative error of force and torque is below 1e-3 with
    16 cells and 1e-4 with 24. The median errors are 1e-5 with 16 cells and 4e-6 with 24, and
    `force` estimates the error of each result. Between flat cuboids that magnetise each other, the
    error with 16 cells reaches 2.2e-3 at a gap of 0.1 times the shortest edge, and is below 1e-3 at
    gaps of at least 0.3 times this edge. If edges have larger ratios, panels grow towards the
    middle, and a magnet there requires a focus. threads as in the function `field`.

    focus [m]: half the width of a magnet near the middle of the wide faces, where panels are
    refined; 0: no refinement. With a focus, all edges have `cells` panels, and two grids are
    extrapolated. Magnets may touch the body. The image force on a magnet above a plate five times
    as wide is accurate to 0.2 % with 12 cells and a focus, at gaps of up to a third of the magnet's
    width.

    The linear system is factored here, for all poses and fields. With saturation, `induce` factors
    it again several times. With 16 cells, factoring takes 0.04 s and 10 MB for a cube, and 2.6 s
    and 0.3 GB for edges 10 : 5 : 1 (24 cells: 23 s and 1.2 GB). Flat cuboids that magnetise each
    other take long: for two cuboids with edges 3 : 2 : 0.4 at a gap of a tenth of the shortest
    edge, `induce` takes 0.9 s with 8 cells and 4 s with 16. Raises InvalidInput for more than
    24,000 panels; edges 10 : 5 : 1 exceed this number with more than 24 cells.
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
    """Magnetisable cylinder about the z axis, or a ring if inner_radius > 0; lengths in [m].

    susceptibility: chi = mu_r - 1 [1], at least -1 and not 0.
    saturation: mu0 M_s [T], 0: none; see `induce`.

    cells: number of rows of panels of the finest grid along the side, a multiple of 4 from 8 to 24
    (slender cylinders have up to eight times as many). A row of the side has four times `cells`
    panels. Panels are finer towards the rims, where the charge is singular. The responses of three
    grids are extrapolated. With 8 cells, the relative error of the moment is 1e-4 if height and
    diameter are about equal. It is 1e-3 if one of them is ten times the other, or if the wall of a
    ring is half its radius. It reaches 5e-2 (2e-3 with 20 cells) if the height or the wall is a
    tenth of the radius or less. threads as in the function `field`.

    Raises Unsupported if the height or the wall is less than a fiftieth of the radius, and
    InvalidInput for more than 8,000 panels. The linear system is factored here, for all poses and
    fields. With saturation, `induce` factors it again several times.
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
    """Magnetisable body bounded by a closed `TriangleMesh` [m].

    susceptibility: chi = mu_r - 1 [1], at least -1 and not 0.

    The triangles are bisected until there are at least `panels` of them. Raises InvalidInput if
    `panels` or the number of triangles of the mesh exceeds 8000. The linear system is factored
    here, for all poses and fields. With saturation, `induce` factors it again several times. The
    error of round bodies is about proportional to 1 / panels. With sharp edges it decreases more
    slowly: the moment of a cube with 1,600 panels has an error of 1.5 %. The centre of the body is
    the centroid of its volume. saturation: mu0 M_s [T], 0: none; see `induce`. threads as in the
    function `field`.
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
    """Magnetises bodies by magnets and currents, by a uniform field and by one another.

    by: magnets and currents. field (3): uniform flux density [T]. tolerance [1]: relative residual
    of the linear system. For spheres with degree 0, the degree is chosen so that it causes a
    relative error of about `tolerance` in the force. The returned bodies have fields and forces
    like magnets. The uniform field also exerts the torque moment x B on them, which the function
    `force` does not include. The axes of returned spheres may differ from those given. Inside a
    body with panels, the function `field` leaves out the body's magnetisation mu0 M from B: the
    body contributes only mu0 H of its charge.

    The volume means of M and H in a body with saturation J_s = mu0 M_s obey M = chi H / (1 + chi
    |H| / M_s), as if its susceptibility were chi (1 - |M| / M_s) everywhere.

    response "explicit": the method of [Thomaszewski2010]. Dipole cells of `density` [1/m^3] respond
    to `by` and `field` alone, as isolated spheres do; those of a superconductor respond with M = -B
    / mu0. For chi >> 1, the force of a cube magnet on a soft cube of equal size with 8 x 8 x 8
    cells is 12 % too large at a gap of one edge, and 37 % at a gap of a quarter of an edge.

    threads 0: OMP_NUM_THREADS or all processors; the result does not depend on it. The mutual
    response raises InvalidInput if bodies overlap or density is not 0, and SolverFailure if no
    equilibrium is found. The explicit response raises InvalidInput for bodies with saturation.

    >>> import loomstone as ls
    >>> ball = ls.magnetics.soft_sphere(radius=0.01, susceptibility=1000)
    >>> magnet = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    >>> magnet = magnet.moved((0, 0, 0.02))
    >>> induced = ls.magnetics.induce(ball, by=magnet)
    >>> print(f"{ls.magnetics.force(on=induced.bodies[0], by=magnet).force[2]:.3f} N")
    1.314 N
    """
    bodies = list(soft) if isinstance(soft, Iterable) else [soft]
    for body in bodies:
        if not isinstance(body, SoftBody):
            raise TypeError(
                "bodies that magnetise are expected, such as soft_cuboid() or soft_sphere(), got"
                f" {body!r}; magnets belong in `by`"
            )
    if response == "explicit":
        return Induced(
            [_core.explicit_response(body, density, as_list(by), field) for body in bodies], 0.0, 0
        )
    if response != "mutual":
        raise _core.InvalidInput(f'response must be "mutual" or "explicit", got "{response}"')
    if density != 0.0:
        raise _core.InvalidInput(
            f"density must be 0 [1/m^3] without the explicit response, got {density}; leave it out"
        )
    return Induced(*_core.induce(bodies, as_list(by), field, tolerance, threads))
