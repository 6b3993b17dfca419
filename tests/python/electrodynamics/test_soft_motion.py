"""Magnetisable bodies in motion: levitation, energy and momenta, and bitwise reproducibility."""

import loomstone as ls
import numpy as np
import pytest
from magnet_bodies import ball_mesh, total_momenta
from magnet_tables import cases
from scipy.optimize import brentq

M = ls.magnetics
PLATE = (0.05, 0.05, 0.0125)
BOX = (0.01, 0.008, 0.006)


def floating(case: dict, material: str, height: float) -> ls.Scene:
    """A magnet above a plate, with its moment parallel to the plate.

    This is the stable orientation above a superconductor.
    """
    volume = 4 / 3 * np.pi * case["magnet_radius"] ** 3
    mesh, density = ball_mesh(case["magnet_radius"], case["magnet_density"] * volume)
    magnet = ls.RigidBody(
        name="magnet", mesh=mesh, shape="sphere", density=density, position=(2e-4, 0, height)
    )
    plate = ls.obstacles.box(name="plate", size=PLATE, centre=(0, 0, -0.5 * PLATE[2]))
    own = M.sphere(radius=case["magnet_radius"], polarization=(case["magnet_J"], 0, 0))
    below = (
        M.soft_cuboid(size=PLATE, susceptibility=-1.0, cells=8)
        if material == "superconductor"
        else M.cuboid(size=PLATE, polarization=(-0.2, 0, 0))
    ).moved((0, 0, -0.5 * PLATE[2]))
    magnets = [ls.Magnet(body="magnet", source=own), ls.Magnet(body="plate", source=below)]
    return ls.Scene(bodies=[magnet], obstacles=[plate], magnets=magnets)


def heights(scene: ls.Scene, steps: int) -> tuple[np.ndarray, ls.Simulation]:
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3), threads=1)
    places = []
    for _ in range(steps):
        sim.step()
        places.append(sim.state.body_centres[0].copy())
    return np.array(places), sim


def resting_place(case: dict) -> tuple[float, float]:
    """Returns the equilibrium height of the magnet's centre above the superconducting plate [m] and
    the frequency of its small vertical oscillations [Hz].
    """
    plate = M.soft_cuboid(size=PLATE, susceptibility=-1, cells=8).moved((0, 0, -0.5 * PLATE[2]))
    magnet = M.sphere(radius=case["magnet_radius"], polarization=(case["magnet_J"], 0, 0))
    mass = case["magnet_density"] * 4 / 3 * np.pi * case["magnet_radius"] ** 3

    def excess(z: float) -> float:
        there = magnet.moved((0, 0, z))
        return M.force(on=there, by=M.induce(plate, by=there).bodies[0]).force[2] - 9.81 * mass

    rest = brentq(excess, 0.01, 0.02, xtol=1e-9)
    return rest, np.sqrt((excess(rest - 1e-5) - excess(rest + 1e-5)) / 2e-5 / mass) / (2 * np.pi)


def test_a_magnet_floats_above_a_superconducting_plate():
    case = next(
        c for c in cases("v_levitation_above_plane") if c["angle_from_vertical_deg"] == 90.0
    )
    rest, frequency = resting_place(case)
    # The table is for an infinite plane. The plate is only four times as wide as the height of the
    # magnet above it, so its force on the magnet is a few per cent weaker than that of the plane.
    # The force is proportional to height^-4, so the equilibrium height is lower by a quarter of
    # this percentage.
    assert rest == pytest.approx(case["equilibrium_height_of_centre"], rel=0.02)
    assert frequency == pytest.approx(case["vertical_frequency_Hz"], rel=0.035)
    places, _ = heights(floating(case, "superconductor", rest + 2e-4), 110)
    z = places[:, 2] - rest
    # The amplitude is the initial displacement of 2e-4 m.
    assert 1.5e-4 < np.abs(z).max() < 2.4e-4, "it swings about its place"
    turns = np.flatnonzero(np.diff(np.sign(z)) != 0)
    crossings = turns + z[turns] / (z[turns] - z[turns + 1])
    assert 0.5 / (np.diff(crossings).mean() * 2e-3) == pytest.approx(frequency, rel=0.01)
    assert np.abs(places[:, :2]).max() < 1e-3, "and stays above the middle"


def test_a_magnet_above_a_permanent_plate_falls_or_turns():
    case = next(
        c for c in cases("v_levitation_above_plane") if c["angle_from_vertical_deg"] == 90.0
    )
    places, _ = heights(floating(case, "magnet", case["equilibrium_height_of_centre"]), 150)
    assert np.linalg.norm(places[-1] - places[0]) > 5e-3


def iron_and_magnet() -> ls.Scene:
    """A magnet, an iron box, a superconducting ball, and a ball that magnetises as a dipole. All
    are free bodies.
    """
    box = ls.RigidBody(
        name="box",
        mesh=ls.meshes.box(size=BOX),
        shape="box",
        density=7800,
        position=(0, 0, 0.013),
    )
    magnet = ls.RigidBody(
        name="magnet", mesh=ls.meshes.box(size=(0.01, 0.01, 0.005)), shape="box", density=7500
    )
    ball = ls.meshes.sphere(radius=0.003, subdivisions=1)
    balls = [
        ls.RigidBody(name=n, mesh=ball, density=5000, position=p)
        for n, p in (("a", (0.012, 0, 0.01)), ("b", (0, 0.02, 0.01)))
    ]
    sources = {
        "box": M.soft_cuboid(size=BOX, susceptibility=1000.0, cells=8),
        "magnet": M.cuboid(size=(0.01, 0.01, 0.005), polarization=(0, 0.3, 1.0)),
        "a": M.soft_sphere(radius=0.003, susceptibility=-1.0, degree=6),
        "b": M.soft_sphere(radius=0.003, susceptibility=100.0, degree=1),
    }
    return ls.Scene(
        bodies=[box, magnet, *balls],
        gravity=(0, 0, 0),
        rigid_rebuild_interval=5,
        magnets=[ls.Magnet(body=name, source=source) for name, source in sources.items()],
    )


