"""Fits to measured curves: synthetic curves are recovered, and invalid ones refused."""

import math

import loomstone as ls
import numpy as np
import pint
import pytest

units = ls.units
LOAD = 150 * 0.980665


def tension(stiffness, strain):
    return stiffness * (1 + strain) * ((1 + strain) ** 2 - 1) / 2


def curves(**changed):
    strain = np.linspace(0.0, 0.2, 41)
    made = {
        "weft": (strain, tension(1200.0, strain)),
        "warp": (strain, tension(3000.0, strain)),
        "shear": (strain, 70.0 * strain),
    }
    return made | changed


def test_curves_of_the_model_are_recovered_exactly_with_their_limits():
    bend = np.linspace(-250.0, 250.0, 21)
    extra = {
        f"bending_{name}": (bend, b * bend)
        for name, b in (("weft", 6e-6), ("warp", 9e-6), ("bias", 7e-6))
    }
    fabric = ls.fit_fabric(curves(**extra), density=0.15, shear_limit=0.1, name="twill")
    assert fabric.weft_stiffness == pytest.approx(
        1200, rel=1e-12
    ) and fabric.warp_stiffness == pytest.approx(3000, rel=1e-12)
    assert fabric.shear_stiffness == pytest.approx(70, rel=1e-12)
    for angle, rigidity in ((0, 6e-6), (90, 9e-6), (45, 7e-6)):
        assert ls.fabrics.strip_rigidity(fabric, angle_degrees=angle) == pytest.approx(
            rigidity, rel=1e-12
        )
    # The limits are interpolated linearly between points h = 0.005 apart. The error of the load is
    # at most h^2 / 8 times its second derivative: 9e-5 LOAD along weft and 2e-4 LOAD along warp.
    assert tension(1200, fabric.limits[0]) == pytest.approx(LOAD, rel=1e-4)
    assert tension(3000, fabric.limits[1]) == pytest.approx(LOAD, rel=1e-3)
    assert fabric.limits[2] == 0.1 and fabric.name == "twill" and fabric.caveats == ()
    assert fabric.fits["weft"].misfit < 1e-12 and fabric.fits["weft"].points == 22


def test_units_of_the_kawabata_system_give_the_same_as_si():
    strain = np.linspace(0.0, 20.0, 41)  # [%]
    angle = np.linspace(0.0, 8.0, 17)  # [degrees]
    given = {
        "weft": (strain * units["%"], tension(1200.0, strain / 100) / 0.980665 * units["gf/cm"]),
        "warp": (strain * units["%"], tension(3000.0, strain / 100) / 0.980665 * units["gf/cm"]),
        "shear": (
            angle * units["deg"],
            70.0 * np.tan(np.radians(angle)) / 0.980665 * units["gf/cm"],
        ),
    }
    fabric = ls.fit_fabric(
        given, density=15 * units["mg/cm^2"], load=150 * units["gf/cm"], shear_limit=0.1
    )
    plain = ls.fit_fabric(curves(), density=0.15, shear_limit=0.1)
    assert fabric.limits == pytest.approx(plain.limits, rel=1e-12)
    for field in ("weft_stiffness", "warp_stiffness", "shear_stiffness", "density"):
        assert getattr(fabric, field) == pytest.approx(getattr(plain, field), rel=1e-12)


def test_a_curve_that_stiffens_is_limited_at_the_load_and_fitted_below_it():
    """Uses an exponential curve, which is typical of woven fabrics.

    The limit has a closed form. The linear fit lies between the initial slope and the secant to the
    limit.
    """
    strain = np.linspace(0.0, 0.15, 601)
    fabric = ls.fit_fabric(
        curves(warp=(strain, 40.0 * np.expm1(30.0 * strain))), density=0.15, shear_limit=0.1
    )
    limit = math.log1p(LOAD / 40.0) / 30.0
    assert fabric.limits[1] == pytest.approx(limit, rel=1e-4)  # error of the linear interpolation
    assert 40 * 30 < fabric.warp_stiffness < LOAD / limit
    assert 0.02 < fabric.fits["warp"].misfit < 0.2


def test_noise_of_a_measurement_moves_the_fit_little():
    random = np.random.default_rng(1)
    strain = np.linspace(0.0, 0.2, 401)
    noisy = tension(1200.0, strain) + random.normal(0.0, 3.0, 401)
    fabric = ls.fit_fabric(curves(weft=(strain, noisy)), density=0.15, shear_limit=0.1)
    # The tolerance covers noise of 3 N/m, averaged over 210 points of about 75 N/m.
    assert fabric.weft_stiffness == pytest.approx(1200, rel=0.01)
    assert fabric.limits[0] == pytest.approx(0.106, abs=0.006)  # first noisy point above the load


def test_a_lower_load_gives_lower_limits():
    low, high = (
        ls.fit_fabric(curves(), density=0.15, shear_limit=0.1, load=load)
        for load in (98.0665, 196.133)
    )
    assert low.limits[0] < high.limits[0] and low.limits[1] < high.limits[1]


def test_the_limit_of_shear_is_the_strain_u_minus_i_of_a_simple_shear_at_the_load():
    shear = np.linspace(0.0, 1.0, 101)
    fabric = ls.fit_fabric(curves(shear=(shear, 400.0 * shear)), density=0.15)
    g = LOAD / 400.0
    c = np.array([[1.0, g], [g, 1.0 + g * g]])
    values, axes = np.linalg.eigh(c)
    assert fabric.limits[2] == pytest.approx((axes * np.sqrt(values) @ axes.T)[0, 1], rel=1e-9)


