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
    """Field of one body or of several together.

    points (n, 3) [m], world axes. Returns (n, 3): flux density B [T], or field strength H [A/m];
    they differ inside magnets, where B = mu0 H + J. A point on a surface gets the value outside. On
    edges and wires, where the field is infinite, it is that 1e-15 of the size beside them. threads
    0: all processors; the result does not depend on it. Raises InvalidInput for points that are not
    finite (n, 3), and other quantities.

    >>> import loomstone as ls
    >>> loop = ls.magnetics.loop(radius=1, current=2)
    >>> ls.magnetics.field(loop, [[0, 0, 0]], quantity="H").tolist()
    [[0.0, 0.0, 1.0]]
    """
    return _core.magnetic_field(as_list(bodies), points, quantity, threads)


@takes(points="m")
def gradient(bodies: Bodies, points: ArrayLike, *, threads: int = 0) -> Floats:
    """Gradient of the field of one body or of several together.

    points (n, 3) [m], world axes. Returns (n, 3, 3), [k, i, j] = mu0 dH_i/dx_j at points[k] [T/m],
    which off currents and surfaces is dB_i/dx_j. Symmetric. threads as in `field`. A polyline must
    be closed.
    """
    return _core.magnetic_gradient(as_list(bodies), points, threads)


@takes(points="m")
def potential(bodies: Bodies, points: ArrayLike, *, threads: int = 0) -> Floats:
    """Scalar potential of hard magnets and dipoles, one or several together, whose descent is H,
    inside them too.

    points (n, 3) [m], world axes. Returns (n) [A], zero infinitely far away and continuous
    everywhere. threads as in `field`. Raises Unsupported for currents, which have none, and for
    induced bodies.

    >>> import loomstone as ls
    >>> ls.magnetics.potential(ls.magnetics.dipoles([[0, 0, 0]], [[0, 0, 1]]), [[0, 0, 0.5]])
    array([0.31830989])
    """
    return _core.magnetic_potential(as_list(bodies), points, threads)
