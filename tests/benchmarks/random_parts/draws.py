"""Random numbers, directions and rotations."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation


def between(random: np.random.Generator, low: float, high: float) -> float:
    """Returns a number between `low` and `high` whose logarithm is uniformly distributed."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def direction(random: np.random.Generator) -> NDArray[np.float64]:
    """Returns a unit vector whose direction is uniformly distributed."""
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def quaternion(random: np.random.Generator) -> NDArray[np.float64]:
    """Returns a uniformly distributed rotation as a quaternion (w, x, y, z)."""
    vector = random.normal(size=4)
    return vector / np.linalg.norm(vector)


def rotation(random: np.random.Generator) -> NDArray[np.float64]:
    """Returns the matrix of a uniformly distributed rotation."""
    w, x, y, z = quaternion(random)
    return np.asarray(Rotation.from_quat((x, y, z, w)).as_matrix())
