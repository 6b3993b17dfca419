"""Moving magnets: momenta, energies, orders of accuracy, and trajectories from tables."""

import librations
import loomstone as ls
import numpy as np
import pytest
from loomstone import _core
from magnet_bodies import ball_mesh, quaternion, rotation_of, to_axis, total_momenta
from magnet_tables import each_case

M = ls.magnetics


def simulation(scene: ls.Scene, step: float, threads: int = 1) -> ls.Simulation:
    return ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=threads)


def dipole(moment: tuple[float, float, float]) -> ls.magnetics.MagneticBody:
    return M.dipoles([(0, 0, 0)], [moment])


def free_spheres(case: dict) -> ls.Scene:
    bodies, magnets = [], []
    for i in range(case["N"]):
        mesh, density = ball_mesh(case["radius"][i], case["mass"][i])
        turn = to_axis(case["axis0"][i])
        bodies.append(
            ls.RigidBody(
                name=f"ball {i}",
                mesh=mesh,
                density=density,
                position=case["x0"][i],
                shape="sphere",
                orientation=quaternion(turn),
                velocity=case["v0"][i],
                angular_velocity=case["omega0"][i],
            )
        )
        source = M.sphere(radius=case["radius"][i], polarization=(0, 0, case["J"][i]))
        magnets.append(ls.Magnet(body=f"ball {i}", source=source))
    return ls.Scene(bodies=bodies, magnets=magnets, gravity=(0, 0, 0))


def errors_after(case: dict, steps: int) -> tuple[float, float]:
    """Returns the largest errors of positions [m] and axes [1] at the last time of the table."""
    sim = simulation(free_spheres(case), case["times"][-1] / steps)
    for _ in range(steps):
        sim.step()
    axes = [rotation_of(q).apply([0, 0, 1]) for q in sim.state.body_orientations]
    return (
        np.abs(sim.state.body_centres - case["x"][-1]).max(),
        np.abs(np.array(axes) - case["axis"][-1]).max(),
    )


@each_case("vii_free_magnetised_spheres")
def test_free_spheres_follow_their_table_with_second_order(case):
    coarse, fine, finest = (errors_after(case, n) for n in (500, 1000, 8000))
    for k in range(2):
        assert coarse[k] / fine[k] == pytest.approx(4.0, rel=0.25), "second order"
    # Second order predicts 1/64 of the error with 1,000 steps. The factor 1.5 is a margin.
    assert finest[0] < 1.5 * fine[0] / 64 and finest[1] < 1.5 * fine[1] / 64
    assert finest[0] < 1e-7


@each_case("vii_free_magnetised_spheres")
def test_free_spheres_pass_each_other_keeping_energy_and_momenta(case):
    scene = free_spheres(case)
    sim = simulation(scene, case["times"][-1] / 4000)
    for _ in range(4000):
        sim.step()
    linear, angular = total_momenta(sim, scene)
    size = sum(m * np.linalg.norm(v) for m, v in zip(case["mass"], case["v0"], strict=True))
    assert np.linalg.norm(linear - case["P0"]) < 1e-12 * size
    assert np.linalg.norm(angular - case["L0"]) < 1e-12 * size * 0.02  # lever arms of 2 cm
    energy = sim.report.energy.body_kinetic + sim.report.energy.magnetic
    # The tolerance covers the error of second order in the step.
    assert abs(energy - case["E0"]) < 1e-5 * abs(sim.report.energy.magnetic)


