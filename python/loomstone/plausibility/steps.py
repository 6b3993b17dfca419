"""Steps that look like a mistake: fixed steps above the stability limit of an explicit scheme."""

from __future__ import annotations

from typing import Any

from ..integrators import ExplicitEuler, SymplecticEuler

__all__ = ["of_steps"]


def of_steps(simulation: Any) -> list[str]:
    """Returns a list with one sentence if an explicit scheme has a fixed step above its stability
    limit.

    The list is empty otherwise, and also if no vertex of cloth moves freely.
    """
    integrator = simulation.integrator
    if not isinstance(integrator, (ExplicitEuler, SymplecticEuler)) or integrator.step == "auto":
        return []
    if all(len(set(cloth.pins)) == cloth.mesh.n_vertices for cloth in simulation.scene.cloths):
        return []  # no vertex of cloth moves freely
    stable = simulation.stable_step()
    if integrator.step <= stable:
        return []
    return [
        f"integrator.step: {integrator.step:g} s is longer than the longest stable step at the"
        f" start, {stable:.2g} s, so the cloth will be torn apart; give at most half of this, or"
        ' step="auto"'
    ]
