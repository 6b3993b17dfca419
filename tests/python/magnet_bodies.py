"""Helpers for tests of the motion of rigid bodies with magnets."""

import loomstone as ls
import numpy as np
from scipy.spatial.transform import Rotation


def quaternion(rotation: Rotation) -> np.ndarray:
    """Returns the rotation as (w, x, y, z)."""
    return rotation.as_quat()[[3, 0, 1, 2]]


def rotation_of(orientation: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.asarray(orientation)[[1, 2, 3, 0]])


def to_axis(axis: np.ndarray) -> Rotation:
    """Returns a rotation from z to `axis`."""
    return Rotation.align_vectors([axis], [[0.0, 0.0, 1.0]])[0]


def ball_mesh(radius: float, mass: float) -> tuple[ls.TriangleMesh, float]:
    """Returns a mesh of a ball and its density [kg/m^3]. They give the body `mass` [kg] and the
    inertia 2/5 mass radius^2 of a sphere.
    """
    mesh = ls.meshes.sphere(radius=radius, subdivisions=2)
    made = ls.meshes.mass_properties(mesh, 1.0)
    scale = np.sqrt(0.4 * radius**2 * made.mass / made.inertia[0, 0])
    mesh = ls.meshes.sphere(radius=radius * scale, subdivisions=2)
    return mesh, mass / ls.meshes.mass_properties(mesh, 1.0).mass


def total_momenta(sim: ls.Simulation, scene: ls.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Returns the linear momentum of all bodies, and their angular momentum about the origin."""
    state, linear, angular = sim.state, np.zeros(3), np.zeros(3)
    for b, body in enumerate(scene.bodies):
        properties = ls.meshes.mass_properties(body)
        turn = rotation_of(state.body_orientations[b]).as_matrix()
        p = properties.mass * state.body_velocities[b]
        linear += p
        angular += np.cross(state.body_centres[b], p)
        angular += turn @ properties.inertia @ turn.T @ state.body_angular_velocities[b]
    return linear, angular