def uneven_magnets() -> ls.Scene:
    """Three free bodies with magnets. One of them is a long box with three different moments of
    inertia. Two magnets are mounted on the box, off its long axis.
    """
    box, ball = (
        ls.meshes.box(size=(0.02, 0.01, 0.004)),
        ls.meshes.sphere(radius=0.004, subdivisions=1),
    )
    bodies = [
        ls.RigidBody(name="box", mesh=box, shape="box", density=7000, angular_velocity=(3, 20, -7)),
        ls.RigidBody(
            name="a", mesh=ball, density=7000, position=(0.03, 0.01, 0.0), velocity=(0, 0.02, 0.01)
        ),
        ls.RigidBody(
            name="b",
            mesh=ball,
            density=5000,
            position=(-0.03, 0.0, 0.02),
            angular_velocity=(1, 2, 3),
        ),
    ]
    sources = (
        ("box", dipole((0.02, 0, 0.01)).moved((0.008, 0.002, 0.0))),
        ("box", dipole((0, 0.02, 0.0)).moved((-0.007, 0.001, 0.001))),
        ("a", M.sphere(radius=0.004, polarization=(0.1, 0, 0))),
        ("b", M.sphere(radius=0.004, polarization=(0, 0.1, 0.1))),
    )
    magnets = [ls.Magnet(body=name, source=source) for name, source in sources]
    return ls.Scene(bodies=bodies, magnets=magnets, gravity=(0, 0, 0))


def test_free_magnets_keep_their_momenta_over_ten_thousand_steps():
    scene = uneven_magnets()
    sim = simulation(scene, 1e-5)
    linear0, angular0 = total_momenta(sim, scene)
    impulse = twist = 0.0
    for _ in range(10000):
        sim.step()
        force, torque = sim.magnetic_forces()
        impulse += 1e-5 * np.linalg.norm(force, axis=1).sum()
        twist += (
            1e-5 * (np.linalg.norm(torque, axis=1) + 0.03 * np.linalg.norm(force, axis=1)).sum()
        )
    linear, angular = total_momenta(sim, scene)
    # The tolerances are relative to the exchanged linear and angular momentum.
    assert np.linalg.norm(linear - linear0) < 1e-12 * impulse
    assert np.linalg.norm(angular - angular0) < 1e-12 * twist


def compass(case: dict, angle: float) -> ls.Scene:
    turn = np.radians(angle)
    body = ls.RigidBody(
        name="needle",
        mesh=ls.meshes.box(size=case["dim"]),
        density=case["density"],
        shape="box",
        orientation=(np.cos(turn / 2), 0, 0, np.sin(turn / 2)),
    )
    source = M.cuboid(size=case["dim"], polarization=(case["J_along_x"], 0, 0))
    needle = ls.Magnet(body="needle", source=source)
    return ls.Scene(
        bodies=[body], magnets=[needle], magnetic_field=(case["B0"], 0, 0), gravity=(0, 0, 0)
    )


def needle_angle(sim: ls.Simulation) -> float:
    w, _, _, z = sim.state.body_orientations[0]
    return 2 * np.arctan2(z, w)


@each_case("vii_compass")
def test_a_compass_swings_with_the_period_of_its_table(case):
    sim = simulation(compass(case, case["theta0_deg"]), case["period"] / 2000)
    times, angles = [0.0], [needle_angle(sim)]
    for _ in range(2000):
        sim.step()
        times.append(sim.time)
        angles.append(needle_angle(sim))
    wanted = np.array(case["theta_rad"])
    found = np.interp(case["times"], times, angles)
    # The scheme is of second order in the step h. At small angles, its phase has the relative error
    # (omega h)^2 / 24 = 4e-7, where omega is the angular frequency. This is 3e-6 rad after one
    # period. The tolerance is ten times as large.
    assert np.abs(found - wanted).max() < 3e-5 * max(1.0, np.radians(case["theta0_deg"]))


