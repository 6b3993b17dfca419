"""A T-shirt: front, back and two sleeves."""

from __future__ import annotations

import numpy as np

from .._core import InvalidInput
from ..base.arguments import takes
from .edges import Edge, arc, cubic, line, quadratic
from .panel import Panel
from .placement import Cylinder
from .seams import Pattern, Seam
from .sewing import Garment, garment

__all__ = ["tshirt", "tshirt_pattern"]

SEAMS = (
    ("front.right", "back.left"),
    ("front.left", "back.right"),
    ("front.shoulder_right", "back.shoulder_left"),
    ("front.shoulder_left", "back.shoulder_right"),
    ("sleeve_right.cap_front", "front.armhole_right"),
    ("sleeve_right.cap_back", "back.armhole_left"),
    ("sleeve_left.cap_front", "front.armhole_left"),
    ("sleeve_left.cap_back", "back.armhole_right"),
    ("sleeve_right.under_front", "sleeve_right.under_back"),
    ("sleeve_left.under_front", "sleeve_left.under_back"),
)


@takes(chest="m", length="m", sleeve="m")
def tshirt(
    triangles: int = 6000,
    *,
    chest: float = 1.04,
    length: float = 0.70,
    sleeve: float = 0.16,
    seed: int = 1,
) -> Garment:
    """A T-shirt, initially placed around a standing torso with arms half raised.

    The hem lies near z = 0, and the front faces -y.

    triangles : total number of triangles; the result may differ from it slightly
    chest : circumference of the T-shirt at the chest [m]
    length : length from the neck end of the shoulder seam to the hem [m]
    sleeve : length of the sleeve below the armhole [m]
    seed : seed of the triangulation

    >>> len(tshirt(800).openings())
    4
    """
    return garment(
        tshirt_pattern(chest=chest, length=length, sleeve=sleeve), triangles=triangles, seed=seed
    )


@takes(chest="m", length="m", sleeve="m")
def tshirt_pattern(*, chest: float = 1.04, length: float = 0.70, sleeve: float = 0.16) -> Pattern:
    """Returns panels and seams of `tshirt`, which can be changed before they are sewn.

    Lengths are in [m], as in `tshirt`. Raises InvalidInput for values out of range.
    """
    if not 0.6 <= chest <= 2.0 or not 0.5 <= length <= 1.5 or not 0.02 <= sleeve <= 0.6:
        raise InvalidInput(
            "chest must be in [0.6, 2], length in [0.5, 1.5], sleeve in [0.02, 0.6] m, got"
            f" {chest}, {length}, {sleeve}"
        )
    radius = chest / (2 * np.pi)
    front = Panel("front", _body(chest, length, 0.085), place=Cylinder(radius, angle_degrees=-90.0))
    back = Panel("back", _body(chest, length, 0.02), place=Cylinder(radius, angle_degrees=90.0))
    arm = _sleeve(front.edge("armhole_right").length, sleeve)
    width = 2 * max(x for edge in arm for x, _ in edge.points)
    centre = (radius + 0.03, 0.0, length - 0.17)
    round_arm = width / (2 * np.pi)
    right = Panel(
        "sleeve_right",
        arm,
        place=Cylinder(round_arm, centre, axis=(-1, 0, 0.7), reference=(0, 0, 1)),
    )
    other = Cylinder(round_arm, (-centre[0], 0.0, centre[2]), axis=(1, 0, 0.7), reference=(0, 0, 1))
    return Pattern(
        (front, back, right, right.mirrored("sleeve_left", place=other)),
        tuple(Seam(a, b, True) for a, b in SEAMS),
    )


def _body(chest: float, length: float, neck_depth: float) -> tuple[Edge, ...]:
    half, neck = chest / 4, 0.085
    side, drop, shoulder = length - 0.25, 0.045, chest / 4 - 0.055

    def armhole(name: str, sign: float) -> Edge:
        points = [
            (sign * half, side),
            (sign * (half - 0.075), side + 0.03),
            (sign * shoulder, length - drop),
        ]
        return quadratic(name, *(points if sign > 0 else points[::-1]))

    return (
        line("hem", (-half, 0), (half, 0)),
        line("right", (half, 0), (half, side)),
        armhole("armhole_right", 1.0),
        line("shoulder_right", (shoulder, length - drop), (neck, length)),
        arc("neckline", (neck, length), (0, length - neck_depth), (-neck, length)),
        line("shoulder_left", (-neck, length), (-shoulder, length - drop)),
        armhole("armhole_left", -1.0),
        line("left", (-half, side), (-half, 0)),
    )


def _sleeve(armhole: float, length: float) -> tuple[Edge, ...]:
    """Returns the edges of a sleeve.

    Each half of the sleeve cap has the length `armhole` [m] of one armhole edge. The half width
    of the sleeve that gives this length is found by bisection.
    """
    high = 0.10

    def cap(width: float) -> Edge:
        return cubic("cap_back", (width, 0), (0.6 * width, 0.0), (0.45 * width, high), (0, high))

    narrow, wide = 0.02, armhole
    for _ in range(60):
        middle = (narrow + wide) / 2
        narrow, wide = (middle, wide) if cap(middle).length < armhole else (narrow, middle)
    width, cuff = wide, 0.88 * wide
    back = cap(width)
    front = cubic("cap_front", (0, high), (-0.45 * width, high), (-0.6 * width, 0.0), (-width, 0))
    return (
        line("cuff", (-cuff, -length), (cuff, -length)),
        line("under_back", (cuff, -length), (width, 0)),
        back,
        front,
        line("under_front", (-width, 0), (-cuff, -length)),
    )