def test_a_fitted_fabric_is_simulated_and_hangs_within_what_was_measured():
    fabric = ls.fit_fabric(curves(), density=0.15, shear_limit=0.1)
    assert "bending was not measured" in fabric.caveats[0]
    assert fabric.bending_weft == ls.ClothMaterial().bending_weft
    sim = ls.Simulation(
        ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(4, 4)), material=fabric, pins=[0, 4])])
    )
    sim.step()


STRAIN = np.linspace(0.0, 0.2, 41)
GOOD = tension(1200.0, STRAIN)
BAD = [
    (
        {"weft": (STRAIN, np.where(STRAIN > 0.1, np.nan, GOOD))},
        r"weft: load 21 must be finite, got nan",
    ),
    (
        {"weft": (STRAIN[::-1], GOOD)},
        r"weft: strain must increase from point to point, got 0.2 then 0.195",
    ),
    (
        {"warp": (np.append(STRAIN, 0.1), np.append(GOOD, 50.0))},
        r"warp: strain must increase .* give only the loading branch",
    ),
    (
        {"warp": (STRAIN, 0.1 * GOOD)},
        r"warp: the curve never reaches the load of 147.1 \[N/m\], but only 31.68",
    ),
    (
        {"weft": ([0.0, 0.1, 0.2], [0.0, 100.0, 200.0])},
        r"weft: at least 4 points other than 0 must lie below the limit, got 1",
    ),
    (
        {"weft": (STRAIN, GOOD[:-1])},
        r"weft: strain and load must have the same length, got shapes \(41,\) and \(40,\)",
    ),
    (
        {"weft": (100 * STRAIN, GOOD)},
        r"weft: strain must be a pure number, got up to 20; for percent give",
    ),
    (
        {"shear": (40 * STRAIN, 70 * STRAIN)},
        r"shear: must be tan\(angle\), got up to 8; for degrees give",
    ),
    ({"weft": (STRAIN * units["mm"], GOOD)}, r"weft must be a pure number: .* has the dimension m"),
    ({"weft": (STRAIN, GOOD * units["gf"])}, r"weft must be in N/m: .* has the dimension N"),
    ({"weft": (STRAIN, GOOD + 200)}, r"weft: the curve starts above the load"),
    ({"weft": ([], [])}, r"weft must have points, got none"),
    ({"weft": 5.0}, r"weft must be a pair of arrays"),
    ({"weft": (STRAIN, ["soft"] * 41)}, r"weft must hold numbers"),
    (
        {"wefft": (STRAIN, GOOD)},
        r"there is no curve 'wefft'; known: weft, warp, shear, bending_weft",
    ),
    ({"shear": (STRAIN, -GOOD)}, r"shear: the load must increase with strain"),
    ({"bending_weft": (STRAIN, STRAIN)}, r"bending_weft and bending_warp belong together"),
    (
        {"bending_bias": (STRAIN, STRAIN)},
        r"bending_bias needs bending_weft and bending_warp too",
    ),
]


@pytest.mark.parametrize("changed, said", BAD)
def test_a_bad_curve_is_refused_in_one_sentence(changed, said):
    with pytest.raises(ls.InvalidInput, match="fit: " + said):
        ls.fit_fabric(curves(**changed), density=0.15, shear_limit=0.1)


def test_missing_curves_loads_and_limits_are_refused():
    with pytest.raises(
        ls.InvalidInput, match="shear: the curve never reaches .* give shear_limit, or a lower load"
    ):
        ls.fit_fabric(curves(), density=0.15)
    without = curves()
    del without["shear"]
    with pytest.raises(ls.InvalidInput, match="the curve 'shear' is missing"):
        ls.fit_fabric(without, density=0.15)
    with pytest.raises(ls.InvalidInput, match="load must be > 0"):
        ls.fit_fabric(curves(), density=0.15, load=-1.0)
    with pytest.raises(ls.InvalidInput, match="shear_limit must be in"):
        ls.fit_fabric(curves(), density=0.15, shear_limit=3.0)
    with pytest.raises(ls.InvalidInput, match="curves must be a dict"):
        ls.fit_fabric([1, 2], density=0.15)
    for name, wrong in (
        ("load", "a"),
        ("load", None),
        ("load", [1, 2]),
        ("density", "b"),
        ("shear_limit", "c"),
    ):
        with pytest.raises(ls.InvalidInput, match=f"fit: {name} must be a number"):
            ls.fit_fabric(curves(), **({"density": 0.15, "shear_limit": 0.1} | {name: wrong}))


def test_angles_of_pint_are_angles():
    registry, angle = pint.UnitRegistry(), np.linspace(0.0, 12.0, 25)
    load = 70.0 * np.tan(np.radians(angle))
    ours, theirs = (
        ls.fit_fabric(curves(shear=(column, load)), density=0.15, shear_limit=0.1)
        for column in (angle * units["deg"], angle * registry.degree)
    )
    assert theirs.shear_stiffness == pytest.approx(ours.shear_stiffness, rel=1e-12)
    assert theirs.shear_stiffness == pytest.approx(70.0, rel=1e-9)
