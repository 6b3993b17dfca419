"""Small scenes, an integrator and the command line, shared by several tests."""

import os

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # must precede the loading of libgomp

import loomstone as ls
import pytest
from loomstone import cli


@pytest.fixture
def hanging() -> ls.Scene:
    """A cloth of 128 triangles that hangs from two corners."""
    return ls.Scene(
        cloths=[ls.Cloth(name="cloth", mesh=ls.grid(size=(0.2, 0.2), cells=(8, 8)), pins=[0, 8])]
    )


@pytest.fixture
def falling() -> ls.Scene:
    """A cloth of 200 triangles above a sphere and a floor."""
    mesh = ls.grid(size=(0.3, 0.3), cells=(10, 10)).moved((0, 0, 0.105))
    return ls.Scene(
        cloths=[ls.Cloth(name="cloth", mesh=mesh)],
        obstacles=[ls.sphere(radius=0.1, subdivisions=2), ls.floor(height=-0.2)],
    )


@pytest.fixture
def pressed() -> ls.Scene:
    """A loose cloth of 128 triangles between plates that pass through each other in 0.02 s."""
    plates = [
        ls.Obstacle(
            name=name,
            mesh=ls.floor(size=0.3).mesh,
            thickness=2e-3,
            times=[0.0, 0.02],
            positions=[(0.001 * side, 0.002, 0.05 * side), (0, 0, -0.002 * side)],
            axis_angles=[(0, 0, 0.4 * side), (0, 0, 0)],
        )
        for name, side in (("upper", 1), ("lower", -1))
    ]
    cloth = ls.Cloth(
        name="cloth",
        mesh=ls.grid(size=(0.1, 0.1), cells=(8, 8)).moved((0, 0, 0.01)),
        thickness=2e-3,
    )
    return ls.Scene(cloths=[cloth], obstacles=plates, gravity=(0, 0, 0))


@pytest.fixture
def euler() -> ls.Integrator:
    return ls.SemiImplicitEuler(step=4e-3)


@pytest.fixture
def loomstone(capsys):
    """Function that runs loomstone in this process and returns its exit code and output."""

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.app([str(a) for a in arguments], prog_name="loomstone")
        return end.value.code, capsys.readouterr()

    return call
