"""Grips by which a user holds a patch of cloth, a body or an obstacle in a running simulation.

A grip pulls what it holds towards a goal, which the mouse sets. It changes only values that any
program may assign between two steps: external forces and poses of obstacles. Forces do not override
collision handling, so a user cannot pull cloth through itself. "Hand" means the user's end of a
grip.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..simulation import Simulation

__all__ = ["BodyGrip", "ClothGrip", "Grip", "ObstacleGrip"]

Floats = NDArray[np.float64]

# Smallest fraction of the mass of a cloth that a hand grips.
_PATCH = 0.05
# The force of a hand is at most the mass of the whole cloth or body that it grips, times this
# acceleration [m/s^2]. The value is about eight times gravity.
_PULL = 80.0
# Time constant of the spring between hand and gripped part, in units of the longest step. With 1,
# the force would move the part by the whole distance in one step. With less, the part would
# overshoot.
_REACTION = 1.5
# Time constant of the integral term, by which a hand balances the weight that it carries [s].
_SETTLING = 0.3
# Largest speed of a gripped obstacle [m/s].
_SPEED = 1.0


class Grip(Protocol):
    """Holds a part of the scene, and pulls the grabbed point to the position `goal` (3) [m]."""

    goal: Floats

    def lead(self, sim: Simulation, length: float) -> None:
        """Prepares the next step. `length` is the length of the step that has just ended [s]."""

    def release(self, sim: Simulation) -> None:
        """Lets go of the held part."""


class _Spring:
    """A damped spring between a hand and what it holds. An integral term balances the weight.

    mass : mass that moves with the hand [kg]
    carried : mass that may hang on the hand [kg]; the force is at most _PULL times this mass
    step : longest step of the simulation [s]
    """

    def __init__(self, mass: float, carried: float, step: float) -> None:
        self._mass, self._largest = mass, _PULL * carried
        self._time = _REACTION * step
        self._carried = np.zeros(3)

    def force(self, way: Floats, velocity: Floats, length: float) -> Floats:
        """Returns the force (3) [N] on the held part.

        way : vector (3) from the grabbed point to the goal [m]
        velocity : velocity (3) of the held part [m/s]
        length : length of the step that has just ended [s]
        """
        stiffness = self._mass / self._time**2
        force = stiffness * way - self._mass / self._time * velocity + self._carried
        size = float(np.linalg.norm(force))
        if size > self._largest:
            return force * (self._largest / size)
        self._carried += stiffness * way * (length / _SETTLING)
        return force


class ClothGrip:
    """Holds a cloth by the vertices nearest to a point.

    The grip takes as many of them as are needed to reach 5 % of the mass of the cloth.
    """

    def __init__(
        self, sim: Simulation, vertices: NDArray[np.int64], mass: Floats, point: ArrayLike
    ) -> None:
        """`vertices` are those of the cloth, and `point` is the grabbed point (3) [m].

        `mass` is the mass of each vertex of all cloths [kg].
        """
        distance = np.linalg.norm(sim.positions[vertices] - np.asarray(point), axis=1)
        order = vertices[np.argsort(distance, kind="stable")]
        whole = float(mass[order].sum())
        count = np.searchsorted(np.cumsum(mass[order]), _PATCH * whole) + 1
        self._patch = order[:count]
        self._share = mass[self._patch] / mass[self._patch].sum()
        self._spring = _Spring(float(mass[self._patch].sum()), whole, sim.step_size)
        # While the grip holds, the vector from the centre of the patch to the grabbed point is
        # taken as constant in world axes.
        self._arm = np.asarray(point) - self._centre(sim.positions)
        self._before = sim.external_forces[self._patch]
        self.goal = np.array(point, float)

    def _centre(self, table: Floats) -> Floats:
        return np.asarray(self._share @ table[self._patch])

    def lead(self, sim: Simulation, length: float) -> None:
        way = self.goal - self._arm - self._centre(sim.positions)
        force = self._spring.force(way, self._centre(sim.velocities), length)
        forces = sim.external_forces
        forces[self._patch] = self._before + self._share[:, None] * force
        sim.external_forces = forces

    def release(self, sim: Simulation) -> None:
        forces = sim.external_forces
        forces[self._patch] = self._before
        sim.external_forces = forces


class BodyGrip:
    """Holds a rigid body at its centre, so that the body can still turn about it."""

    def __init__(self, sim: Simulation, body: int, mass: float, point: ArrayLike) -> None:
        self.body, self._mass = body, mass
        self._spring = _Spring(mass, mass, sim.step_size)
        self._arm = np.asarray(point) - sim.body_centres[body]
        self._before = sim.external_body_forces[body].copy()
        self.goal = np.array(point, float)

    def lead(self, sim: Simulation, length: float) -> None:
        state = sim.state
        way = self.goal - self._arm - state.body_centres[self.body]
        force = self._spring.force(way, state.body_velocities[self.body], length)
        self._set(sim, force)

    def release(self, sim: Simulation) -> None:
        self._set(sim, np.zeros(3))

    def _set(self, sim: Simulation, force: Floats) -> None:
        forces = sim.external_body_forces
        forces[self.body] = self._before + force
        sim.external_body_forces = forces


class ObstacleGrip:
    """Holds an obstacle and keeps its orientation. The obstacle never returns to its keyframes."""

    def __init__(
        self,
        sim: Simulation,
        obstacle: int,
        place: ArrayLike,
        orientation: ArrayLike,
        point: ArrayLike,
    ) -> None:
        """`place` is the position of the obstacle and `point` the grabbed point [m].

        The orientation is a unit quaternion (w, x, y, z).
        """
        self.obstacle, self._orientation = obstacle, orientation
        self._place = np.array(place, float)
        self._arm = np.asarray(point) - self._place
        self.goal = np.array(point, float)

    def lead(self, sim: Simulation, length: float) -> None:
        way = self.goal - self._arm - self._place
        distance = float(np.linalg.norm(way))
        self._place += way * min(1.0, _SPEED * length / max(distance, 1e-12))
        sim.set_obstacle_pose(self.obstacle, self._place, self._orientation)

    def release(self, sim: Simulation) -> None:
        """Does nothing: the obstacle stays where it is."""
