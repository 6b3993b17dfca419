"""Small scenes that several tests use."""

import os

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # before libgomp loads

import pytest

import loomstone as ls


@pytest.fixture
def hanging() -> ls.Scene:
    """A cloth of 128 triangles that hangs from two corners."""
    return ls.Scene(cloths=[ls.Cloth(name="cloth", mesh=ls.grid(size=(0.2, 0.2), cells=(8, 8)), pins=[0, 8])])


@pytest.fixture
def falling() -> ls.Scene:
    """A cloth of 200 triangles above a sphere and a floor."""
    mesh = ls.grid(size=(0.3, 0.3), cells=(10, 10)).moved((0, 0, 0.105))
    return ls.Scene(
        cloths=[ls.Cloth(name="cloth", mesh=mesh)],
        obstacles=[ls.sphere(radius=0.1, subdivisions=2), ls.floor(height=-0.2)],
    )


@pytest.fixture
def euler() -> ls.IntegratorOptions:
    return ls.SemiImplicitEuler(step=4e-3)
