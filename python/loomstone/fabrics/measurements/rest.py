"""Brings a simulation to static rest by kinetic damping [Barnes1999].

Velocities are set to zero whenever the kinetic energy has passed a peak, so every swing ends where
forces nearly balance. Nothing is added to the forces: the shape at rest is one of the material and
gravity alone. Which one, where several are stable, is decided by the way there, as in a real test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core import InvalidInput
from ...base.arguments import takes
from ...simulation import Simulation

__all__ = ["Rest", "bring_to_rest"]


@dataclass(frozen=True)
class Rest:
    """How a simulation came to rest.

    at_rest : whether both conditions below held within the time allowed
    time : simulated [s]; stops : how often velocities were set to zero
    energy_ratio : largest kinetic energy of the last `window` over the largest ever [1]
    drift : largest distance any vertex went within the last `window` [m]
    """

    at_rest: bool
    time: float
    stops: int
    energy_ratio: float
    drift: float


@takes(longest="s", ratio="1", drift="m", window="s")
def bring_to_rest(
    simulation: Simulation,
    *,
    longest: float = 8.0,
    ratio: float = 1e-6,
    drift: float = 1e-4,
    window: float = 0.2,
) -> Rest:
    """Advances until the kinetic energy stays below `ratio` of its peak and no vertex moves by more
    than `drift`.

    longest : simulated time at most [s]
    ratio : of the largest kinetic energy ever seen [1], not exceeded for `window` [s]
    drift : [m] within `window`
    """
    for name, value in (
        ("longest", longest),
        ("ratio", ratio),
        ("drift", drift),
        ("window", window),
    ):
        if not (np.isfinite(value) and value > 0):
            raise InvalidInput(
                f"bring_to_rest: {name} must be > 0, got {value}; correct this value"
            )
    steps_in_window = max(3, round(window / simulation.step_size))
    peak = before = highest = 0.0
    rising, stops, count = True, 0, 0
    place = simulation.positions
    energy_ratio, moved = 1.0, np.inf
    start = simulation.time
    while simulation.time - start < longest:
        simulation.step()
        energy = float(simulation.report.energy.kinetic)
        peak, highest, count = max(peak, energy), max(highest, energy), count + 1
        if energy < before and rising:
            simulation.velocities = np.zeros_like(simulation.velocities)
            stops, energy = stops + 1, 0.0
        rising, before = energy >= before, energy
        if count >= steps_in_window:
            here = simulation.positions
            moved = float(np.linalg.norm(here - place, axis=1).max())
            energy_ratio = highest / peak if peak else 0.0
            if energy_ratio < ratio and moved < drift:
                return Rest(True, simulation.time - start, stops, energy_ratio, moved)
            place, highest, count = here, 0.0, 0
    return Rest(False, simulation.time - start, stops, energy_ratio, moved)
