"""Scenes whose fields the library Hypothesis mutates at random, for faults.py and the tests.

A mutated scene must either fail with an ls.Error whose message is one line, or be simulated with
finite positions and velocities. If cloth intersects anything, the report must say so.
"""

from __future__ import annotations

from typing import Any

import loomstone as ls
import numpy as np
from hypothesis import Phase, given, seed, settings
from hypothesis import strategies as st

COUNT = 20  # number of batches; each has 50 scenes

NUMBERS = st.one_of(
    st.sampled_from([0.0, -0.0, -1.0, 1e-300, 1e-12, 1e-3, 1.0, 1e3, 1e12, 1e300]),
    st.sampled_from([float("nan"), float("inf"), -float("inf")]),
    st.floats(1e-6, 1e6),
)
CLOTH = ("thickness", "friction")
MATERIAL = (
    "weft_stiffness",
    "warp_stiffness",
    "shear_stiffness",
    "poisson",
    "density",
    "bending_weft",
    "bending_warp",
    "viscosity_shear",
    "bending_damping",
)
INTEGRATORS = (ls.SemiImplicitEuler, ls.BackwardEuler, ls.SymplecticEuler, ls.Asynchronous)


def mostly(usual: Any, other: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Returns a strategy that yields `usual`, but draws from `other` in about one case of 8."""
    return st.integers(0, 7).flatmap(lambda k: other if k == 0 else st.just(usual))


def changes(names: tuple[str, ...], kind: type) -> st.SearchStrategy[dict[str, Any]]:
    """Returns a strategy that draws values for up to two of the fields `names` of class `kind`."""
    known = [name for name in names if name in kind.field_names]  # type: ignore[attr-defined]
    return mostly({}, st.dictionaries(st.sampled_from(known), NUMBERS, max_size=2))


MUTATIONS = st.fixed_dictionaries(
    {
        "cells": st.integers(1, 6),
        "size": mostly(0.2, NUMBERS),
        "height": st.floats(0.05, 0.2),
        "jitter": st.sampled_from([0.0, 0.0, 1e-3, 1e-2, 0.1, 1.0]),
        "pins": mostly([], st.lists(st.integers(-1, 60), max_size=4)),
        "cloth": changes(CLOTH, ls.Cloth),
        "material": changes(MATERIAL, ls.ClothMaterial),
        "gravity": mostly(9.81, NUMBERS),
        "radius": mostly(0.04, NUMBERS),
        "limit": mostly(None, NUMBERS),
        "integrator": st.sampled_from(INTEGRATORS),
        "step": mostly("auto", st.one_of(st.sampled_from([1e-5, 1e-3, 1e-2, 0.1]), NUMBERS)),
        "seed": st.integers(0, 100),
    }
)


def built(mutation: dict[str, Any]) -> ls.Simulation:
    """Returns the simulation of a mutated scene. Raises an ls.Error if the scene is refused."""
    size = mutation["size"] if 1e-3 <= mutation["size"] <= 1e3 else 0.2
    flat = ls.grid(size=(size, size), cells=(mutation["cells"],) * 2)
    shift = np.random.default_rng(mutation["seed"]).normal(size=(len(flat.vertices), 3))
    vertices = flat.vertices + mutation["jitter"] * size * shift
    mesh = ls.TriangleMesh(vertices + (0, 0, mutation["height"]), flat.triangles)
    limit = mutation["limit"]
    cloth = ls.Cloth(
        mesh=mesh,
        material=ls.ClothMaterial(**mutation["material"]),
        pins=mutation["pins"],
        strain_limit=None if limit is None else ls.StrainLimit(limit, limit, limit),
        **mutation["cloth"],
    )
    ball = ls.sphere(radius=mutation["radius"], subdivisions=1)
    scene = ls.Scene(cloths=[cloth], obstacles=[ball], gravity=(0, 0, -mutation["gravity"]))
    integrator = mutation["integrator"](step=mutation["step"])
    return ls.Simulation(scene, integrator=integrator, threads=1)


def try_mutation(mutation: dict[str, Any]) -> str:
    """Builds a mutated scene and takes two steps. Returns "refused" after an ls.Error, else
    "simulated".
    """
    try:
        sim = built(mutation)
        for _ in range(2):
            sim.step()
    except ls.Error as error:
        assert str(error) and "\n" not in str(error), str(error)
        return "refused"
    assert np.isfinite(sim.positions).all() and np.isfinite(sim.velocities).all()
    pairs = [p for p in sim.intersecting_pairs() if min(p) < len(sim.topology.triangles)]
    assert not pairs or sim.report.contacts.intersections > 0, "intersections are not reported"
    return "simulated"


def try_scene(number: int, count: int = 50) -> str:
    """Tries up to `count` scenes that the seed `number` determines. Returns their number, followed
    by the word "scenes".
    """
    seen: list[str] = []

    @seed(number)
    @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate])
    @given(MUTATIONS)
    def each(mutation: dict[str, Any]) -> None:
        seen.append(try_mutation(mutation))

    each()
    return f"{len(seen)} scenes"