def test_the_energy_of_a_swinging_magnet_does_not_drift():
    case = {
        "dim": (0.05, 0.005, 0.001),
        "density": 7500,
        "J_along_x": 1.0,
        "B0": 5e-5,
        "period": 1.4,
    }
    # Each step has 32 sub-steps, each of 0.008 / angular frequency of the swing. There are so many
    # because the bound on the frequency assumes the smallest moment of inertia of the needle.
    sim = simulation(compass(case, 60.0), case["period"] / 25)
    # Difference in magnetic energy between the turning point at 60 degrees and the middle of the
    # swing [J].
    swing = 0.5 * 0.05 * 0.005 * 0.001 / 4e-7 / np.pi * 5e-5
    energies = []
    for _ in range(25 * 400):
        sim.step()
        energies.append(sim.report.energy.body_kinetic + sim.report.energy.magnetic)
    energies = np.array(energies)
    first, last = energies[: 25 * 40], energies[-25 * 40 :]
    assert np.ptp(energies) < 1e-2 * swing, "it oscillates by kick-drift-kick, with order 2"
    assert abs(first.mean() - last.mean()) < 1e-4 * swing, "no drift"


@pytest.mark.parametrize("what", ["compass", "pair"])
def test_magnets_that_swing_keep_their_energy_for_a_thousand_periods(what):
    """The energy changes by less than 1e-3 of the largest kinetic energy and does not drift.
    tests/benchmarks/librations.py simulates ten times as many periods. This test and the benchmark
    use default sub-steps.
    """
    swing, drift = librations.energies(*getattr(librations, what)(), 1000)
    assert swing < 1e-3 and drift < 1e-5


@each_case("vii_two_cubes_attract")
def test_two_cubes_attract_each_other_as_their_table_says(case):
    cube, gap = ls.meshes.box(size=3 * (case["cube"],)), case["gap0"]
    names = ("low", "high")
    half = 0.5 * (case["cube"] + gap)
    bodies = [
        ls.RigidBody(
            name=n, mesh=cube, shape="box", density=case["density"], position=(0, 0, s * half)
        )
        for n, s in zip(names, (-1, 1), strict=True)
    ]
    source = M.cuboid(size=3 * (case["cube"],), polarization=(0, 0, case["J"]))
    magnets = [ls.Magnet(body=n, source=source) for n in names]
    steps = 200
    sim = simulation(
        ls.Scene(bodies=bodies, magnets=magnets, gravity=(0, 0, 0)), case["time"] / steps
    )
    for _ in range(steps):
        sim.step()
    z, v = sim.state.body_centres[:, 2], sim.state.body_velocities[:, 2]
    speed = case["closing_speed"]
    # The tolerance covers a relative error of 1e-4 in the force, and the error of 200 steps, which
    # is of second order.
    assert v[0] - v[1] == pytest.approx(speed, rel=2e-3)
    assert z[1] - z[0] - case["cube"] == pytest.approx(case["gap"], abs=2e-3 * speed * case["time"])


def on_the_floor() -> ls.Scene:
    """Two balls that snap together and roll on a floor, above a magnet with scripted motion."""
    ball = ls.meshes.sphere(radius=0.005, subdivisions=2)
    bodies = [
        ls.RigidBody(name=n, mesh=ball, shape="sphere", density=7500, position=(x, 0, 0.006))
        for n, x in (("a", -0.01), ("b", 0.01))
    ]
    source = M.sphere(radius=0.005, polarization=(0.8, 0, 0.6))
    magnets = [ls.Magnet(body=n, source=source) for n in "ab"]
    carried = ls.obstacles.box(
        name="below",
        size=(0.01, 0.01, 0.01),
        times=[0, 1],
        positions=[(-0.1, 0, -0.03), (0.1, 0, -0.03)],
    )
    below = M.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1.0))
    magnets.append(ls.Magnet(body="below", source=below))
    return ls.Scene(
        bodies=bodies,
        magnets=magnets,
        obstacles=[ls.floor(size=0.4), carried],
        rigid_rebuild_interval=10,
    )


