"""Field, gradient and potential of sources."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base.arguments import takes
from .sources import Bodies, as_list

__all__ = ["field", "gradient", "potential"]

Floats = NDArray[np.float64]


@takes(points="m")
def field(
    bodies: Bodies, points: ArrayLike, *, quantity: Literal["B", "H"] = "B", threads: int = 0
) -> Floats:
    """Returns the field of one body, or the sum over several bodies.

    points (n, 3) [m] in world axes. Returns (n, 3): flux density B [T], or field strength H [A/m].
    Inside magnets of polarization J, B = mu0 H + J. Points on a surface are treated as outside. On
    edges and wires the field is infinite; points closer to them than 1e-15 times the radius of the
    source (1e-12 for cylinders and solenoids) are treated as if they were at that distance. A
    dipole contributes nothing at its own point. threads 0: OMP_NUM_THREADS or all processors; the
    result does not depend on it. Raises InvalidInput if points are not finite or not (n, 3), or if
    quantity is neither "B" nor "H".

    >>> import loomstone as ls
    >>> loop = ls.magnetics.loop(radius=1, current=2)
    >>> ls.magnetics.field(loop, [[0, 0, 0]], quantity="H").tolist()
    [[0.0, 0.0, 1.0]]
    """
    return _core.magnetic_field(as_list(bodies), points, quantity, threads)


@takes(points="m")
def gradient(bodies: Bodies, points: ArrayLike, *, threads: int = 0) -> Floats:
    """Returns the gradient of the field of one body, or the sum over several bodies.

    points (n, 3) [m] in world axes. Returns (n, 3, 3), where [k, i, j] = mu0 dH_i/dx_j [T/m] at
    points[k]. Away from currents and surfaces, this equals dB_i/dx_j. Each matrix is symmetric.
    threads as in `field`. Polylines must be closed.
    """
    return _core.magnetic_gradient(as_list(bodies), points, threads)


@takes(points="m")
def potential(bodies: Bodies, points: ArrayLike, *, threads: int = 0) -> Floats:
    """Returns the scalar potential of hard magnets and dipoles. Its negative gradient is H.

    points (n, 3) [m] in world axes. Returns (n) [A]: the sum over all bodies, which vanishes at
    infinity and is continuous except at dipoles. The relation to H also holds inside magnets.
    threads as in `field`. Raises Unsupported for currents, which have no scalar potential, and for
    bodies with the mutual response of `induce`.

    >>> import loomstone as ls
    >>> ls.magnetics.potential(ls.magnetics.dipoles([[0, 0, 0]], [[0, 0, 1]]), [[0, 0, 0.5]])
    array([0.31830989])
    """
    return _core.magnetic_potential(as_list(bodies), points, threads)
