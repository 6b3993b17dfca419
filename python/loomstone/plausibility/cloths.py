"""Cloths that look like a mistake: wrong units, contact at the start, pins that jump."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Cloth, Scene, TriangleMesh
from .surfaces import item

__all__ = ["of_attachments", "of_cloths", "of_contacts"]

# Numbers by which likely mistakes in cloths are recognised. All are our choice.
AREAS = 1.2  # largest ratio of start to rest, or of rest to start, for areas and for lengths [1]
LARGEST = 30.0  # largest extent of a cloth [m]
SQUARE = 1e-3  # uv fill the unit square if their bounds differ from 0 and 1 by at most this
GAP = 0.5  # smallest initial gap between cloth and a surface, as a fraction of the contact distance
AWAY = 0.1  # largest jump of a pin in the first step, as a fraction of the mean edge
SPEED = 30.0  # largest speed of a scripted pin [m/s]
LIMIT = 2.0  # smallest implausible strain limit; infinity means no limit [1]
PULLED = 1.1  # largest distance between adjacent scripted pins, as a multiple of that at the start
SCALES = {"centimetres": 0.01, "millimetres": 0.001}  # units [m] in which uv are often given


@dataclass(frozen=True)
class _Usual:
    """Plausible values of a parameter of a material, and a unit often used by mistake."""

    least: float
    most: float
    unit: str  # unit of `least` and `most`
    fabrics: str  # range in which the values of fabrics usually lie, as text
    other: str  # the unit often used by mistake
    scale: float  # value of one `other` in `unit`


_STIFFNESS = _Usual(1.0, np.inf, "N/m", "10 to 1e5", "N/mm", 1e3)
_BENDING = _Usual(0.0, 1.0, "N m", "1e-7 to 1e-3", "uN m", 1e-6)
USUAL = {
    "density": _Usual(0.0, 20.0, "kg/m^2", "0.01 to 2", "g/m^2", 1e-3),
    "weft_stiffness": _STIFFNESS,
    "warp_stiffness": _STIFFNESS,
    "bending_weft": _BENDING,
    "bending_warp": _BENDING,
}


def of_cloths(cloths: list[Cloth]) -> list[str]:
    """Returns one sentence for each property of a cloth that looks like a mistake."""
    return [
        f"{item('cloths', i, cloth.name)}: {sentence}"
        for i, cloth in enumerate(cloths)
        for sentence in (
            _size(cloth),
            _areas(cloth),
            *(_unit(cloth, name) for name in USUAL),
            _limit(cloth),
            _first_pins(cloth),
            _pins(cloth),
            _pulled(cloth),
        )
        if sentence
    ]


def of_attachments(scene: Scene) -> list[str]:
    """Returns one sentence for each cloth with a vertex that is attached to several bodies."""
    bodies: dict[tuple[str, int], list[str]] = {}
    for attachment in scene.attachments:
        for vertex in attachment.vertices:
            known = bodies.setdefault((attachment.cloth, vertex), [])
            if attachment.body not in known:
                known.append(attachment.body)
    found = []
    for cloth in dict.fromkeys(name for name, _ in bodies):
        twice = [v for (name, v), known in bodies.items() if name == cloth and len(known) > 1]
        if not twice:
            continue
        one, other = bodies[cloth, twice[0]][:2]
        more = f" (and {len(twice) - 1} more vertices to two bodies)" if len(twice) > 1 else ""
        found.append(
            f'vertex {twice[0]} of "{cloth}" is attached to "{one}" and to "{other}"{more}, which'
            " joins these bodies; attach it to one of them"
        )
    return found


def of_contacts(scene: Scene, simulation: Any) -> list[str]:
    """Returns one sentence for each pair of a cloth and a surface that start too close.

    Too close means nearer than GAP times the contact distance. The surface may be the cloth itself.
    Contacts in which all vertices of cloth are pinned or attached do not count.
    """
    vertices, distances, thicknesses = simulation.near_contacts()
    close = distances < GAP * thicknesses
    if not close.any():
        return []
    vertices, distances, thicknesses = vertices[close], distances[close], thicknesses[close]
    topology = simulation.topology
    n_cloths, n_rows = len(topology.cloth_names), len(topology.cloth_of_vertex)
    owner = np.concatenate([topology.cloth_of_vertex, topology.body_of_vertex + n_cloths])
    names = [*topology.cloth_names, *topology.body_names]
    free = np.arange(len(owner)) < n_rows
    free[_held(scene)] = False
    sides = np.sort(owner[vertices], axis=1)[:, [0, -1]]
    pushed = free[vertices].any(axis=1)
    found = []
    for one, other in np.unique(sides[pushed], axis=0):
        chosen = pushed & (sides == (one, other)).all(axis=1)
        worst = np.flatnonzero(chosen)[np.argmin(distances[chosen] / thicknesses[chosen])]
        gap, wanted = 1e3 * distances[worst], 1e3 * thicknesses[worst]
        with_what = "itself" if one == other else f'"{names[other]}"'
        found.append(
            f'"{names[one]}" starts {gap:.3g} mm from {with_what}, but the contact distance is'
            f" {wanted:.3g} mm ({chosen.sum()} such pairs of vertex and triangle or of two"
            " edges), so contacts push it away suddenly; move it, or give a smaller thickness"
        )
    return found


def _held(scene: Scene) -> NDArray[np.int64]:
    """Returns the pinned and attached vertices, numbered over all cloths."""
    held, first = [], 0
    for cloth in scene.cloths:
        tied = (a.vertices for a in scene.attachments if a.cloth == cloth.name)
        held += [first + v for vertices in (cloth.pins, *tied) for v in vertices]
        first += cloth.mesh.n_vertices
    return np.array(held, np.int64)


def _size(cloth: Cloth) -> str:
    size = float(np.ptp(np.asarray(cloth.mesh.vertices), axis=0).max())
    if size <= LARGEST:
        return ""
    return f"its mesh is {size:.4g} m long; if its file is in millimetres, scale it by 0.001"


def _areas(cloth: Cloth) -> str:
    mesh = cloth.mesh
    uv = np.asarray(mesh.uv)
    if cloth.rest != "uv" or not len(uv):
        return ""
    start = _area(np.asarray(mesh.vertices), np.asarray(mesh.triangles))
    rest = _area(np.pad(uv, ((0, 0), (0, 1))), np.asarray(mesh.uv_triangles))
    if start / AREAS <= rest <= start * AREAS:
        return _texture(mesh)
    if _size(cloth) and start / AREAS <= 1e6 * rest <= start * AREAS:
        return ""  # the mesh is in millimetres, which _size reports
    for unit, scale in SCALES.items():
        if start / AREAS <= scale**2 * rest <= start * AREAS:
            return (
                f"its rest area is {rest:.3g} m^2 (uv in metres), but its mesh starts with"
                f" {start:.3g} m^2; if uv are in {unit}, give TriangleMesh(mesh.vertices,"
                f" mesh.triangles, {scale} * mesh.uv, uv_triangles=mesh.uv_triangles)"
            )
    return (
        f"its rest area is {rest:.3g} m^2 (uv in metres), but its mesh starts with {start:.3g} m^2;"
        ' if uv are texture coordinates, give rest="mesh"'
    )


def _texture(mesh: TriangleMesh) -> str:
    """Returns a sentence if uv fill the unit square, but the mesh has other lengths, else ""."""
    uv = np.asarray(mesh.uv)
    if max(np.abs(uv.min(axis=0)).max(), np.abs(uv.max(axis=0) - 1.0).max()) > SQUARE:
        return ""
    x, flat = np.asarray(mesh.vertices)[mesh.triangles], uv[mesh.uv_triangles]
    edges, rest = ((p[:, 1:] - p[:, :1]).transpose(0, 2, 1) for p in (x, flat))
    whole = np.abs(np.linalg.det(rest)) > 0.0
    gradients = edges[whole] @ np.linalg.inv(rest[whole])
    weft, warp = np.median(np.linalg.norm(gradients, axis=1), axis=0)
    if max(weft, warp, 1.0 / weft, 1.0 / warp) <= AREAS:
        return ""
    return (
        f"its uv fill a square of 1 m, but its mesh starts with a stretch of {weft:.3g} along weft"
        f' and {warp:.3g} along warp; if uv are texture coordinates, give rest="mesh"'
    )


def _area(points: NDArray[np.float64], triangles: NDArray[np.int32]) -> float:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _unit(cloth: Cloth, name: str) -> str:
    """Returns a sentence if a parameter of the material seems to be in the wrong unit, else ""."""
    value, usual = getattr(cloth.material, name), USUAL[name]
    if value == 0.0 or usual.least <= value <= usual.most:
        return ""
    return (
        f"its {name} is {value:g} {usual.unit}, but fabrics have {usual.fabrics}; if {value:g}"
        f" {usual.other} is meant, give {usual.scale * value:g}"
    )


def _limit(cloth: Cloth) -> str:
    limit = cloth.strain_limit
    if limit is None:
        return ""
    for which, value in (
        ("along weft", limit.weft),
        ("along warp", limit.warp),
        ("in shear", limit.shear),
    ):
        if LIMIT <= value < np.inf:
            return (
                f"its strain limit {which} is {value:g}, which is {100 * value:g} %; if {value:g} %"
                f" is meant, give {value / 100:g}"
            )
    return ""


def _first_pins(cloth: Cloth) -> str:
    """Returns a sentence if pins jump to their scripted positions in the first step, else ""."""
    if not cloth.script_times:
        return ""
    times, places = _script(cloth)
    after = int(np.searchsorted(times, 0.0, side="right"))
    before, after = max(after - 1, 0), min(after, len(times) - 1)
    length = times[after] - times[before]
    share = np.clip(-times[before] / length, 0.0, 1.0) if length > 0.0 else 0.0
    begin = places[before] + share * (places[after] - places[before])
    vertices = np.asarray(cloth.mesh.vertices)[cloth.pins]
    away = np.linalg.norm(begin - vertices, axis=1)
    if not len(away) or away.max() <= AWAY * cloth.mesh.mean_edge:
        return ""
    worst = int(away.argmax())
    return (
        f"vertex {cloth.pins[worst]} jumps by {1e3 * away[worst]:.3g} mm in the first step, because"
        " script_positions begin elsewhere; begin them at the vertices"
    )


def _pins(cloth: Cloth) -> str:
    """Returns a sentence if pins jump between two times of their script, else ""."""
    if len(cloth.script_times) < 2 or not cloth.pins:
        return ""
    times, places = _script(cloth)
    moved = np.linalg.norm(np.diff(places, axis=0), axis=2)
    speeds = moved / np.diff(times)[:, None]
    if speeds.max() <= SPEED:
        return ""
    k, pin = np.unravel_index(int(speeds.argmax()), speeds.shape)
    return (
        f"vertex {cloth.pins[pin]} jumps by {moved[k, pin]:.3g} m from {times[k]:.6g} s to"
        f" {times[k + 1]:.6g} s ({speeds[k, pin]:.3g} m/s), which tears cloth; give its script more"
        " time"
    )


def _pulled(cloth: Cloth) -> str:
    """Returns a sentence if the script pulls adjacent pins apart, else ""."""
    if not cloth.script_times or len(cloth.pins) < 2:
        return ""
    times, places = _script(cloth)
    place = np.full(cloth.mesh.n_vertices, -1)
    place[cloth.pins] = np.arange(len(cloth.pins))
    triangles = place[np.asarray(cloth.mesh.triangles)]
    edges = np.unique(
        np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=0
    )
    edges = edges[(edges >= 0).all(axis=1)]
    if not len(edges):
        return ""
    vertices = np.asarray(cloth.mesh.vertices)[cloth.pins]
    start = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    ratios = np.linalg.norm(places[:, edges[:, 0]] - places[:, edges[:, 1]], axis=2) / start
    if ratios.max() <= PULLED:
        return ""
    k, edge = np.unravel_index(int(ratios.argmax()), ratios.shape)
    one, other = (cloth.pins[pin] for pin in edges[edge])
    return (
        f"the script pulls the adjacent vertices {one} and {other} apart, by"
        f" {100 * (ratios[k, edge] - 1):.3g} % at {times[k]:.6g} s; move pins like a rigid body,"
        " for instance by ls.obstacles.follow"
    )


def _script(cloth: Cloth) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns the times (k) [s] and positions (k x pins x 3) [m] of the scripted pins."""
    times = np.asarray(cloth.script_times, float)
    return times, np.reshape(cloth.script_positions, (len(times), len(cloth.pins), 3))
