"""Wrong or implausible input for magnetics is reported in one sentence."""

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M
from magnet_sources import J, sources, tetrahedron


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: M.cuboid(size=(1, 0, 1), polarization=J), r"size must be three lengths > 0 \[m\]"),
        (
            lambda: M.cuboid(size=(1, 1, 1), polarization=(0, np.nan, 0)),
            r"polarization must be finite \[T\]",
        ),
        (lambda: M.cuboid(size=(1, 1), polarization=J), r"size must have shape \(3,\), got \(2,\)"),
        (
            lambda: M.cylinder(radius=-1, height=1, polarization=J),
            r"radius must be > 0 \[m\], got -1",
        ),
        (
            lambda: M.cylinder(radius=1, height=1, inner_radius=1, polarization=J),
            r"inner_radius must be >= 0 and below radius",
        ),
        (lambda: M.sphere(radius=0, polarization=J), r"radius must be > 0 \[m\]"),
        (
            lambda: M.mesh(ls.grid(size=(1, 1), triangles=10), polarization=J),
            r"mesh must be closed to be a magnet",
        ),
        (lambda: M.loop(radius=1, current=np.inf), r"current must be finite \[A\]"),
        (lambda: M.solenoid(radius=1, length=0, turns=3, current=1), r"length must be > 0 \[m\]"),
        (
            lambda: M.polyline([[0, 0, 0]], current=1),
            r"vertices must be at least two points, got 1",
        ),
        (lambda: M.polyline([[0, 0, 0], [0, 0, 0]], current=1), r"rows 0 and 1 are the same"),
        (
            lambda: M.polyline_gradient([[0, 0, 1]], [[0, 0, 0], [1, 0, 0]], current=1),
            r"must form a closed line",
        ),
        (
            lambda: M.dipoles([[0, 0, 0]], np.zeros((2, 3))),
            r"moments must have a row for each of the 1 points, got 2",
        ),
        (
            lambda: M.dipole_forces([[0, 0, 0]], [[0, 0, 1]], by_points=[[0, 0, 1]]),
            r"must be given together",
        ),
        (
            lambda: M.field(sources()["loop"], [[0, 0, np.nan]]),
            r"points must be finite \[m\], but row 0 is not",
        ),
        (lambda: M.field(sources()["loop"], [[0, 0]]), r"points must have shape \(n, 3\)"),
        (
            lambda: M.field(sources()["loop"], [[0, 0, 0]], quantity="D"),
            r'quantity must be "B" or "H", got "D"',
        ),
        (
            lambda: M.field(sources()["loop"], [[0, 0, 0]], threads=-1),
            r"threads must be at least 0",
        ),
        (
            lambda: sources()["loop"].at((0, 0, 0), (0, 0, 0, 0)),
            r"orientation must be a finite quaternion",
        ),
    ],
)
def test_mistakes_get_one_clear_sentence(call, message):
    with pytest.raises(ls.InvalidInput, match=message):
        call()


def test_an_inside_out_mesh_is_refused():
    mesh = tetrahedron()
    with pytest.raises(ls.InvalidInput, match="counter-clockwise seen from outside"):
        M.mesh(ls.TriangleMesh(mesh.vertices, mesh.triangles[:, ::-1]), polarization=J)


def test_bodies_of_the_wrong_kind_are_named():
    iron = M.soft_sphere(radius=0.01, susceptibility=100)
    magnet = M.sphere(radius=1, polarization=J)
    with pytest.raises(TypeError, match=r"got SoftBody.* no field until induce\(\) magnetises it"):
        M.field(iron, [[0, 0, 1]])
    with pytest.raises(TypeError, match=r"such as cuboid\(\) or loop\(\), got 1"):
        M.gradient([magnet, 1], [[0, 0, 2]])
    with pytest.raises(TypeError, match=r"such as soft_cuboid.*got MagneticBody.*belong in `by`"):
        M.induce([iron, magnet])


@pytest.mark.parametrize("value", [1200.0, -9.5e5])  # in mT or A/m instead of T
def test_a_polarization_that_no_material_has_is_reported(value):
    for make in (
        lambda: M.cuboid(size=(1, 1, 1), polarization=(0, 0, value)),
        lambda: M.cylinder(radius=1, height=1, polarization=(0, value, 0)),
        lambda: M.sphere(radius=1, polarization=(0, 0, value)),
        lambda: M.mesh(ls.meshes.box(size=(1, 1, 1)), polarization=(0, 0, value)),
    ):
        with pytest.warns(ls.SceneWarning, match="larger than that of any material") as found:
            make()
        assert found[0].filename == __file__
