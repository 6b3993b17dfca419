"""Magnets that move so fast that their forces hardly change their paths, in long steps."""

import loomstone as ls
import numpy as np
import pytest
from magnet_bodies import ball_mesh
from scipy.constants import mu_0

M = ls.magnetics
CUBE = 0.01  # edge of the cube magnets [m]


def after(scene: ls.Scene, duration: float, step: float) -> ls.Simulation:
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    for _ in range(round(duration / step)):
        sim.step()
    return sim


@pytest.mark.parametrize("speed", [20.0, 50.0, 100.0, 1000.0])
def test_a_ball_that_flies_past_another_gives_it_the_impulse_of_a_straight_path(speed):
    radius, mass, apart = 0.004, 0.002, 0.02
    polarization, reach = 0.3, 0.2  # reach: half of the path [m]
    moment = polarization / mu_0 * 4 / 3 * np.pi * radius**3
    mesh, density = ball_mesh(radius, mass)
    bodies = [
        ls.RigidBody(name=name, mesh=mesh, density=density, shape="sphere", position=x, velocity=v)
        for name, x, v in (
            ("flying", (-reach, apart, 0), (speed, 0, 0)),
            ("waiting", (0, 0, 0), (0, 0, 0)),
        )
    ]
    source = M.sphere(radius=radius, polarization=(0, 0, polarization))
    magnets = [ls.Magnet(body=body.name, source=source) for body in bodies]
    scene = ls.Scene(bodies=bodies, magnets=magnets, gravity=(0, 0, 0))
    duration = 2 * reach / speed
    sim = after(scene, duration, duration / max(1, round(duration / 0.01)))
    # Impulse across the path if the flying ball moves along an infinite straight line. At a
    # distance r, the balls repel each other with the force 3 mu0 m^2 / (4 pi r^4).
    impulse = mu_0 * moment**2 / (np.pi * speed * apart**3)
    # At 20 m/s, the balls move apart by 0.5 % of `apart` until the end of the run. The parts of the
    # line beyond the simulated path would contribute less than 1e-4 of the impulse.
    assert mass * sim.state.body_velocities[1][1] == pytest.approx(-impulse, rel=0.01)
    assert abs(mass * sim.state.body_velocities[1][0]) < 0.02 * impulse


def rotor(spin: float, coil: bool) -> ls.Scene:
    """A magnet on a rotor, and a static coil or magnet beside the circle on which it moves."""
    cube = M.cuboid(size=(CUBE, CUBE, CUBE), polarization=(1.2, 0, 0))
    place = (0.045, 0, 0)
    mesh = ls.meshes.box(size=(0.06, 0.01, 0.01))
    body = ls.RigidBody(name="rotor", mesh=mesh, density=5000, angular_velocity=(0, 0, spin))
    stator = ls.Obstacle(name="stator", mesh=ls.meshes.box(size=(CUBE,) * 3).moved(place))
    magnets = [ls.Magnet(body="rotor", source=cube.moved((0.025, 0, 0)))]
    coils = []
    if coil:
        winding = M.solenoid(radius=0.008, length=0.008, turns=100, current=1.0)
        source = winding.rotated((0, np.pi / 2, 0)).moved(place)
        coils = [ls.Coil(body="stator", source=source, resistance=1.0)]
    else:
        magnets.append(ls.Magnet(body="stator", source=cube.moved(place)))
    return ls.Scene(
        bodies=[body],
        obstacles=[stator],
        magnets=magnets,
        coils=coils,
        bearings=[ls.Bearing(body="rotor", axis=(0, 0, 1))],
        gravity=(0, 0, 0),
    )


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_the_heat_of_an_alternator_does_not_depend_on_the_step(step):
    scene = rotor(100 * np.pi, coil=True)
    heat, finest = (after(scene, 0.04, h).report.circuits.heat for h in (step, 1e-5))
    assert heat == pytest.approx(finest, rel=0.005)


@pytest.mark.parametrize("spin", [30.0, 100 * np.pi, 1000.0])
def test_a_rotor_that_passes_a_magnet_many_times_keeps_its_energy(spin):
    scene = rotor(spin, coil=False)
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=0.01), threads=1)
    energies = []
    for _ in range(20):
        sim.step()
        energies.append(sim.report.energy.body_kinetic + sim.report.energy.magnetic)
    on_rotor, on_stator = (magnet.source for magnet in scene.magnets)
    near, far = (M.energy([on_rotor.rotated((0, 0, a)), on_stator]) for a in (0, np.pi))
    assert np.ptp(energies) < 0.05 * (far - near), "depth of the well"
