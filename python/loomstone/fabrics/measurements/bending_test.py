"""The cantilever test of bending (ASTM D1388, option A) [Peirce1930].

A strip 25 mm wide projects from a clamp and bends under its weight per area, w = density * g. The
overhang l is the length at which the chord from clamp to tip is inclined by 41.5 degrees. The
standard defines the bending length c = l / 2 and the rigidity w c^3. The reference solution is the
elastica B theta'' = -w (l - s) cos(theta), clamped at s = 0 and free at s = l, where theta is the
inclination at the arc length s. The rigidity B follows from orthotropic plate theory for the
direction of the strip. On the bias, the clamp suppresses the twist that this B assumes. The
overhang is therefore longer than that of the elastica, by an amount that grows with the width of
the strip.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ... import meshes
from ..._core import Cloth, ClothMaterial, InvalidInput, Scene, SolverFailure, TriangleMesh
from ...base.arguments import takes
from ...integrators import SemiImplicitEuler
from ...simulation import Simulation
from ..rigidity import strip_rigidity
from .rest import bring_to_rest

__all__ = ["ANGLE", "CantileverResult", "cantilever", "overhang_of_elastica"]

# ANGLE: inclination of the chord that defines the overhang [degrees]. WIDTH: default width of a
# strip [m]. GRAVITY: the default of Scene [m/s^2].
ANGLE, WIDTH, GRAVITY = 41.5, 0.025, 9.81


@dataclass(frozen=True)
class CantileverResult:
    """Result of the cantilever test for one direction.

    angle_degrees : angle of the strip to weft
    overhang : overhang l at which the chord is inclined by 41.5 degrees [m]
    elastica : overhang l of an elastica with `rigidity`, at the same inclination [m]
    rigidity : rigidity of the strip by plate theory [N m]
    measured_rigidity : rigidity of an elastica whose overhang is `overhang` [N m]
    at_rest : whether every simulated strip came to rest
    strips : number of strips that were simulated
    seconds : wall time of the test [s]
    """

    angle_degrees: float
    overhang: float
    elastica: float
    rigidity: float
    measured_rigidity: float
    at_rest: bool
    strips: int
    seconds: float

    @property
    def bending_length(self) -> float:
        """Bending length c = l / 2 of ASTM D1388 [m]."""
        return self.overhang / 2

    @property
    def error(self) -> float:
        """Relative deviation of the overhang from that of the elastica [1]."""
        return self.overhang / self.elastica - 1


@takes(angle_degrees="degrees", width="m", step="s")
def cantilever(
    material: ClothMaterial,
    *,
    angle_degrees: float = 0.0,
    width: float = WIDTH,
    across: int = 8,
    step: float = 4e-3,
    threads: int = 1,
) -> CantileverResult:
    """Simulates overhanging strips, one after another, until the chord of a strip is inclined by
    41.5 +- 0.1 degrees. Each strip determines the length of the next one.

    angle_degrees : angle of the strip to weft (0: weft, 90: warp, 45: bias)
    width : width of the strip [m]
    across : number of mesh cells over the width
    step : time step [s]

    Raises InvalidInput for values out of range, and unless the material resists bending in every
    direction. Raises SolverFailure if six strips do not suffice.
    """
    began = time.perf_counter()
    if across < 2:
        raise InvalidInput(f"cantilever: across must be at least 2 cells, got {across}")
    if not (np.isfinite(width) and width > 0):
        raise InvalidInput(f"cantilever: width must be > 0 [m], got {width}")
    weight, rigidity = (
        material.density * GRAVITY,
        strip_rigidity(material, angle_degrees=angle_degrees),
    )
    expected = overhang_of_elastica(ANGLE) * (rigidity / weight) ** (1 / 3)
    strip = _Strip(material, angle_degrees, width, across, step)
    length, at_rest, measured = expected, True, rigidity
    for strips in range(1, 7):
        hanging = _hang(strip, length, threads)
        at_rest = at_rest and hanging[1]
        measured = weight * (length / overhang_of_elastica(hanging[0])) ** 3
        length = overhang_of_elastica(ANGLE) * (measured / weight) ** (1 / 3)
        if abs(hanging[0] - ANGLE) < 0.1:
            return CantileverResult(
                angle_degrees,
                length,
                expected,
                rigidity,
                measured,
                at_rest,
                strips,
                time.perf_counter() - began,
            )
    raise SolverFailure(
        f"cantilever: one of six strips must hang at {ANGLE} degrees, got {hanging[0]:.1f} with the"
        " last one; change across or step"
    )


@takes(chord_degrees="degrees")
def overhang_of_elastica(chord_degrees: float) -> float:
    """Returns the overhang l of an elastica whose chord is inclined by `chord_degrees`, in units of
    (B / w)^(1/3) [1].

    B is the bending rigidity [N m], and w is the weight per area [N/m^2]. In these units, the
    inclination theta of the elastica satisfies theta'' = -u cos(theta), where u is the arc length
    from the free end. The boundary conditions are theta' = 0 at the free end and theta = 0 at the
    clamp.

    Raises InvalidInput for an angle outside [0.01, 87.5] degrees.

    >>> round(overhang_of_elastica(41.5), 3)
    2.0
    """
    from scipy.optimize import brentq

    if not 0.01 <= chord_degrees <= 87.5:
        raise InvalidInput(
            f"overhang_of_elastica: chord_degrees must be in [0.01, 87.5], got {chord_degrees}"
        )
    tip = brentq(
        lambda angle: _elastica(angle)[1] - np.radians(chord_degrees),
        1e-4,
        np.pi / 2 - 1e-9,
        xtol=1e-12,
    )
    return _elastica(tip)[0]


def _elastica(tip_angle: float) -> tuple[float, float]:
    """Returns the overhang and the chord angle [rad] of the elastica with a given tip angle [rad].

    The overhang is in units of (B / w)^(1/3), as in overhang_of_elastica().
    """
    from scipy.integrate import solve_ivp

    def slope(u: float, y: np.ndarray) -> list[float]:
        return [y[1], -u * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    def clamp(u: float, y: np.ndarray) -> float:
        return float(y[0])

    clamp.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (0.0, 30.0), [tip_angle, 0.0, 0.0, 0.0], events=clamp, rtol=1e-10, atol=1e-12
    )
    along, down = found.y_events[0][0][2:]
    return float(found.t_events[0][0]), float(np.arctan2(down, along))


@dataclass(frozen=True)
class _Strip:
    """A strip of fabric cut at an angle to weft.

    width : width of the strip [m]
    across : number of mesh cells over the width
    step : time step of the test [s]
    """

    material: ClothMaterial
    angle_degrees: float
    width: float
    across: int
    step: float


def _hang(strip: _Strip, length: float, threads: int) -> tuple[float, bool]:
    """Simulates a strip with an overhang of `length` [m].

    Returns the final inclination of its chord [degrees], and whether it came to rest.
    """
    cells = max(16, round(length * strip.across / strip.width))
    size = (length * (cells + 1) / cells, strip.width)
    flat = meshes.grid(size=size, cells=(cells + 1, strip.across))
    # The mesh is shifted so that the clamp, one cell long, ends at x = 0.
    vertices = flat.vertices - [
        flat.vertices[:, 0].min() + length / cells,
        0.0,
        0.0,
    ]
    turn = np.radians(strip.angle_degrees)
    weft = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    mesh = TriangleMesh(vertices, flat.triangles, vertices[:, :2] @ weft.T)
    clamped = [int(i) for i in np.flatnonzero(vertices[:, 0] < 1e-9)]
    cloth = Cloth(name="strip", mesh=mesh, material=strip.material, pins=clamped)
    scene = Scene(cloths=[cloth], collisions=False)
    simulation = Simulation(
        scene,
        integrator=SemiImplicitEuler(step=strip.step, bending="implicit", linear_solver="direct"),
        threads=threads,
    )
    rest = bring_to_rest(simulation, ratio=1e-8, drift=1e-5)
    tip = simulation.positions[vertices[:, 0] > length - 1e-9].mean(0)
    return float(np.degrees(np.arctan2(-tip[2], tip[0]))), rest.at_rest
