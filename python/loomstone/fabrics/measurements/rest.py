"""Brings a simulation to static rest by kinetic damping [Barnes1999].

Velocities are set to zero whenever the kinetic energy has passed a peak, because forces nearly
balance there. The forces are not modified, so they balance in the shape at rest. If several shapes
are stable, the path to rest selects one of them, as in a real test.
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
    """Result of bring_to_rest().

    at_rest : whether both conditions of bring_to_rest() were met
    time : simulated time of this call [s]
    stops : number of times that velocities were set to zero
    energy_ratio : largest kinetic energy in the last completed window of time, relative to the
        largest from the start of the call to the end of this window [1]; 1 if no window was
        completed
    drift : displacement over this window of the vertex that moved most [m]; inf if no window was
        completed
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
    """Advances until the kinetic energy and the displacements of all vertices stay below limits
    over a window of time.

    If that does not happen, the call ends after the first step that reaches `longest`.

    longest : simulated time of this call after which no further step begins [s]
    ratio : limit of the kinetic energy in a window, relative to the largest in this call so far [1]
    drift : limit of the displacement of a vertex over a window [m]
    window : length of a window [s]; extended to three steps if it is shorter

    Raises InvalidInput unless these values are positive and finite.
    """
    for name, value in (
        ("longest", longest),
        ("ratio", ratio),
        ("drift", drift),
        ("window", window),
    ):
        if not (np.isfinite(value) and value > 0):
            raise InvalidInput(
                f"bring_to_rest: {name} must be finite and > 0, got {value}; correct this value"
            )
    window = max(window, 3 * simulation.step_size)
    peak = before = highest = 0.0
    rising, stops = True, 0
    place = simulation.positions
    energy_ratio, moved = 1.0, np.inf
    start = opened = simulation.time
    while simulation.time - start < longest:
        simulation.step()
        energy = float(simulation.report.energy.kinetic)
        peak, highest = max(peak, energy), max(highest, energy)
        if energy < before and rising:
            simulation.velocities = np.zeros_like(simulation.velocities)
            stops, energy = stops + 1, 0.0
        rising, before = energy >= before, energy
        # Without the tolerance of 1e-9 s, rounding of times could add a step to a window.
        if simulation.time - opened > window - 1e-9:
            here = simulation.positions
            moved = float(np.linalg.norm(here - place, axis=1).max())
            energy_ratio = highest / peak if peak else 0.0
            if energy_ratio < ratio and moved < drift:
                return Rest(True, simulation.time - start, stops, energy_ratio, moved)
            place, highest, opened = here, 0.0, simulation.time
    return Rest(False, simulation.time - start, stops, energy_ratio, moved)
