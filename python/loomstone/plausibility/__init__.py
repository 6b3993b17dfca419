"""Search for likely mistakes in a scene that can be simulated: wrong units, overlaps, jumps.

A Simulation warns of them with SceneWarning when it is built, and `loomstone check` lists them.
"""

from __future__ import annotations

from typing import Any

from ..integrators import Asynchronous
from .air import of_air
from .bodies import of_overlaps, of_reversed, of_sizes, reversed_obstacles
from .cloths import of_attachments, of_cloths, of_contacts
from .magnets import of_magnets
from .scripts import of_scripts
from .steps import of_steps
from .surfaces import overlapping_pairs, start_surfaces

__all__ = ["implausible"]


def implausible(simulation: Any) -> list[str]:
    """Returns sentences about properties of a scene that look like mistakes.

    simulation : Simulation of the scene in its initial state

    All ranks must call this function, and all get the same sentences.
    """
    scene = simulation.scene
    found = [*of_cloths(scene.cloths), *of_attachments(scene), *of_air(scene)]
    if _throws(simulation):
        found += of_contacts(scene, simulation)
    found += [*of_sizes(scene), *of_scripts(scene), *of_steps(simulation)]
    reversed_ones = reversed_obstacles(scene)
    if scene.bodies or reversed_ones:  # otherwise, neither overlaps nor magnets are checked
        surfaces = start_surfaces(scene, simulation)
        pairs = overlapping_pairs(surfaces)
        found += of_reversed(scene, surfaces, reversed_ones)
        found += [*of_overlaps(surfaces, pairs), *of_magnets(scene, surfaces, pairs)]
    return found


def _throws(simulation: Any) -> bool:
    """Returns whether cloth that starts within the contact distance would be pushed away abruptly.

    Asynchronous steps move such cloth away slowly. A scene that sets allow_initial_intersections
    needs no warning.
    """
    scene = simulation.scene
    collides = scene.cloths and scene.collisions and not scene.allow_initial_intersections
    return bool(collides) and not isinstance(simulation.integrator, Asynchronous)
