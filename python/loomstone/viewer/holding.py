"""Makes the grip on the cloth, body or obstacle that a user has grabbed.

A grip on cloth or on a body requires its mass, and a grip on an obstacle its pose.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core import InvalidInput, Scene, mass_properties
from ..simulation import Simulation
from .grips import BodyGrip, ClothGrip, Grip, ObstacleGrip

__all__ = ["Holder"]


class Holder:
    """Makes grips on the cloths, bodies and obstacles of a scene."""

    def __init__(self, scene: Scene, sim: Simulation) -> None:
        self._scene = scene
        topology = sim.topology
        uv = topology.corner_uv.reshape(-1, 3, 2)
        first, second = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        area = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        density = np.array([cloth.material.density for cloth in scene.cloths])
        if len(density):
            area = area * density[topology.cloth_of_triangle]
        corners, n = topology.triangles.ravel(), len(topology.cloth_of_vertex)
        self._vertex_mass = np.zeros(n)
        np.add.at(self._vertex_mass, corners, np.repeat(area / 3.0, 3))
        self._cloth_of_vertex = topology.cloth_of_vertex
        self._body_of_vertex = topology.body_of_vertex

    def can_hold(self, body: int) -> bool:
        """Returns whether a body or obstacle can be held. Floors and deforming obstacles cannot.

        `body` is an index among the rigid bodies followed by the obstacles.
        """
        if body < len(self._scene.bodies):
            return True
        obstacle = self._scene.obstacles[body - len(self._scene.bodies)]
        return not obstacle.floor and not len(obstacle.vertex_positions)

    def hold(self, sim: Simulation, kind: str, index: int, point: ArrayLike) -> Grip:
        """Returns a grip on a cloth ("cloth") or on a body or obstacle ("body") at a point (3) [m].

        `index` is an index among the cloths, or among the rigid bodies followed by the obstacles.
        Raises InvalidInput for a floor and for an obstacle that deforms.
        """
        if kind == "cloth":
            vertices = np.flatnonzero(self._cloth_of_vertex == index)
            return ClothGrip(sim, vertices, self._vertex_mass, point)
        if not self.can_hold(index):
            raise InvalidInput("an obstacle that deforms or is a floor cannot be held")
        if index < len(self._scene.bodies):
            body = self._scene.bodies[index]
            assert body.mesh is not None
            return BodyGrip(sim, index, mass_properties(body).mass, point)
        obstacle = index - len(self._scene.bodies)
        rotation, place = self._pose(sim, index, obstacle)
        return ObstacleGrip(sim, obstacle, place, rotation, point)

    def _pose(
        self, sim: Simulation, body: int, obstacle: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Returns the present orientation (w, x, y, z) and position [m] of an obstacle.

        `body` is its index among the rigid bodies followed by the obstacles, and `obstacle` that
        among the obstacles.
        """
        from scipy.spatial.transform import Rotation

        mesh = self._scene.obstacles[obstacle].mesh
        assert mesh is not None
        own = mesh.vertices
        now = sim.frame().body_vertices[self._body_of_vertex == body]
        rotation, _ = Rotation.align_vectors(now - now.mean(0), own - own.mean(0))
        place = now.mean(0) - rotation.apply(own.mean(0))
        return np.roll(rotation.as_quat(), 1), place