def test_threads_and_resuming_change_no_bit():
    reference = simulation(on_the_floor(), 1e-3)
    for _ in range(30):
        reference.step()
    kept = reference.checkpoint()
    for _ in range(30):
        reference.step()
    other = simulation(on_the_floor(), 1e-3, threads=3)
    other.restore(kept)
    for i in range(30):
        if i % 10 == 0:
            other.rebuild_stages()
        other.step()
    for name in (
        "body_centres",
        "body_orientations",
        "body_velocities",
        "body_angular_velocities",
    ):
        assert np.array_equal(getattr(other.state, name), getattr(reference.state, name)), name


def test_balls_that_have_snapped_together_come_to_rest():
    scene = on_the_floor().replace(magnets=on_the_floor().magnets[:2])
    sim = simulation(scene, 1e-3)
    most = 0
    for _ in range(1500):
        sim.step()
        most = max(most, sim.report.magnets.substeps)
    gap = np.linalg.norm(sim.state.body_centres[0] - sim.state.body_centres[1]) - 0.01
    assert abs(gap) < 5e-5, "they touch, with the small overlap that the rigid-body world allows"
    assert sim.state.body_centres[:, 2] == pytest.approx(0.005, abs=5e-5), "on the floor"
    assert 2 < most < 64


def iron_balls(n: int, magnet: ls.Magnet, radius: float = 0.005, **scene) -> ls.Scene:
    """A scene with the first n of 18 iron balls, which form two layers above `magnet`. `scene` has
    further fields of the scene, which must include the body or obstacle that carries the magnet.
    """
    ball, random = ls.meshes.sphere(radius=radius, subdivisions=2), np.random.default_rng(3)
    places = np.array(
        [
            (x, y, z)
            for z in (0.02, 0.032)
            for x in (-0.012, 0.0, 0.012)
            for y in (-0.012, 0.0, 0.012)
        ]
    )[:n]
    places = places + random.uniform(-1e-3, 1e-3, (n, 3))
    bodies = [
        ls.RigidBody(name=f"ball {i}", mesh=ball, shape="sphere", density=7800, position=p)
        for i, p in enumerate(places)
    ]
    iron = M.soft_sphere(radius=radius, susceptibility=1000.0, degree=1)
    magnets = [ls.Magnet(body=b.name, source=iron) for b in bodies]
    bodies += scene.pop("bodies", [])
    return ls.Scene(bodies=bodies, magnets=[magnet, *magnets], magnetic_tolerance=1e-3, **scene)


