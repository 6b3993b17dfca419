"""Figures of fields and forces, drawn by Matplotlib: slices with contour lines and arrows, force
against distance, and torque against angle.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._core import InvalidInput, MagneticBody
from ..base.arguments import takes
from ..base.figures import new_figure, save_figure
from .fields import field
from .interactions import force
from .sources import Bodies, as_list, box_of

__all__ = ["ForceCurve", "force_over_distance", "plot_curve", "plot_slice", "torque_over_angle"]

Floats = NDArray[np.float64]
PLANES = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0)}


class ForceCurve(NamedTuple):
    """Forces (n, 3) [N] on a body and torques (n, 3) about its centre [N m], at the distances (n)
    [m] or angles (n) [rad] given by `places`.
    """

    places: Floats
    forces: Floats
    torques: Floats


def unit(axis: ArrayLike) -> Floats:
    """Returns an axis, scaled to length 1.

    Raises InvalidInput unless the axis has three finite components that are not all 0.
    """
    try:
        along = np.asarray(axis, float)
    except (TypeError, ValueError):
        along = np.empty(0)
    length = float(np.linalg.norm(along))
    if along.shape != (3,) or not np.isfinite(length) or length == 0:
        raise InvalidInput(f"axis must be three finite numbers, not all zero, got {axis!r}")
    return along / length


@takes(distances="m", axis="1", tolerance="1")
def force_over_distance(
    on: MagneticBody,
    by: MagneticBody,
    distances: ArrayLike,
    *,
    axis: ArrayLike = (0.0, 0.0, 1.0),
    tolerance: float = 1e-4,
) -> ForceCurve:
    """Returns the forces and torques that `by` exerts on `on`.

    `on` is moved from its pose along an axis (3) by each of the `distances` (n) [m]. The tolerance
    and the errors raised are those of `force`.

    >>> import loomstone as ls
    >>> a = ls.magnetics.sphere(radius=0.005, polarization=(0, 0, 1))
    >>> curve = ls.magnetics.force_over_distance(a.moved((0, 0, 0.01)), a, [0.0, 0.01])
    >>> print(f"{curve.forces[0, 2] / curve.forces[1, 2]:.1f}")  # proportional to distance^-4
    16.0
    """
    along = unit(axis)
    places = np.ravel(np.asarray(distances, float))
    found = [force(on=on.moved(d * along), by=by, tolerance=tolerance) for d in places]
    return ForceCurve(places, *(np.reshape([f[k] for f in found], (-1, 3)) for k in (0, 1)))


@takes(angles="rad", axis="1", tolerance="1")
def torque_over_angle(
    on: MagneticBody,
    by: MagneticBody,
    angles: ArrayLike,
    *,
    axis: ArrayLike = (1.0, 0.0, 0.0),
    tolerance: float = 1e-4,
) -> ForceCurve:
    """Returns the forces and torques that `by` exerts on `on`.

    `on` is turned from its pose by each of the `angles` (n) [rad] about an axis (3) through its
    centre. The tolerance and the errors raised are those of `force`.
    """
    about = unit(axis)
    turns = np.ravel(np.asarray(angles, float))
    found = [force(on=on.rotated(a * about), by=by, tolerance=tolerance) for a in turns]
    return ForceCurve(turns, *(np.reshape([f[k] for f in found], (-1, 3)) for k in (0, 1)))


@takes(centre="m", extent="m")
def plot_slice(
    bodies: Bodies,
    path: str | os.PathLike[str],
    *,
    plane: Literal["xy", "xz", "yz"] = "xz",
    centre: ArrayLike | None = None,
    extent: float = 0.0,
    resolution: int = 300,
    arrows: int = 25,
    threads: int = 0,
) -> Path:
    """Draws a slice of the field B: |B| in colours, the direction as arrows, magnets in outline.

    Neighbouring contour lines differ by a factor of two. The slice is parallel to `plane` and
    passes through `centre` (3) [m] (default: the centre of a box around the bodies). extent [m]:
    half the side length of the slice (0: 0.9 times the longest edge of this box). resolution,
    arrows: number of points and of arrows along a side. threads as in `field`. Returns the path of
    the picture.

    Raises InvalidInput for values out of range, or if the field is 0 in the whole slice. Raises
    CacheError if the picture cannot be written, and Unsupported without matplotlib.
    """
    sources = as_list(bodies)
    if plane not in PLANES:
        raise InvalidInput(f"plane must be xy, xz or yz, got {plane!r}")
    if not sources or resolution < 8 or arrows < 2:
        raise InvalidInput(
            "a slice needs bodies, a resolution of at least 8 and at least 2 arrows, got"
            f" {len(sources)} bodies, a resolution of {resolution} and {arrows} arrows"
        )
    if not 0.0 <= extent < np.inf:
        raise InvalidInput(f"extent must be > 0, or 0 (automatic) [m], got {extent}")
    u, v, _ = PLANES[plane]
    low, high = box_of(sources)
    middle = 0.5 * (low + high) if centre is None else np.asarray(centre, float)
    if middle.shape != (3,) or not np.isfinite(middle).all():
        raise InvalidInput(f"centre must be three finite coordinates [m], got {middle}")
    reach = extent or 0.9 * float((high - low).max())
    if not reach > 0:
        raise InvalidInput("extent [m] must be given for bodies without one (point dipoles)")

    lattice = _Lattice(plane, middle, reach)
    figure = new_figure((7.0, 6.0))
    axes = figure.add_subplot()
    from matplotlib.ticker import LogLocator

    shown = _draw_size(axes, sources, lattice, resolution, threads)
    figure.colorbar(shown, ax=axes, label="|B| [T]", ticks=LogLocator(10, subs=(1.0, 2.0, 5.0)))
    _draw_arrows(axes, sources, lattice, arrows, threads)
    axes.set(xlabel=f"{'xyz'[u]} [mm]", ylabel=f"{'xyz'[v]} [mm]", aspect="equal")
    return save_figure(figure, path, dpi=150)


class _Lattice:
    """Square lattices of points parallel to a coordinate plane, about a centre (3) [m]."""

    def __init__(self, plane: str, middle: Floats, reach: float) -> None:
        self._axes, self._middle, self._reach = PLANES[plane], middle, reach

    def within(self, vectors: Floats) -> Floats:
        """Returns the in-plane components (k, 2) of vectors (k, 3)."""
        return np.asarray(vectors[:, list(self._axes[:2])])

    def points(self, side: int) -> tuple[Floats, Floats, Floats]:
        """Returns both in-plane coordinates, each (side, side), and the points (side^2, 3) [m]."""
        u, v, w = self._axes
        along = np.linspace(-self._reach, self._reach, side)
        a, b = np.meshgrid(self._middle[u] + along, self._middle[v] + along)
        points = np.empty((side * side, 3))
        points[:, u], points[:, v], points[:, w] = a.ravel(), b.ravel(), self._middle[w]
        return a, b, points


def _draw_size(
    axes: Any, sources: list[MagneticBody], lattice: _Lattice, side: int, threads: int
) -> Any:
    """Draws |B| in colours with contour lines, and outlines of magnets; returns the colour mesh."""
    from matplotlib.colors import LogNorm

    a, b, points = lattice.points(side)
    size = np.linalg.norm(field(sources, points, threads=threads), axis=1).reshape(a.shape)
    if not size.any():
        raise InvalidInput("bodies must have a field, but their field is 0 in the whole slice")
    size = np.clip(size, np.quantile(size[size > 0], 0.002), np.quantile(size, 0.998))
    levels = 2.0 ** np.arange(np.floor(np.log2(size.min())), np.ceil(np.log2(size.max())) + 1)
    norm = LogNorm(levels[0], levels[-1])
    shown = axes.pcolormesh(
        1e3 * a, 1e3 * b, size, norm=norm, cmap="viridis", shading="gouraud", rasterized=True
    )
    axes.contour(1e3 * a, 1e3 * b, size, levels=levels, colors="white", linewidths=0.6, alpha=0.7)
    inside = _core.magnetic_depth(sources, points).reshape(a.shape)
    if inside.max() > 0:
        axes.contour(1e3 * a, 1e3 * b, inside, levels=[0.0], colors="black", linewidths=1.6)
    return shown


def _draw_arrows(
    axes: Any, sources: list[MagneticBody], lattice: _Lattice, side: int, threads: int
) -> None:
    a, b, points = lattice.points(side)
    vectors = field(sources, points, threads=threads)
    lengths = np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
    directions = lattice.within(vectors) / lengths[:, None]
    axes.quiver(
        1e3 * a.ravel(),
        1e3 * b.ravel(),
        directions[:, 0],
        directions[:, 1],
        pivot="mid",
        color="white",
        scale=1.25 * side,
        width=0.0028,
    )


@takes()
def plot_curve(
    curve: ForceCurve, path: str | os.PathLike[str], *, kind: Literal["force", "torque"] = "force"
) -> Path:
    """Plots force against distance or torque against angle.

    Omits a component (x, y or z) if its magnitude stays below 1e-3 of the largest magnitude of any
    component. Returns the path of the picture.
    Raises InvalidInput for an empty curve or a kind other than "force" and "torque", CacheError if
    the picture cannot be written, and Unsupported without matplotlib.
    """
    if kind not in ("force", "torque"):
        raise InvalidInput(f"kind must be force or torque, got {kind!r}")
    if len(curve.places) == 0:
        raise InvalidInput("curve must have at least one place, got none")
    figure = new_figure((7.0, 4.5))
    axes = figure.add_subplot()
    values = curve.forces if kind == "force" else 1e3 * curve.torques
    places = 1e3 * curve.places if kind == "force" else np.degrees(curve.places)
    for k, name in enumerate("xyz"):
        if np.abs(values[:, k]).max() >= 1e-3 * np.abs(values).max():
            axes.plot(places, values[:, k], label=name)
    axes.axhline(0.0, color="black", linewidth=0.6)
    axes.set(
        xlabel="distance [mm]" if kind == "force" else "angle [degrees]",
        ylabel="force [N]" if kind == "force" else "torque [mN m]",
    )
    axes.grid(alpha=0.3)
    axes.legend()
    return save_figure(figure, path, dpi=150)
