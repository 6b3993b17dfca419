"""Magnetic sources are compared by value, pickled, written as text, and refused if invalid."""

import json
import pickle

import loomstone as ls
import numpy as np
import pytest

M = ls.magnetics
BOX = ls.meshes.box(size=(0.01, 0.01, 0.01))
POLARIZATION = (0.1, 0.2, 1.0)


def sources() -> dict[str, ls.magnetics.MagneticBody | ls.magnetics.SoftBody]:
    """Returns one source of each kind, moved from the origin and rotated."""
    made = {
        "cuboid": M.cuboid(size=(0.01, 0.02, 0.03), polarization=POLARIZATION),
        "cylinder": M.cylinder(
            radius=0.01, height=0.02, inner_radius=0.003, polarization=POLARIZATION
        ),
        "sphere": M.sphere(radius=0.01, polarization=POLARIZATION),
        "mesh": M.mesh(ls.meshes.sphere(radius=0.01, subdivisions=1), polarization=POLARIZATION),
        "dipoles": M.dipoles([(0, 0, 0), (0.01, 0, 0)], [(1, 0, 0), (0, 1, 0)]),
        "cells": M.cells(M.cuboid(size=(0.01, 0.02, 0.03), polarization=POLARIZATION), density=1e8),
        "loop": M.loop(radius=0.01, turns=3, current=2.0),
        "solenoid": M.solenoid(radius=0.01, length=0.02, turns=7, current=0.3),
        "polyline": M.polyline([(0, 0, 0), (0.01, 0, 0), (0, 0.01, 0.03), (0, 0, 0)], current=1.0),
        "soft_sphere": M.soft_sphere(radius=0.01, susceptibility=np.inf, degree=4),
        "soft_cuboid": M.soft_cuboid(
            size=(0.01, 0.02, 0.03), susceptibility=10.0, saturation=2.0, cells=8, focus=0.002
        ),
        "soft_cylinder": M.soft_cylinder(
            radius=0.01, height=0.02, inner_radius=0.003, susceptibility=-1.0
        ),
        "soft_mesh": M.soft_mesh(
            ls.meshes.sphere(radius=0.01, subdivisions=1), susceptibility=3.0, panels=100
        ),
    }
    return {kind: s.moved((0.1, 0.2, 0.3)).rotated((0.3, 0.2, 0.1)) for kind, s in made.items()}


@pytest.mark.parametrize("kind", sources())
def test_a_source_comes_back_from_a_pickle_with_the_same_bits(kind):
    source = sources()[kind]
    copy = pickle.loads(pickle.dumps(source))
    assert copy == source and copy != source.moved((1e-9, 0, 0))
    points = np.random.default_rng(1).uniform(-0.1, 0.5, (20, 3))
    fields = [
        M.field(
            s if isinstance(s, M.MagneticBody) else M.induce(s, field=(0, 0.1, 1)).bodies[0], points
        )
        for s in (source, copy)
    ]
    assert np.array_equal(*fields) and np.abs(fields[0]).max() > 0


@pytest.mark.parametrize("kind", sources())
def test_a_source_is_written_as_its_kind_and_numbers(kind):
    source = sources()[kind]
    plain = ls.Magnet(body="a", source=source).to_dict()["source"]
    assert plain["kind"] == kind and plain["position"] == source.position.tolist()
    assert json.loads(json.dumps(plain)) == plain


def test_sources_that_differ_in_a_number_differ():
    cuboid = {"size": (0.01, 0.01, 0.01), "polarization": (0, 0, 1)}
    assert M.cuboid(**cuboid) == M.cuboid(**cuboid)
    assert M.cuboid(**cuboid) != M.cuboid(**(cuboid | {"polarization": (0, 0, 1.1)}))
    assert M.cuboid(**cuboid) != M.soft_sphere(radius=0.01, susceptibility=1.0)
    soft = M.soft_sphere(radius=0.01, susceptibility=1.0)
    assert soft != M.soft_sphere(radius=0.01, susceptibility=1.0, saturation=1.0)
    assert soft != soft.with_susceptibility(2.0)
    cells = [M.cells(M.cuboid(**cuboid), density=d) for d in (1e8, 1e8, 2e8)]
    assert cells[0] == cells[1] != cells[2]


def test_descriptions_with_sources_are_compared_pickled_and_replaced():
    magnet = ls.Magnet(body="a", source=sources()["cuboid"])
    coil = ls.Coil(body="a", source=M.loop(radius=0.01, turns=5), currents=[2.0])
    for description in (magnet, coil):
        assert pickle.loads(pickle.dumps(description)) == description
        moved = description.replace(source=description.source.moved((0.1, 0, 0)))
        assert moved != description and moved.body == "a"
        assert "source=MagneticBody(" in repr(description)
    assert ls.Magnet(body="a") != magnet and ls.Magnet(body="a").source is None


def test_results_of_induction_are_not_pickled():
    body = M.induce(sources()["soft_sphere"], field=(0, 0, 1)).bodies[0]
    with pytest.raises(ls.Unsupported, match="pickle its SoftBody and induce"):
        pickle.dumps(body)


def test_a_checkpoint_belongs_to_the_sources_of_its_scene():
    body = ls.RigidBody(name="a", mesh=BOX, shape="box")
    first = M.sphere(radius=0.004, polarization=(0, 0, 1.0))

    def simulation(source) -> ls.Simulation:
        return ls.Simulation(
            ls.Scene(bodies=[body], magnets=[ls.Magnet(body="a", source=source)], gravity=(0, 0, 0))
        )

    kept = simulation(first).checkpoint()
    simulation(M.sphere(radius=0.004, polarization=(0, 0, 1.0))).restore(kept)
    for other in (first.moved((1e-3, 0, 0)), M.sphere(radius=0.004, polarization=(0, 0, 1.1))):
        with pytest.raises(ls.CacheError, match=r"scene\.magnets"):
            simulation(other).restore(kept)


def test_several_dipoles_make_one_magnet():
    bodies = [
        ls.RigidBody(name=n, mesh=BOX, shape="box", position=p)
        for n, p in (("a", (0, 0, 0)), ("b", (0.03, 0.01, 0)))
    ]
    places, moments = [(0, 0, 0.002), (0.001, 0, -0.002)], [(0.1, 0, 0), (0, 0.2, 0.1)]
    other = ls.Magnet(body="b", source=M.sphere(radius=0.004, polarization=(0, 0.5, 1)))
    together = [ls.Magnet(body="a", source=M.dipoles(places, moments))]
    apart = [
        ls.Magnet(body="a", source=M.dipoles([(0, 0, 0)], [m]).moved(p))
        for p, m in zip(places, moments, strict=True)
    ]
    forces = [
        np.array(ls.Simulation(ls.Scene(bodies=bodies, magnets=[*m, other])).magnetic_forces())
        for m in (together, apart)
    ]
    assert np.allclose(*forces, rtol=1e-12, atol=1e-15)


def test_a_source_of_another_kind_is_refused():
    with pytest.raises(TypeError, match="Magnet.source"):
        ls.Magnet(body="a", source="cuboid")
    with pytest.raises(TypeError, match="Coil.source"):
        ls.Coil(body="a", source=M.soft_sphere(radius=0.01, susceptibility=1.0))
    with pytest.raises(TypeError, match="no field 'polarization'"):
        ls.Magnet(body="a", polarization=(0, 0, 1))
