"""Masses of vertices. The script run_pbd.py in shared/peers imports this module, which is not in
that folder.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def lumped_mass(uv: Floats, faces: NDArray[np.int64], density: float) -> Floats:
    """Returns the mass of each vertex [kg]: a third of the mass of the triangles around it.

    uv : (n x 2) rest coordinates [m]
    density : mass per area [kg/m^2]
    """
    e, f = (uv[faces[:, k]] - uv[faces[:, 0]] for k in (1, 2))
    areas = 0.5 * np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0])
    return np.bincount(faces.ravel(), np.repeat(density * areas / 3.0, 3), len(uv))
