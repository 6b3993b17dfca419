"""Contacts push and never pull, and their friction obeys Coulomb's law where cloth lands."""

import loomstone as ls
import numpy as np
import pytest

SCHEMES = [
    ls.SemiImplicitEuler(),
    ls.SemiImplicitEuler(step=4e-3),
    ls.BackwardEuler(),
    ls.ImplicitMidpoint(step=4e-3),
    ls.BDF2(),
    ls.BDF2(step=4e-3),
]


def described(integrator: ls.Integrator) -> str:
    return f"{type(integrator).__name__}-{integrator.step}"


@pytest.mark.parametrize("gap", [3.6e-3, 3e-3])
@pytest.mark.parametrize("integrator", SCHEMES, ids=described)
def test_cloth_within_the_contact_distance_leaves_at_its_speed(
    integrator: ls.Integrator, gap: float
) -> None:
    sheet = ls.grid(size=(0.2, 0.2), triangles=72).moved((0.0, 0.0, gap))
    under = ls.grid(size=(0.22, 0.22), triangles=98)
    upwards = np.tile([0.0, 0.0, 1.0], (sheet.n_vertices, 1))
    leaving = ls.Cloth(name="leaving", mesh=sheet, velocities=upwards, friction=0.0, thickness=4e-3)
    held = ls.Cloth(
        name="held", mesh=under, pins=range(under.n_vertices), friction=0.0, thickness=4e-3
    )
    floor = ls.floor(height=0.0, friction=0.0)
    for below in ({"obstacles": [floor]}, {"cloths": [leaving, held]}):
        scene = ls.Scene(**({"cloths": [leaving], "gravity": (0.0, 0.0, 0.0)} | below))
        sim = ls.Simulation(scene, integrator=integrator, threads=1)
        for _ in range(3):
            sim.step()
        speed = sim.velocities[: sheet.n_vertices, 2].mean()
        # The contacts are compressed at the start, so their energy may accelerate the sheet.
        assert 0.995 < speed < 1.12 and sim.report.account.contact_balance < 0.01


def landing(integrator: ls.Integrator, height: float) -> float:
    """Returns the mean friction of a sheet that lands on a floor, divided by that of Coulomb's law.

    The sheet falls from `height` [m] and moves along the floor at 2 m/s. The impulses of friction
    and of normal forces follow from its momentum 30 ms after it meets the floor.
    """
    mu, g = 0.3, 9.81
    sheet = ls.grid(size=(0.3, 0.3), triangles=800).moved((0.0, 0.0, height))
    along = np.tile([2.0, 0.0, 0.0], (sheet.n_vertices, 1))
    cloth = ls.Cloth(mesh=sheet, material=ls.fabrics["cotton"], velocities=along, friction=mu)
    scene = ls.Scene(cloths=[cloth], obstacles=[ls.floor(friction=mu)])
    sim = ls.Simulation(scene, integrator=integrator, threads=1)
    while sim.time < np.sqrt(2.0 * height / g) + 0.03:
        sim.step()
    corners = sheet.vertices[sheet.triangles]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    masses = np.bincount(np.asarray(sheet.triangles).ravel(), np.repeat(areas, 3))
    vx, _, vz = np.average(sim.velocities, axis=0, weights=masses)
    return float((2.0 - vx) / (mu * (g * sim.time + vz)))


@pytest.mark.parametrize(
    "integrator",
    [scheme for scheme in SCHEMES if not isinstance(scheme, ls.BackwardEuler)],
    ids=described,
)
def test_friction_of_a_landing_is_that_of_coulomb(integrator: ls.Integrator) -> None:
    # The sheet can leave the floor and meet it again within one step of up to 10 ms. The friction
    # of a single landing is therefore 0.5 to 1.4 times that of Coulomb's law. With BDF-2, the mean
    # of these ratios would be 2 if the scheme kept its history after steps with contacts.
    ratios = [landing(integrator, height) for height in np.arange(0.12, 0.18, 0.01)]
    assert abs(np.mean(ratios) - 1.0) < 0.2 and max(ratios) < 1.6
