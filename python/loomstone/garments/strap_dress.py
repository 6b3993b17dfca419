"""A dress of 13 panels that hangs by two straps over a bar along the x axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from ..base.arguments import takes, whole
from .edges import Edge, arc, line, quadratic
from .panel import Panel
from .placement import Cone, Ribbon, Vector
from .seams import Pattern, Seam
from .sewing import Garment, edge_for, garment

__all__ = ["dress", "dress_pattern"]

Floats = NDArray[np.float64]

# Distances from the waist along the cloth: top of the side seam, strap joints, and lowest point of
# the front neckline [m].
SIDE, STRAP, NECK = 0.15, 0.25, 0.19
# Width of a strap [m], and angle about the vertical axis of the worn dress, from centre front or
# centre back to the middle of the strap where it joins the bodice [degrees].
STRAP_WIDTH, STRAP_AT = 0.045, 34.0


@takes(bust="m", waist="m", hem="m", skirt="m", bar_radius="m")
def dress(
    triangles: int = 8900,
    *,
    bust: float = 0.94,
    waist: float = 0.74,
    hem: float = 2.6,
    skirt: float = 0.62,
    bar_radius: float = 0.015,
    seed: int = 1,
) -> Garment:
    """A sleeveless dress: a bodice of five panels, a skirt of six gores, and two straps over a bar.

    triangles : total number of triangles, at least 200; the result may differ from it slightly
    bust, waist, hem : circumferences [m]; the bust is 0.2 m from the waist along the cloth
    skirt : length of the skirt along the cloth [m]
    bar_radius : radius of the bar [m], whose axis is the x axis; 0.015 to 0.05
    seed : seed of the triangulation

    Bodice and skirt start as cones, with little strain. The front faces -y. Groups are
    "strap_left", "front.neckline", "gore_1.hem" and so on.

    >>> len(dress(1500).panel_names)
    13
    """
    count = whole("triangles", triangles, 200, 10_000_000)
    pattern = dress_pattern(bust=bust, waist=waist, hem=hem, skirt=skirt, bar_radius=bar_radius)
    # Mesh edges of the length `edge` are chords of the straps' path over the bar. In the second
    # pattern, this path is higher, so that the chords do not cut into the bar.
    edge = edge_for(sum(panel.area for panel in pattern.panels), count)
    pattern = dress_pattern(
        bust=bust, waist=waist, hem=hem, skirt=skirt, bar_radius=bar_radius, chord=edge
    )
    return garment(pattern, triangles=count, seed=seed, relax=20)


@takes(bust="m", waist="m", hem="m", skirt="m", bar_radius="m", chord="m")
def dress_pattern(
    *,
    bust: float = 0.94,
    waist: float = 0.74,
    hem: float = 2.6,
    skirt: float = 0.62,
    bar_radius: float = 0.015,
    chord: float = 0.0,
) -> Pattern:
    """Returns panels and seams of `dress`, which can be changed before they are sewn.

    chord : length of the straps' mesh edges [m], from 0 to 0.15. Edges of this length are chords of
        the arc over the bar, so the straps start high enough for these chords to clear the bar. If
        `chord` is large, the straps are slack at first.

    The other lengths [m] are those of `dress`. Raises InvalidInput for values out of range.
    """
    if not 0.0 <= chord <= 0.15:
        raise InvalidInput(f"chord must be in [0, 0.15] m, got {chord}")
    if not 0.3 < waist < bust < waist + 0.8 or not waist < hem < waist + 5.0 * skirt:
        raise InvalidInput(
            "waist must be in (0.3, bust), bust < waist + 0.8 and hem in (waist, waist + 5 skirt)"
            f" [m], got bust={bust}, waist={waist}, hem={hem}, skirt={skirt}"
        )
    if not 0.015 <= bar_radius <= 0.05:
        raise InvalidInput(f"bar_radius must be in [0.015, 0.05] m, got {bar_radius}")
    # The circumference of a cone grows by 2 pi times its slope per unit of length along the cloth.
    upper = _Cone(waist, (bust - waist) / (2 * np.pi * 0.2), 1.0)
    lower = _Cone(waist, (hem - waist) / (2 * np.pi * skirt), -1.0)
    strap_path, strap_across = _strap(upper, bar_radius, chord)
    drop = float(strap_path[0, 2]) - upper.height(STRAP)  # z of the waist [m]
    bodice, bodice_seams = _bodice(upper, drop)
    gores, gore_seams = _gores(lower, skirt, drop)
    straps, strap_seams = _straps(strap_path, strap_across)
    return Pattern((*bodice, *gores, *straps), (*bodice_seams, *gore_seams, *strap_seams))


def _gores(cone: _Cone, skirt: float, drop: float) -> tuple[list[Panel], list[Seam]]:
    """Returns the gores of the skirt, and their seams with each other and with the bodice."""
    gores, seams = [], []
    for i in range(6):
        name = f"gore_{i + 1}"
        gores.append(
            Panel(
                name,
                (
                    _curve("hem", cone, skirt, -30, 30),
                    line("right", cone.at(skirt, 30), cone.at(0, 30)),
                    _curve("waist", cone, 0, 30, -30),
                    line("left", cone.at(0, -30), cone.at(skirt, -30)),
                ),
                place=cone.place(drop, -60.0 + 60.0 * i),
            )
        )
        seams.append(Seam(f"{name}.right", f"gore_{(i + 1) % 6 + 1}.left", True))
    tops = ["front.waist_right", "side_right.waist", "back_right.waist"]
    tops += ["back_left.waist", "side_left.waist", "front.waist_left"]
    seams += [Seam(f"gore_{i + 1}.waist", top, True) for i, top in enumerate(tops)]
    return gores, seams


def _straps(right_path: Floats, right_across: Floats) -> tuple[list[Panel], list[Seam]]:
    half = STRAP_WIDTH / 2
    length = float(np.linalg.norm(np.diff(right_path, axis=0), axis=1).sum())
    corners = [(-half, 0.0), (half, 0.0), (half, length), (-half, length)]
    names = ("front", "right", "back", "left")
    straps, seams = [], []
    for side, sign in (("right", 1.0), ("left", -1.0)):
        path = _tuples(right_path * (sign, 1, 1))
        across = _tuples(right_across * (1, sign, 1))
        place = Ribbon(path, across)
        straps.append(Panel.polygon(f"strap_{side}", corners, names=names, place=place))
        seams += [Seam(f"strap_{side}.front", f"front.strap_{side}", True)]
        seams += [Seam(f"strap_{side}.back", f"back_{side}.strap", True)]
    return straps, seams


class _Cone:
    """One of the two cones that meet at the waist, with polar coordinates.

    The coordinates are the distance from the waist along the cloth [m], and the angle about the
    vertical axis of the worn dress [degrees], which differs from the angle in the flat panel.
    """

    def __init__(self, waist: float, slope: float, opens: float) -> None:
        self.slope, self.opens = slope, opens
        self.apex_distance = waist / (2 * np.pi * slope)

    def at(self, distance: float, degrees: float) -> tuple[float, float]:
        """Returns a point in the panel's plane with the apex at the origin [m].

        degrees : angle about the cone's vertical axis, from the panel's centre line
        """
        angle, away = np.radians(degrees) * self.slope, self.apex_distance + distance
        return away * np.sin(angle), self.opens * away * np.cos(angle)

    def height(self, distance: float) -> float:
        """Returns the height above the waist [m] of points at `distance` from it along the cone."""
        return float(self.opens * np.sqrt(1 - self.slope**2) * distance)

    def radius(self, distance: float) -> float:
        return float(self.slope * (self.apex_distance + distance))

    def place(self, waist_height: float, degrees: float) -> Cone:
        return Cone(
            (0.0, 0.0),
            (0.0, 0.0, waist_height - self.height(self.apex_distance)),
            self.slope,
            degrees,
        )


def _curve(name: str, cone: _Cone, distance: float, first: float, last: float) -> Edge:
    """Returns an edge that is a horizontal arc on a cone.

    first, last : angles of its ends about the cone's axis [degrees]
    """
    return arc(
        name,
        cone.at(distance, first),
        cone.at(distance, (first + last) / 2),
        cone.at(distance, last),
    )


@dataclass(frozen=True)
class _Shape:
    """Joints of the straps with the bodice, and control points of the bodice's curves.

    Angles are about the vertical axis of the worn dress, from centre front or centre back.
    Distances are from the waist along the cloth.

    inner, outer : angles of a strap's two edges where it joins the bodice [degrees]
    armhole : distance of the control points of the front and back armholes [m]
    nape : distance of the back neckline's lowest point and of its control point [m]
    """

    inner: float
    outer: float
    armhole: float
    nape: float


def _bodice(cone: _Cone, drop: float) -> tuple[list[Panel], list[Seam]]:
    half = np.degrees(STRAP_WIDTH / 2 / cone.radius(STRAP))
    shape = _Shape(STRAP_AT - half, STRAP_AT + half, (STRAP + SIDE) / 2 - 0.03, NECK + 0.02)
    front, side, back = _front(cone, shape, drop), _side(cone, drop), _back(cone, shape, drop)
    panels = [
        front,
        side,
        side.mirrored("side_left", place=cone.place(drop, 180.0)),
        back,
        back.mirrored("back_left", place=cone.place(drop, 120.0)),
    ]
    seams = [
        Seam("front.right", "side_right.front", True),
        Seam("front.left", "side_left.front", True),
        Seam("side_right.back", "back_right.side", True),
        Seam("side_left.back", "back_left.side", True),
        Seam("back_right.centre", "back_left.centre", True),
    ]
    return panels, seams


def _front(cone: _Cone, shape: _Shape, drop: float) -> Panel:
    inner, outer, armhole = shape.inner, shape.outer, shape.armhole
    return Panel(
        "front",
        (
            _curve("waist_left", cone, 0, -60, 0),
            _curve("waist_right", cone, 0, 0, 60),
            line("right", cone.at(0, 60), cone.at(SIDE, 60)),
            quadratic(
                "armhole_right",
                cone.at(SIDE, 60),
                cone.at(armhole, outer + 2),
                cone.at(STRAP, outer),
            ),
            line("strap_right", cone.at(STRAP, outer), cone.at(STRAP, inner)),
            arc("neckline", cone.at(STRAP, inner), cone.at(NECK, 0), cone.at(STRAP, -inner)),
            line("strap_left", cone.at(STRAP, -inner), cone.at(STRAP, -outer)),
            quadratic(
                "armhole_left",
                cone.at(STRAP, -outer),
                cone.at(armhole, -outer - 2),
                cone.at(SIDE, -60),
            ),
            line("left", cone.at(SIDE, -60), cone.at(0, -60)),
        ),
        place=cone.place(drop, -90.0),
    )


def _side(cone: _Cone, drop: float) -> Panel:
    return Panel(
        "side_right",
        (
            _curve("waist", cone, 0, -30, 30),
            line("back", cone.at(0, 30), cone.at(SIDE, 30)),
            quadratic("armhole", cone.at(SIDE, 30), cone.at(SIDE - 0.015, 0), cone.at(SIDE, -30)),
            line("front", cone.at(SIDE, -30), cone.at(0, -30)),
        ),
        place=cone.place(drop, 0.0),
    )


def _back(cone: _Cone, shape: _Shape, drop: float) -> Panel:
    inner, outer, armhole, nape = shape.inner, shape.outer, shape.armhole, shape.nape
    # About the vertical axis, from +x, the panel spans 30 degrees (side seam) to 90 degrees (centre
    # back). Its middle, from which cone.at() measures angles, lies at 60 degrees.
    return Panel(
        "back_right",
        (
            _curve("waist", cone, 0, -30, 30),
            line("centre", cone.at(0, 30), cone.at(nape, 30)),
            quadratic(
                "neckline", cone.at(nape, 30), cone.at(nape, 34 - inner), cone.at(STRAP, 30 - inner)
            ),
            line("strap", cone.at(STRAP, 30 - inner), cone.at(STRAP, 30 - outer)),
            quadratic(
                "armhole",
                cone.at(STRAP, 30 - outer),
                cone.at(armhole, 28 - outer),
                cone.at(SIDE, -30),
            ),
            line("side", cone.at(SIDE, -30), cone.at(0, -30)),
        ),
        place=cone.place(drop, 60.0),
    )


def _strap(cone: _Cone, bar_radius: float, chord: float) -> tuple[Floats, Floats]:
    """Returns the path of the right strap over the bar, and the direction across the strap.

    The path is a polyline (33 x 3) [m]. The directions are unit vectors (33 x 3) at its points.
    """
    angle, radius = np.radians(STRAP_AT), cone.radius(STRAP)
    x, depth, rise = radius * np.sin(angle), radius * np.cos(angle), 0.13
    clear = bar_radius + 0.004
    # The middle of a chord of the circle of radius `over` lies about chord^2 / (8 over) inside it.
    over = (clear + np.sqrt(clear**2 + chord**2 / 2)) / 2
    # In the plane (y, z), the path is straight from (-depth, -rise) to its tangent point on the
    # circle of radius `over`, and then follows the circle over the top. The rear is symmetric.
    first = np.arctan2(-rise, -depth) - np.arccos(over / np.hypot(depth, rise)) + 2 * np.pi
    turn = np.linspace(first, np.pi - first, 17)
    circle = np.c_[np.full(17, x), over * np.cos(turn), over * np.sin(turn)]
    leg = np.linspace(np.array([x, -depth, -rise]), circle[0], 9)[:-1]
    path = np.concatenate([leg, circle, (leg * (1, -1, 1))[::-1]])
    # The direction across the strap is tangent to the bodice at the joints, and parallel to the bar
    # where the strap passes over it.
    twist = angle * np.concatenate([np.linspace(1, 0, 8), np.zeros(17), np.linspace(0, -1, 8)])
    across = np.c_[np.cos(twist), np.sin(twist), np.zeros(33)]
    return path, across


def _tuples(rows: Floats) -> tuple[Vector, ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in rows)
