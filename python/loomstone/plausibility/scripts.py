"""Scripted motion that looks like a mistake.

Examples are frame numbers given as times, degrees given as radians, and rotations by more than half
a turn between two keyframes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._core import Obstacle, Scene
from .surfaces import item

__all__ = ["of_scripts"]

Floats = NDArray[np.float64]

# Times look like frame numbers if all are whole numbers and the largest reaches a bound [s]: FRAMES
# for three or more times, FRAMES_OF_TWO for one or two. Both bounds are our choice. FRAMES is the
# number of frames in one second of film. FRAMES_OF_TWO is larger, because a slow motion between two
# times may well take half a minute.
FRAMES = 24.0
FRAMES_OF_TWO = 100.0
# Half a turn (the largest rotation between two keyframes) and a full turn [rad], each with a margin
# for rounding.
HALF_TURN = np.pi * (1.0 + 1e-6)
FULL_TURN = 2.0 * HALF_TURN


def of_scripts(scene: Scene) -> list[str]:
    """Returns one sentence for each property of scripted motion that looks like a mistake."""
    found = []
    for i, cloth in enumerate(scene.cloths):
        found.append((item("cloths", i, cloth.name), _frames("script_times", cloth.script_times)))
    for i, obstacle in enumerate(scene.obstacles):
        name = item("obstacles", i, obstacle.name)
        found += [(name, _frames("times", obstacle.times)), (name, _degrees(obstacle))]
    return [f"{name}: {sentence}" for name, sentence in found if sentence]


def _frames(name: str, given: list[float]) -> str:
    """Returns a sentence if times look like frame numbers, else ""."""
    times = np.asarray(given, float)
    if not _whole(times) or times.max(initial=0.0) < (FRAMES if len(times) > 2 else FRAMES_OF_TWO):
        return ""
    return (
        f"its {name} are whole numbers up to {times.max():g} s; if they are frame numbers,"
        f" divide them by the frame rate: np.array({name}) / 25"
    )


def _degrees(obstacle: Obstacle) -> str:
    """Returns a sentence if angles look like degrees or turn too far between keyframes, else ""."""
    angles = np.asarray(obstacle.axis_angles, float)
    if not len(angles):
        return ""
    largest = float(np.linalg.norm(angles, axis=1).max())
    if largest > HALF_TURN and (_whole(angles) or (len(angles) == 1 and largest > FULL_TURN)):
        return (
            f"its axis_angles reach {largest:.4g} rad; if {largest:.4g} degrees are meant, give"
            " np.radians(axis_angles)"
        )
    # Rotation vectors of some programs jump by a full turn when they reach half a turn or a full
    # turn. Angles of at most a full turn are therefore accepted for three keyframes or more.
    if len(angles) > 2 and largest <= FULL_TURN:
        return ""
    turned = np.linalg.norm(np.diff(angles, axis=0), axis=1)
    if turned.max(initial=0.0) <= HALF_TURN:
        return ""
    k = int(turned.argmax())
    return (
        f"its axis_angles turn it by {turned[k]:.4g} rad from {obstacle.times[k]:.6g} s to"
        f" {obstacle.times[k + 1]:.6g} s, but it turns the shorter way, by less than half a turn;"
        " give a keyframe for every third of a turn, or np.radians(axis_angles) if degrees are"
        " meant"
    )


def _whole(values: Floats) -> bool:
    return bool(np.array_equal(values, np.round(values)))
