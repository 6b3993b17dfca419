"""Field lines: known shapes, seeds that share the flux equally, ends on bodies, and pictures. Also
tests forces over distance, torques over angle, and a plot of forces.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone.cli import app
from PIL import Image
from typer.testing import CliRunner

m = ls.magnetics
SPHERE = m.sphere(radius=0.001, polarization=(0, 0, 1))


def test_lines_of_a_dipole_are_r_over_sine_squared_and_errors_follow_the_tolerance():
    errors = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        found = m.field_lines(SPHERE, seeds=[[0.05, 0, 0]], extent=0.2, tolerance=tolerance)
        points = found.lines[0]
        r = np.linalg.norm(points, axis=1)
        errors.append(np.abs(r - 0.05 * (points[:, 0] / r) ** 2)[r > 0.002].max() / 0.2)
        assert found.begins == [m.LineEnd.body] and found.ends == [m.LineEnd.body]
        assert r[[0, -1]] == pytest.approx(0.001, rel=1e-9)  # on the surface
    # The bounds exceed the tolerances, because the errors of all steps add up, and because the
    # cubic interpolation between the ends of steps is of lower order.
    assert errors[0] < 1e-4 and errors[1] < 1e-5 and errors[2] < 1e-6


def test_lines_round_a_wire_are_circles_that_close():
    wire = m.polyline(
        [[0, 0, -50.0], [0, 0, 50.0], [100.0, 0, 50.0], [100.0, 0, -50.0], [0, 0, -50.0]],
        current=1.0,
    )
    found = m.field_lines(wire, seeds=[[0.01, 0, 0]], extent=0.1, tolerance=1e-7)
    radii = np.linalg.norm(found.lines[0][:, :2], axis=1)
    assert found.ends == [m.LineEnd.closed]
    # The other sides of the rectangular wire, at least 50 m away, change the field by 0.02 %.
    assert radii == pytest.approx(0.01, rel=1e-3)
    assert np.linalg.norm(np.diff(found.lines[0], axis=0), axis=1).sum() == pytest.approx(
        2 * np.pi * 0.01, rel=2e-3
    )


def test_seeds_share_the_flux():
    n = 2000
    found = m.field_lines(m.sphere(radius=0.01, polarization=(0, 0, 1)), n, length=1e-6)
    cosine = np.array([line[0, 2] for line in found.lines]) / 0.01
    # The polar cap where the cosine of the polar angle exceeds c carries the fraction 1 - c^2 of
    # the northern hemisphere's flux.
    for c in (0.9, 0.7, 0.5, 0.2):
        assert (cosine > c).sum() / n == pytest.approx(1 - c * c, abs=2.0 / np.sqrt(40 * n))


def test_every_line_of_two_magnets_leaves_north_and_enters_south_or_leaves_the_extent():
    a = m.cuboid(size=(0.01, 0.02, 0.04), polarization=(0, 0, 1))
    b = m.cylinder(radius=0.006, height=0.01, polarization=(0.5, 0, 0.5)).moved((0.03, 0, 0.01))
    found = m.field_lines([a, b], 80, threads=2)
    assert set(found.ends) <= {m.LineEnd.body, m.LineEnd.left} and m.LineEnd.body in found.ends
    again = m.field_lines([a, b], 80, threads=1)
    for x, y in zip(found.lines, again.lines, strict=True):
        assert np.array_equal(x, y)
        chords = np.diff(x, axis=0)
        unit = chords / np.linalg.norm(chords, axis=1)[:, None]
        turns = np.arccos(np.clip((unit[1:] * unit[:-1]).sum(axis=1), -1, 1))
        # Leaves out short chords, which occur at surfaces, where lines have kinks.
        long = np.linalg.norm(chords, axis=1) > 1e-4
        # The tangent turns by about 0.1 rad at most between neighbouring points. The angle between
        # successive chords is of this size; the bound leaves a margin.
        assert turns[long[1:] & long[:-1]].max(initial=0.0) < 0.3


def test_lines_of_a_solenoid_go_round_its_winding():
    found = m.field_lines(m.solenoid(radius=0.01, length=0.02, turns=100, current=1), 30)
    assert found.ends.count(m.LineEnd.closed) >= 15
    assert m.LineEnd.no_field not in found.ends + found.begins


@pytest.mark.parametrize("kind", ["cuboid", "sphere", "touching"])
def test_lines_end_on_bodies_that_magnetise_and_go_on_from_them(kind):
    magnet = m.cuboid(size=(0.01, 0.01, 0.005), polarization=(0, 0, 1.2))
    if kind == "sphere":
        soft = m.soft_sphere(radius=0.006, susceptibility=1000.0).moved((0, 0, 0.011))
    else:
        soft = m.soft_cuboid(size=(0.02, 0.02, 0.004), susceptibility=1000.0, cells=12)
        soft = soft.moved((0, 0, 0.0045 if kind == "touching" else 0.0065))
    (induced,) = m.induce(soft, by=magnet).bodies
    found = m.field_lines([magnet, induced], 60)
    assert set(found.ends) <= {m.LineEnd.body, m.LineEnd.left}
    # The surface charge of a body that magnetises does not give B inside this body. Lines that
    # continued there would have too many points.
    assert sum(map(len, found.lines)) < 100 * 60

    def at(bodies, points):
        return np.array([ls._core.magnetic_depth([body], points) for body in bodies]) > -1e-6

    first, last = (
        at([magnet, induced], np.array([line[k] for line in found.lines])) for k in (0, -1)
    )
    assert (first[0] | first[1]).all(), "all begin on one of the two"
    assert (first[0] & last[1]).any() or kind == "touching", "some go from the magnet into the iron"
    assert (first[1] & last[0]).any(), "and come back from there"


def test_lines_do_not_wind_along_the_borders_of_panels():
    # Close to large panels, the computed field would guide lines along the borders of panels. Lines
    # must end at the surface instead.
    magnet = m.cuboid(size=(0.01, 0.01, 0.005), polarization=(0, 0, 1.2))
    iron = m.soft_cuboid(size=(0.02, 0.02, 0.004), susceptibility=1000.0, cells=8)
    (induced,) = m.induce(iron.moved((0, 0, 0.0065)), by=magnet).bodies
    found = m.field_lines([magnet, induced], 60)
    assert set(found.ends) <= {m.LineEnd.body, m.LineEnd.left}
    ends = np.array([line[-1] for line in found.lines])
    depths = np.maximum(*(ls._core.magnetic_depth([b], ends) for b in (magnet, induced)))
    inside = np.array([end == m.LineEnd.body for end in found.ends])
    assert np.abs(depths[inside]).max() < 1e-9  # lines that end on a body end on its surface


def test_bad_requests_are_refused():
    for change, message in (
        ({"lines": 0}, "lines must be at least 1"),
        ({"tolerance": 1.0}, "tolerance of field lines"),
        ({"extent": -1.0}, "extent"),
        ({"length": np.inf}, "length .* must be finite .* got 0 and inf"),
        ({"seeds": [[np.nan, 0, 0]]}, "seeds"),
        ({"seeds": np.zeros((0, 3))}, "seeds .* at least one point"),
    ):
        with pytest.raises(ls.InvalidInput, match=message):
            m.field_lines(SPHERE, **change)
    point = m.dipoles([[0, 0, 0]], [[0, 0, 1.0]])
    with pytest.raises(ls.InvalidInput, match="to begin at"):
        m.field_lines(point)
    with pytest.raises(ls.InvalidInput, match="extent .* must be > 0"):
        m.field_lines(point, seeds=[[0.01, 0, 0]])
    with pytest.raises(ls.InvalidInput, match="plane must be"):
        m.plot_slice(SPHERE, "never.png", plane="zz")


def test_a_slice_without_a_suffix_is_a_png(tmp_path):
    path = m.plot_slice(SPHERE, tmp_path / "slice", resolution=20, arrows=4)
    assert path == tmp_path / "slice.png" and path.exists()


def test_a_frame_gives_the_poses_of_its_magnets_and_draws_their_lines(tmp_path):
    mesh = ls.meshes.box(size=(0.01, 0.01, 0.02))
    bar = ls.RigidBody(
        name="bar", mesh=mesh, shape="box", position=(0.02, 0, 0), angular_velocity=(0, 30.0, 0)
    )
    ball = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.005, subdivisions=2),
        shape="sphere",
        position=(0, 0, 0.02),
    )
    magnets = [
        ls.Magnet(body="bar", source=m.cuboid(size=(0.01, 0.01, 0.02), polarization=(0, 0, 1))),
        ls.Magnet(body="ball", source=m.soft_sphere(radius=0.005, susceptibility=100.0)),
    ]
    sim = ls.Simulation(
        ls.Scene(bodies=[bar, ball], magnets=magnets, gravity=(0, 0, 0)),
        integrator=ls.SemiImplicitEuler(step=1e-3),
    )
    for _ in range(20):
        sim.step()
    frame = sim.frame()
    placed = sim.magnets(frame)
    assert placed[0].position == pytest.approx(sim.state.body_centres[0], abs=1e-12)
    assert np.abs(placed[0].orientation @ sim.state.body_orientations[0]) == pytest.approx(
        1.0, abs=1e-12
    )
    assert placed[1].radius == 0.005
    alone = m.field(placed[0], [placed[1].position])[0]
    share = 3 * 100 / 103 * 4 / 3 * np.pi * 0.005**3 / m.MU0
    # With the default magnetic_tolerance, the relative tolerance of induced moments is 1e-6. The
    # bound is ten times as large.
    assert placed[1].moment == pytest.approx(share * alone, rel=1e-5)

    options = ls.RenderOptions(width=160, height=120, samples=1, field_lines=30)
    renderer = ls.pictures.Renderer(sim.topology, options)
    without = renderer.render(frame)
    curves = m.frame_curves(sim, frame, 30)
    with_lines = renderer.render(frame, curves)
    assert (with_lines != without).any(axis=2).mean() > 0.02, "lines cover a part of the picture"
    assert np.array_equal(renderer.render(frame), without), "and leave nothing behind"


def test_the_command_draws_any_closed_mesh(tmp_path):
    mesh = tmp_path / "ball.obj"
    ls.meshes.write(mesh, ls.meshes.sphere(radius=0.01, subdivisions=1))
    out, cut, curve = (tmp_path / f"{name}.png" for name in ("field", "slice", "force"))
    done = CliRunner().invoke(
        app, ["field", str(mesh), "--lines", "12", "--out", str(out), "--slice", str(cut)]
    )
    assert done.exit_code == 0, done.output
    assert "12 field lines" in done.output
    done = CliRunner().invoke(
        app, ["plot", "force", "--mesh", str(mesh), "--reach", "0.01", "--out", str(curve)]
    )
    assert done.exit_code == 0, done.output
    for path in (out, cut, curve):
        assert np.asarray(Image.open(path)).std() > 5
    assert CliRunner().invoke(app, ["field", str(mesh), "--polarization", "up"]).exit_code == 2


@pytest.mark.parametrize("reach", ["-1", "nan", "inf"])
def test_the_reach_of_a_curve_must_be_a_distance(loomstone, tmp_path, reach):
    ls.meshes.write(tmp_path / "ball.obj", ls.meshes.sphere(radius=0.01, subdivisions=1))
    code, said = loomstone("plot", "force", "--mesh", tmp_path / "ball.obj", "--reach", reach)
    assert code == 1 and "--reach must be at least 0 m and finite, got " + reach in said.err


def test_forces_over_distance_and_angle_are_those_of_dipoles():
    a = m.sphere(radius=0.005, polarization=(0, 0, 1))
    curve = m.force_over_distance(a.moved((0, 0, 0.01)), a, [0.0, 0.01, 0.02])
    assert curve.forces[:, 2] == pytest.approx(
        curve.forces[0, 2] / np.array([1, 2, 3]) ** 4, rel=1e-12
    )
    turned = m.torque_over_angle(a.moved((0, 0, 0.02)), a, np.radians([0, 30, 90]), axis=(1, 0, 0))
    assert turned.torques[:, 0] / turned.torques[2, 0] == pytest.approx([0, 0.5, 1], abs=1e-12)


def test_a_path_needs_a_direction():
    ball = ls.magnetics.sphere(radius=0.01, polarization=(0, 0, 1))
    for axis in ((0, 0, 0), (0, 1), (0, 0, np.nan), "z", None, [0, [1]]):
        with pytest.raises(ls.InvalidInput, match="axis must be three finite numbers"):
            ls.magnetics.force_over_distance(ball.moved((0, 0, 0.03)), ball, [0.0], axis=axis)
        with pytest.raises(ls.InvalidInput, match="axis must be three finite numbers"):
            ls.magnetics.torque_over_angle(ball.moved((0, 0, 0.03)), ball, [0.0], axis=axis)


def test_pictures_show_the_lines_of_small_magnets_far_apart():
    ball = ls.meshes.sphere(radius=0.001, subdivisions=2)
    places = {"a": (0, 0, 0), "b": (10.0, 0, 0)}
    bodies = [
        ls.RigidBody(name=n, mesh=ball, shape="sphere", position=p) for n, p in places.items()
    ]
    magnet = m.sphere(radius=0.001, polarization=(0, 0, 1.2))
    magnets = [ls.Magnet(body=n, source=magnet) for n in places]
    sim = ls.Simulation(ls.Scene(bodies=bodies, magnets=magnets), threads=1)
    assert ls.magnetics.frame_curves(sim, sim.frame(), 10) is not None


def test_lines_at_a_soft_cylinder_end_instead_of_winding_along_its_panels():
    magnet = ls.magnetics.cylinder(radius=0.01, height=0.005, polarization=(0, 0, 1.3)).moved(
        (0, 0, 0.012)
    )
    soft = ls.magnetics.soft_cylinder(radius=0.01, height=0.012, susceptibility=1000)
    iron = ls.magnetics.induce(soft, by=magnet).bodies[0]
    found = ls.magnetics.field_lines([magnet, iron], 100)
    ends = [end.name for end in found.ends]
    assert "length" not in ends and ends.count("body") >= 75
    assert sum(map(len, found.lines)) < 40_000  # 208,000 if lines go on until the last step
