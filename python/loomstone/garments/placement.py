"""Initial placement of panels: maps from the plane of a panel to space.

Cylinder and Cone preserve lengths, as does Plane if `across` and `up` are perpendicular unit
vectors. Seen from outside the garment, a panel's x axis points right and its y axis points up. The
cross product of x and y points outward.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..base.arguments import takes

__all__ = ["Cone", "Cylinder", "Placement", "Plane", "Ribbon"]

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]


class Placement(Protocol):
    """Any function that maps points of a panel's plane (n x 2) [m] to space (n x 3) [m]."""

    def __call__(self, points: Floats, /) -> Floats: ...


@takes(origin="m", across="1", up="1")
@dataclass(frozen=True)
class Plane:
    """Flat placement, which maps the point (x, y) of a panel to origin + x across + y up.

    The outside faces along the cross product of across and up, by default -y.
    """

    origin: Vector = (0.0, 0.0, 0.0)
    across: Vector = (1.0, 0.0, 0.0)
    up: Vector = (0.0, 0.0, 1.0)

    def __call__(self, points: Floats, /) -> Floats:
        placed: Floats = np.array(self.origin) + points @ np.array([self.across, self.up])
        return placed


@takes(radius="m", centre="m", angle_degrees="degrees", axis="1", reference="1")
@dataclass(frozen=True)
class Cylinder:
    """Placement on a cylinder.

    Points with x = 0 lie at the angle `angle_degrees` about the axis, measured from `reference`.
    The angle increases with x, counter-clockwise.

    radius : radius of the cylinder [m]
    centre : point on the axis at the height of y = 0 [m]
    axis, reference : directions; reference is made perpendicular to axis
    """

    radius: float
    centre: Vector = (0.0, 0.0, 0.0)
    angle_degrees: float = 0.0
    axis: Vector = (0.0, 0.0, 1.0)
    reference: Vector = (1.0, 0.0, 0.0)

    def __call__(self, points: Floats, /) -> Floats:
        angle = np.radians(self.angle_degrees) + points[:, :1] / self.radius
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        first = np.array(self.reference) - axis * (axis @ np.array(self.reference))
        first /= np.linalg.norm(first)
        radial = np.cos(angle) * first + np.sin(angle) * np.cross(axis, first)
        placed: Floats = np.array(self.centre) + self.radius * radial + points[:, 1:] * axis
        return placed


@takes(apex="m", tip="m", slope="1", angle_degrees="degrees")
@dataclass(frozen=True)
class Cone:
    """Placement on a vertical cone. Circles about the panel's apex become horizontal circles.

    apex : the cone's apex in the panel's plane [m]
    tip : the cone's apex in space [m]
    slope : radius of a horizontal circle divided by its distance from the apex along the cone,
        below 1 [1]
    angle_degrees : angle about the vertical axis, measured from +x in space, at which the panel's
        line x = apex[0] is placed [degrees]

    The cone opens downward if the panel's points lie below `apex` on average, otherwise upward.
    """

    apex: tuple[float, float]
    tip: Vector
    slope: float
    angle_degrees: float = 0.0

    def __call__(self, points: Floats, /) -> Floats:
        away = points - np.array(self.apex)
        distance = np.linalg.norm(away, axis=1)
        opens = 1.0 if away[:, 1].mean() > 0 else -1.0
        angle = (
            np.radians(self.angle_degrees) + np.arctan2(away[:, 0], opens * away[:, 1]) / self.slope
        )
        ring = self.slope * distance
        height = opens * np.sqrt(1.0 - self.slope**2) * distance
        placed: Floats = (
            np.array(self.tip) + np.c_[ring * np.cos(angle), ring * np.sin(angle), height]
        )
        return placed


@takes(path="m", across="1")
@dataclass(frozen=True)
class Ribbon:
    """Placement along a path in space: a panel's y is the arc length along the path, and its x runs
    along `across`, which may vary along the path. Points beyond an end of the path are placed as if
    their y were that of the end.

    path : (k x 3) points of the path [m]
    across : (k x 3) direction of x at each of these points, of any length above 0
    """

    path: tuple[Vector, ...]
    across: tuple[Vector, ...]

    def __call__(self, points: Floats, /) -> Floats:
        path, across = np.array(self.path), np.array(self.across)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        across = across / np.linalg.norm(across, axis=1)[:, None]
        centre, side = (
            np.stack([np.interp(points[:, 1], along, v) for v in a.T], axis=1)
            for a in (path, across)
        )
        side /= np.linalg.norm(side, axis=1)[:, None]
        placed: Floats = centre + points[:, :1] * side
        return placed