def test_iron_balls_that_fly_towards_a_free_magnet_keep_momenta_and_energy_with_second_order():
    box = ls.meshes.box(size=(0.02, 0.02, 0.01))
    carrier = ls.RigidBody(name="magnet", mesh=box, shape="box", density=7500)
    scene = iron_balls(
        8,
        ls.Magnet(body="magnet", source=M.cuboid(size=(0.02, 0.02, 0.01), polarization=(0, 0, 1))),
        bodies=[carrier],
        gravity=(0, 0, 0),
    )
    gained = []
    for steps in (10, 20):
        sim = simulation(scene.replace(magnetic_step=1.0), 4e-3 / steps)
        sim.step()
        energy, potential = (
            sim.report.energy.body_kinetic + sim.report.energy.magnetic,
            sim.report.energy.magnetic,
        )
        start, impulse = sim.time, 0.0
        linear0, angular0 = total_momenta(sim, scene)
        while sim.time < start + 3.6e-3 - 1e-9:
            sim.step()
            assert sim.report.magnets.substeps == 1
            impulse += 4e-3 / steps * np.linalg.norm(sim.magnetic_forces()[0], axis=1).sum()
        gained.append(
            (sim.report.energy.body_kinetic + sim.report.energy.magnetic - energy)
            / (sim.report.energy.magnetic - potential)
        )
        linear, angular = total_momenta(sim, scene)
        assert np.linalg.norm(linear - linear0) < 1e-12 * impulse
        assert np.linalg.norm(angular - angular0) < 1e-12 * impulse * 0.03
    assert abs(gained[1]) < 1e-2 and gained[0] / gained[1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.parametrize(
    "scene", [{}, {"magnetic_step": 1.0, "rigid_iterations": 10}], ids=["fine", "coarse"]
)
def test_iron_balls_that_stick_to_a_magnet_come_to_rest_in_few_sub_steps(scene):
    box = ls.meshes.box(size=(0.03, 0.03, 0.02))
    most = 1.1 if scene else 8.0
    # Whether a ball still rolls at the end depends on chance, so the mean of three heaps is tested.
    early, late = [], []
    for n_balls in (14, 16, 18):
        balls = iron_balls(
            n_balls,
            ls.Magnet(
                body="magnet", source=M.cuboid(size=(0.03, 0.03, 0.02), polarization=(0, 0, 1.2))
            ),
            obstacles=[ls.obstacles.mesh(box, name="magnet", friction=0.6)],
            **scene,
        )
        sim = simulation(balls, 1e-3)
        energies, totals, substeps = [], [], []
        for _ in range(400):
            sim.step()
            energy = sim.report.energy
            energies.append(energy.body_kinetic)
            totals.append(energy.body_kinetic + energy.magnetic)
            substeps.append(sim.report.magnets.substeps)
            if sim.time > 0.2:
                x = np.array(sim.state.body_centres)
                pairs = np.triu_indices(n_balls, 1)
                distances = np.linalg.norm(x[:, None] - x, axis=2)[pairs]
                assert distances.min() > 0.0098, (
                    "contacts stop bodies that meet in a step; the sweeps leave 0.1 mm of overlap"
                )
        early.append(np.mean(energies[100:200]))
        late.append(np.mean(energies[300:]))
        assert 1 <= np.mean(substeps[200:]) < most
        lowest = np.minimum.accumulate(totals[100:])
        assert np.max(totals[100:] - lowest) < 1e-3 * -totals[-1], "contacts add no energy"
    assert np.mean(late) < 0.7 * np.mean(early), "contacts add no energy"


def magnetised_ball() -> ls.magnetics.MagneticBody:
    """Returns a magnetisable ball in the magnetised state that `induce` returns."""
    ball = M.soft_sphere(radius=0.005, susceptibility=10.0)
    return M.induce(ball, field=(0, 0, 1)).bodies[0]


BAD = {
    "body must be one of the names": dict(body="c"),
    "body must be the name of the body or obstacle that carries it, got none": dict(body=""),
    "source must be a magnet or a body that magnetises, got none": dict(source=None),
    "source must be a magnet, got a loop": dict(source=M.loop(radius=0.01)),
    "source must be a magnet, got the magnetised state of a body": dict(source=magnetised_ball()),
    "source must have a moment": dict(source=M.sphere(radius=0.005, polarization=(0, 0, 0))),
    "density must be 0 .* without the explicit response": dict(density=1e6),
}


@pytest.mark.parametrize("message", BAD)
def test_a_bad_magnet_is_refused(message):
    scene = on_the_floor()
    source = M.sphere(radius=0.005, polarization=(0, 0, 1))
    magnet = ls.Magnet(body="a", source=source).replace(**BAD[message])
    with pytest.raises(ls.InvalidInput, match=r"magnets\[0\]\." + message):
        ls.Simulation(scene.replace(magnets=[magnet]))


def test_a_field_without_magnets_is_refused():
    with pytest.raises(ls.InvalidInput, match="magnetic_field must be 0 .* without magnets"):
        ls.Simulation(on_the_floor().replace(magnets=[], magnetic_field=(0, 0, 1)))


def test_point_dipoles_that_fall_into_each_other_are_reported():
    ball = ls.meshes.sphere(radius=1e-5, subdivisions=1)
    bodies = [
        ls.RigidBody(name=n, mesh=ball, position=(x, 0, 0)) for n, x in (("a", 0), ("b", 1e-4))
    ]
    magnets = [ls.Magnet(body=n, source=dipole((1, 0, 0))) for n in "ab"]
    with pytest.raises(ls.SolverFailure, match="at most 4096 sub-steps"):
        simulation(ls.Scene(bodies=bodies, magnets=magnets), 1e-3).step()


def test_a_failed_step_does_not_change_the_motion_of_bodies():
    cube, tables = (
        ls.meshes.box(size=(0.02, 0.02, 0.02)),
        ("body_centres", "body_orientations", "body_velocities"),
    )
    belt = ls.obstacles.box(
        size=(0.4, 0.4, 0.02),
        times=[0, 1],
        positions=[(0, 0, -0.01), (0.5, 0, -0.01)],
        friction=1.0,
    )
    bodies = [
        ls.RigidBody(
            name=f"cube {i}", mesh=cube, shape="box", position=p, friction=1.0, velocity=(0.5, 0, 0)
        )
        for i, p in enumerate([(0, 0, 0.01), (0, 0.1, 0.01), (0, 0.1, 0.03)])
    ]
    arm = np.array((0.5, 0, 0))  # from the stand to its dipole; keeps the stand away from the cubes
    magnets = [
        ls.Magnet(body=name, source=dipole((0, 0, 0.1)).moved(at))
        for name, at in (("cube 0", (0, 0, 0)), ("far", arm))
    ]
    stand = ls.obstacles.box(
        size=(0.01, 0.01, 0.01), name="far", times=[0, 1], positions=[(0, 0, 5.0), (0, 0, 5.0)]
    )
    reached = []
    for fails in (False, True):
        sim = simulation(ls.Scene(bodies=bodies, obstacles=[belt, stand], magnets=magnets), 1e-3)
        for _ in range(25):
            sim.step()
        near = sim.state.body_centres[0] + (0.5e-3, 0, 3e-3)
        sim.set_obstacle_pose(1, near - arm)
        sim.step()
        if fails:  # one dipole passes through the other
            before = {name: np.array(getattr(sim.state, name)) for name in tables}
            meets = (
                near
                + 1.3 * (before["body_centres"][0] - near)
                + 1e-3 * before["body_velocities"][0]
            )
            sim.set_obstacle_pose(1, meets - arm)
            with pytest.raises(ls.SolverFailure, match="at most 4096 sub-steps"):
                sim.step()
            assert all(np.array_equal(getattr(sim.state, name), before[name]) for name in tables)
        sim.set_obstacle_pose(1, (0, 0, 5.0))
        for _ in range(40):
            sim.step()
        reached.append({name: np.array(getattr(sim.state, name)) for name in tables})
    assert all(np.array_equal(reached[0][name], reached[1][name]) for name in tables), (
        "their contacts were kept"
    )


def test_poles_are_kept_in_files_and_drawn_red_and_blue(tmp_path):
    scene = on_the_floor().replace(magnets=on_the_floor().magnets[:1])
    sim = simulation(scene, 1e-3)
    pole, owner = sim.topology.body_pole, sim.topology.body_of_vertex
    assert (
        pole[owner == 0].max() > 0.9
        and pole[owner == 0].min() < -0.9
        and not pole[owner != 0].any()
    )
    north = sim.frame().body_vertices[np.argmax(pole)] - sim.body_centres[0]
    assert north @ (0.8, 0, 0.6) > 0.9 * 0.005
    writer = _core.FrameWriter(str(tmp_path), sim.topology, "")
    writer.write(sim.frame())
    del writer
    assert np.array_equal(_core.FrameReader(str(tmp_path)).topology.body_pole, pole)
    image = np.asarray(
        ls.pictures.Renderer(sim.topology, ls.RenderOptions(width=320, height=240)).render(
            sim.frame()
        )
    ).astype(int)
    red, _, blue = np.moveaxis(image, -1, 0)
    assert (red - blue > 60).sum() > 50 and (blue - red > 60).sum() > 50
