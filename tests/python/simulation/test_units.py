"""Units: factors from their definitions, dimensions, and quantities in every description."""

import math

import loomstone as ls
import numpy as np
import pytest

units = ls.units


@pytest.mark.parametrize(
    "unit, si, value",
    [
        ("gf/cm", "N/m", 0.980665),  # standard gravity, exact
        ("gf cm^2/cm", "N m", 9.80665e-5),
        ("gf·cm²/cm", "N m", 9.80665e-5),
        ("gf/(cm deg)", "N/m", 0.980665 * 180 / math.pi),
        ("oz/yd^2", "kg/m^2", 0.45359237 / 16 / 0.9144**2),  # avoirdupois pound and yard, exact
        ("mg/cm^2", "kg/m^2", 0.01),
        ("g/m^2", "kg/m^2", 1e-3),
        ("gsm", "kg/m^2", 1e-3),
        ("lbf/in", "N/m", 0.45359237 * 9.80665 / 0.0254),
        ("mN mm", "N m", 1e-6),
        ("%", "1", 0.01),
        ("deg", "1", math.pi / 180),
        ("1/cm", "1/m", 100.0),
        ("cN/tex", "N m/kg", 1e4),
        ("Pa m", "N/m", 1.0),
    ],
)
def test_a_unit_is_what_its_definition_says_and_the_way_back_is_its_inverse(unit, si, value):
    assert units[unit].si == pytest.approx(value, rel=1e-12)  # a few roundings
    assert units.convert(units.convert(3.7, unit, si), si, unit) == pytest.approx(3.7, rel=1e-14)


def test_every_unit_of_the_table_converts_into_itself():
    assert len(units) > 30
    for name in units:
        assert name in units and units.convert(2.5, name, name) == 2.5


def test_numbers_and_arrays_take_a_unit_by_multiplication_from_either_side():
    assert 200 * units["gf/cm"] == units["gf/cm"] * 200 == ls.Quantity(200, "gf/cm")
    curve = np.array([0.0, 1.0, 2.0]) * units["gf/cm"]
    assert isinstance(curve, ls.Quantity) and curve.to("N/m").tolist() == [0.0, 0.980665, 1.96133]
    assert (6 * units["N"] / (2 * units["m"])).to("N/m") == 3.0
    assert (2 * units["N"] * units["cm"]).to("N m") == pytest.approx(0.02)
    assert repr(5.5 * units["oz/yd^2"]) == "5.5 oz/yd^2"


@pytest.mark.parametrize("unit", ["gf/cm deg", "gf / cm * deg"])
def test_a_product_after_a_fraction_bar_is_refused_as_ambiguous(unit):
    with pytest.raises(
        ls.InvalidInput, match=r"ambiguous; put what is below the line in parentheses"
    ):
        units[unit]


@pytest.mark.parametrize(
    "unit, said",
    [
        ("furlong", "'furlong' is not known"),
        ("gf/", "lacks a factor"),
        ("(gf", "without '\\)'"),
        ("gf)", "without '\\('"),
        ("", "must be a text"),
        ("5 gf", "not understood at '5 gf'"),
        ("m^x", "not understood"),
        (3, "must be a text"),
    ],
)
def test_what_is_no_unit_is_refused(unit, said):
    assert unit not in units
    with pytest.raises(ls.InvalidInput, match=said):
        units[unit]


def test_a_wrong_dimension_is_refused_with_both_units():
    with pytest.raises(
        ls.InvalidInput, match=r"5 gf/cm has the dimension N/m and cannot be given in kg/m\^2"
    ):
        (5 * units["gf/cm"]).to("kg/m^2")
    with pytest.raises(ls.InvalidInput, match="is no pure number"):
        float(5 * units["gf/cm"])
    assert float(50 * units["%"]) == 0.5


def test_a_description_takes_quantities_and_keeps_si():
    material = ls.ClothMaterial(
        density=5.5 * units["oz/yd^2"],
        weft_stiffness=300 * units["gf/cm"],
        shear_stiffness=1.2 * units["gf/(cm deg)"],
        bending_weft=0.08 * units["gf cm^2/cm"],
        poisson=25 * units["%"],
    )
    assert material.density == pytest.approx(5.5 * 0.0339057475, rel=1e-8)
    assert material.weft_stiffness == pytest.approx(294.1995)
    assert material.shear_stiffness == pytest.approx(1.2 * 56.18797, rel=1e-6)
    assert material.bending_weft == pytest.approx(7.84532e-6)
    assert material.poisson == pytest.approx(0.25)
    assert material.replace(density=200 * units["g/m^2"]).density == pytest.approx(0.2)
    assert ls.Cloth(thickness=0.5 * units["mm"]).thickness == 5e-4


def test_a_description_refuses_a_quantity_of_another_dimension():
    with pytest.raises(
        ls.InvalidInput,
        match=r"ClothMaterial.density must be in kg/m\^2: 5 gf/cm has the dimension N/m",
    ):
        ls.ClothMaterial(density=5 * units["gf/cm"])
    with pytest.raises(TypeError, match="ClothMaterial.bending_weft .* cannot be a str"):
        ls.ClothMaterial(density=5 * units["g/m^2"], bending_weft="soft")
    with pytest.raises(ls.InvalidInput, match="ClothMaterial.poisson must be a pure number"):
        ls.ClothMaterial(poisson=5 * units["mm"])
    with pytest.raises(ls.InvalidInput, match=r"density must be > 0"):
        ls.ClothMaterial().replace(density=-5 * units["g/m^2"])


def test_numbers_of_numpy_are_plain_numbers():
    assert ls.ClothMaterial(density=np.float32(0.25), weft_stiffness=np.int64(300)).density == 0.25


def test_quantities_of_pint_are_understood_where_it_is_installed():
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    material = ls.ClothMaterial(
        density=registry.Quantity(150, "g/m^2"), bending_weft=registry.Quantity(1e-5, "N*m")
    )
    assert material.density == pytest.approx(0.15) and material.bending_weft == pytest.approx(1e-5)
    with pytest.raises(ls.InvalidInput, match=r"ClothMaterial.density must be in kg/m\^2, got 3 m"):
        ls.ClothMaterial(density=registry.Quantity(3, "m"))