def test_free_bodies_keep_momenta_and_energy_and_the_same_bits():
    scene = iron_and_magnet()
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-4), threads=1)
    sim.step()
    energy = sim.report.energy.body_kinetic + sim.report.energy.magnetic
    potential = sim.report.energy.magnetic
    for _ in range(9):
        sim.step()
    kept = sim.checkpoint()
    impulse = 0.0
    for _ in range(10):
        sim.step()
        impulse += 2e-4 * np.linalg.norm(sim.magnetic_forces()[0], axis=1).sum()
    linear, angular = total_momenta(sim, scene)
    assert (
        np.linalg.norm(linear) < 1e-11 * impulse
        and np.linalg.norm(angular) < 1e-11 * impulse * 0.02
    )
    exchanged = sim.report.energy.magnetic - potential
    gained = sim.report.energy.body_kinetic + sim.report.energy.magnetic - energy
    # The bound allows for the error of the force on a box with 8 cells, and for the error of the
    # trajectory, which is of second order in the step.
    assert exchanged < 0 and abs(gained) < 5e-3 * abs(exchanged)
    other = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-4), threads=3)
    other.restore(kept)
    for _ in range(10):
        other.step()
    for name in (
        "body_centres",
        "body_orientations",
        "body_velocities",
        "body_angular_velocities",
    ):
        assert np.array_equal(getattr(other.state, name), getattr(sim.state, name)), name


def test_the_explicit_response_is_chosen_by_name():
    scene = iron_and_magnet()
    soft = scene.magnets[0]
    rough = scene.replace(
        magnets=[soft.replace(response="explicit", density=1e9), scene.magnets[1]]
    )
    true = scene.replace(magnets=[soft, scene.magnets[1]])
    forces = [ls.Simulation(s).magnetic_forces()[0][0] for s in (rough, true)]
    assert (
        forces[0] @ forces[1] > 0
        and 1.02 < np.linalg.norm(forces[0]) / np.linalg.norm(forces[1]) < 2.0
    )


SATURATED = M.soft_sphere(radius=0.003, susceptibility=10.0, saturation=1.0)
BAD = {
    "response must be mutual or explicit": dict(response="thesis"),
    "density must be > 0": dict(response="explicit"),
    "density must give at most": dict(response="explicit", density=1e16),
    "response must be mutual with a saturation, got explicit": dict(
        source=SATURATED, response="explicit", density=1e9
    ),
    "response must be mutual for a permanent magnet, got explicit": dict(
        source=M.sphere(radius=0.003, polarization=(0, 0, 1)), response="explicit", density=1e9
    ),
    "density must be 0 .* without the explicit response, got 1": dict(density=1e9),
}


@pytest.mark.parametrize("message", BAD)
def test_a_bad_soft_magnet_is_refused(message):
    scene = iron_and_magnet()
    bad = scene.magnets[0].replace(**BAD[message])
    with pytest.raises(ls.InvalidInput, match=r"magnets\[0\]\." + message):
        ls.Simulation(scene.replace(magnets=[bad, *scene.magnets[1:]]))


def test_soft_bodies_that_start_inside_each_other_are_refused():
    scene = iron_and_magnet()
    inside = scene.bodies[0].replace(position=(0, 0, 0.004))
    with pytest.raises(ls.InvalidInput, match=r"magnets\[0\] must lie apart .* magnets\[1\]"):
        ls.Simulation(scene.replace(bodies=[inside, *scene.bodies[1:]], collisions=False))


@pytest.mark.parametrize(
    ("shape", "saturation", "bound"),
    [
        ("sphere", 0.3, 2e-3),
        ("sphere", 0.05, 2e-3),
        # The bound for the rod is larger: the law of saturation holds for volume means, and over
        # the rod, the mean square of the field differs from the square of its mean.
        ("rod", 0.3, 0.1),
    ],
)
def test_saturated_iron_exchanges_energy_with_its_motion(shape, saturation, bound):
    law = {"susceptibility": 1000, "saturation": saturation}
    if shape == "sphere":
        mesh, source = ls.meshes.sphere(radius=0.005), M.soft_sphere(radius=0.005, **law)
    else:
        size = (0.004, 0.004, 0.016)
        mesh, source = ls.meshes.box(size=size), M.soft_cuboid(size=size, cells=8, **law)
    iron = ls.RigidBody(name="iron", mesh=mesh, density=7800, position=(0.004, 0.002, 0.035))
    cube = (0.02, 0.02, 0.02)
    scene = ls.Scene(
        bodies=[iron],
        obstacles=[ls.obstacles.box(name="magnet", size=cube)],
        magnets=[
            ls.Magnet(body="magnet", source=M.cuboid(size=cube, polarization=(0, 0, 1.3))),
            ls.Magnet(body="iron", source=source),
        ],
        gravity=(0, 0, 0),
    )
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=5e-4), threads=1)
    energies, kinetic = [], 0.0
    while sim.body_centres[0, 2] > 0.02:
        sim.step()
        energy = sim.report.energy
        energies.append(energy.body_kinetic + energy.magnetic)
        kinetic = max(kinetic, energy.body_kinetic)
    assert np.ptp(energies) < bound * kinetic
