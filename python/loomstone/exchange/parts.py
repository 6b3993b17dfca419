"""A mesh over time, as a file of another program holds it."""

from __future__ import annotations

from dataclasses import dataclass

from .surfaces import Floats, Indices

__all__ = ["Part"]


@dataclass(frozen=True)
class Part:
    """One mesh of a file in world space, with z up."""

    name: str
    triangles: Indices  # (m x 3)
    frames: Floats  # (f x n x 3) [m]
