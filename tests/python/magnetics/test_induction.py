"""Magnetisable spheres: reference moments, forces as derivatives of the energy, levitation, and
refused input.
"""

import importlib.util
from pathlib import Path

import loomstone as ls
import numpy as np
import pytest
from magnet_tables import each_case

M = ls.magnetics

SCENES = Path(__file__).parents[3] / "scenes"


@each_case("iv_coupled_point_spheres")
def test_moments_of_coupled_spheres_are_those_of_the_table(case):
    n = case["N"]
    found = ls.magnetics.induced_moments(
        case["positions"],
        radii=n * [case["radius"]],
        susceptibilities=n * [case["chi"]],
        applied=n * [case["B0"]],
    )
    wanted = np.array(case["moments"])
    # The default tolerance of induced_moments() is 1e-12.
    assert np.abs(found - wanted).max() < 1e-11 * np.abs(wanted).max()


def test_one_sphere_answers_with_three_chi_over_three_plus_chi():
    for chi, share in ((0.01, 0.01 / 3.01), (2.0, 0.4), (np.inf, 1.0), (-1.0, -0.5)):
        moment = ls.magnetics.induced_moments(
            [[0, 0, 0]], radii=[0.01], susceptibilities=[chi], applied=[[0, 0, 0.1]]
        )
        assert moment[0, 2] == pytest.approx(share, rel=1e-12)  # 4 pi R^3 B / mu0 is 1


def test_moments_and_fields_have_the_same_bits_on_any_number_of_threads():
    random = np.random.default_rng(8)
    points = 0.03 * np.stack(np.meshgrid(*3 * [np.arange(8)]), axis=-1).reshape(
        -1, 3
    ) + random.uniform(-0.004, 0.004, (512, 3))
    applied = random.normal(size=(512, 3))
    moments = [
        ls.magnetics.induced_moments(
            points, radii=512 * [0.01], susceptibilities=512 * [100.0], applied=applied, threads=n
        )
        for n in (1, 2, 3)
    ]
    assert np.array_equal(moments[0], moments[1]) and np.array_equal(moments[0], moments[2])
    ring = ls.magnetics.cylinder(
        radius=0.05, height=0.02, inner_radius=0.03, polarization=(0.2, 0, 1.0)
    ).moved((0.1, 0.1, 0.1))
    fields = [ls.magnetics.field([ring], points, threads=n) for n in (1, 3)]
    assert np.array_equal(fields[0], fields[1])


def test_bad_spheres_are_refused():
    good = {"radii": [0.01], "susceptibilities": [1.0], "applied": [[0, 0, 1.0]]}
    for change, message in (
        ({"radii": [-1.0]}, "radii must be > 0"),
        ({"radii": [1.0, 2.0]}, "each of the 1 points must have one radius"),
        ({"susceptibilities": [-1.1]}, "susceptibilities must be >= -1"),
        ({"susceptibilities": [np.nan]}, "susceptibilities must be >= -1"),
        ({"applied": [[0, 0, np.nan]]}, "applied must be finite"),
        ({"tolerance": 0.0}, "tolerance must be in"),
    ):
        with pytest.raises(ls.InvalidInput, match=message):
            ls.magnetics.induced_moments([[0, 0, 0]], **{**good, **change})


def soft_spheres(places: np.ndarray) -> ls.Scene:
    ball = ls.meshes.sphere(radius=0.004, subdivisions=1)
    bodies = [ls.RigidBody(name=f"{i}", mesh=ball, position=x) for i, x in enumerate(places)]
    chi = (1000.0, 5.0, -1.0)
    magnets = [
        ls.Magnet(body=f"{i}", source=M.soft_sphere(radius=0.004, susceptibility=c))
        for i, c in enumerate(chi)
    ]
    magnet = M.cuboid(size=(0.005, 0.005, 0.005), polarization=(0.3, 0.1, 1.0))
    magnets.append(ls.Magnet(body="3", source=magnet))
    return ls.Scene(
        bodies=bodies,
        magnets=magnets,
        gravity=(0, 0, 0),
        magnetic_field=(0.01, 0.02, -0.03),
        magnetic_tolerance=1e-8,
    )


PLACES = np.array([(0, 0, 0), (0.009, 0.002, 0), (0.001, 0.009, 0.003), (-0.004, -0.003, 0.009)])


def test_forces_on_spheres_that_magnetise_are_minus_the_derivatives_of_the_energy():
    forces, torques = ls.Simulation(soft_spheres(PLACES)).magnetic_forces()
    for body in range(4):
        for axis in range(3):
            step = np.zeros((4, 3))
            step[body, axis] = 2e-5  # error of central differences: (step / distance)^2 = 1e-5
            ends = [
                ls.Simulation(soft_spheres(PLACES + s * step)).report.energy.magnetic
                for s in (1, -1)
            ]
            assert -(ends[0] - ends[1]) / 4e-5 == pytest.approx(
                forces[body, axis], abs=1e-4 * np.abs(forces).max()
            )
    # Isotropic spheres feel no torque. The uniform field turns the magnet, and the counter-torque
    # acts on no body of the scene.
    assert np.abs(torques[:3]).max() < 1e-7 * np.abs(torques[3]).max()
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * np.abs(forces).max()


def levitation(material: str) -> tuple[ls.Simulation, np.ndarray]:
    spec = importlib.util.spec_from_file_location("levitation", SCENES / "levitation.py")
    scene = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scene)
    return ls.Simulation(scene.scene(material), integrator=scene.integrator), np.array(
        (0, 0, scene.balance(material))
    )


def test_a_superconductor_levitates_stably_and_a_magnet_does_not():
    for material, stays in (("superconductor", True), ("magnet", False)):
        sim, place = levitation(material)
        start = np.linalg.norm(sim.body_centres[0] - place)
        away = []
        for _ in range(400):
            sim.step()
            away.append(np.linalg.norm(sim.body_centres[0] - place))
        if stays:
            assert max(away) < 3 * start
        else:
            assert max(away) > 100 * start, "Earnshaw's theorem"


def test_what_cannot_magnetise_is_refused():
    good = {"radius": 0.004, "susceptibility": 10.0}
    for change, message in (
        ({"radius": 0.0}, "radius must be > 0"),
        ({"susceptibility": -2.0}, "susceptibility must be >= -1"),
        ({"susceptibility": 0.0}, "other than 0"),
        ({"susceptibility": -0.5, "saturation": 1.0}, "saturation must be 0"),
        ({"degree": -1}, "degree must be between 0"),
    ):
        with pytest.raises(ls.InvalidInput, match=message):
            M.soft_sphere(**{**good, **change})
    with pytest.raises(TypeError, match="MagneticBody"):
        M.cells(M.soft_sphere(**good), density=1e6)
