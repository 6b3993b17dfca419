"""Units convert as defined, dimensions are checked, and scenes and materials accept quantities."""

import math
import re
import subprocess
import sys

import loomstone as ls
import numpy as np
import pint
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
        ("kG", "T", 0.1),
        ("gauss", "T", 1e-4),
        ("Oe", "A/m", 1000 / (4 * math.pi)),
        ("kOe", "A/m", 1e6 / (4 * math.pi)),
        ("MG Oe", "kJ/m^3", 100 / (4 * math.pi)),
        ("MGOe", "kJ/m^3", 100 / (4 * math.pi)),
        ("maxwell", "Wb", 1e-8),
    ],
)
def test_a_unit_is_what_its_definition_says_and_the_way_back_is_its_inverse(unit, si, value):
    si = units[si].units
    assert units[unit].to(si).magnitude == pytest.approx(value, rel=1e-12)  # a few rounding errors
    there = (3.7 * units[unit]).to(si)
    assert there.to(units[unit].units).magnitude == pytest.approx(3.7, rel=1e-14)


@pytest.mark.parametrize("name", ["gf", "tex", "dtex", "denier", "den", "gsm", "oz", "yd", "in"])
def test_every_unit_of_textiles_converts_into_itself(name):
    assert name in units and (2.5 * units[name]).to(name).magnitude == 2.5


def test_numbers_and_arrays_take_a_unit_by_multiplication_from_either_side():
    assert 200 * units["gf/cm"] == units["gf/cm"] * 200 == units.Quantity(200, "gf/cm")
    curve = np.array([0.0, 1.0, 2.0]) * units["gf/cm"]
    assert isinstance(curve, units.Quantity)
    assert curve.to("N/m").magnitude.tolist() == [0.0, 0.980665, 1.96133]
    assert (6 * units["N"] / (2 * units["m"])).to("N/m").magnitude == 3.0
    assert (2 * units["N"] * units["cm"]).to("N m").magnitude == pytest.approx(0.02)
    assert str(5.5 * units["oz/yd^2"]) == "5.5 oz / yd ** 2"


@pytest.mark.parametrize("unit", ["gf/cm deg", "gf / cm * deg"])
def test_a_product_after_a_fraction_bar_is_refused_as_ambiguous(unit):
    with pytest.raises(ls.InvalidInput, match=r"ambiguous; put the denominator in parentheses"):
        units[unit]


@pytest.mark.parametrize(
    "unit, said",
    [
        ("ell", "'ell' is not known"),
        ("gf/", "not understood"),
        ("(gf", "not understood"),
        ("gf)", "not understood"),
        ("", "must be a string"),
        ("5 gf", "'5 gf' is not understood"),
        ("m^x", "not understood"),
        (3, "must be a string"),
    ],
)
def test_what_is_no_unit_is_refused(unit, said):
    assert unit not in units
    with pytest.raises(ls.InvalidInput, match=said):
        units[unit]


def test_a_wrong_dimension_is_refused_with_both_units():
    with pytest.raises(pint.DimensionalityError, match=r"from 'force_gram / centimeter'.* to"):
        (5 * units["gf/cm"]).to("kg/m^2")
    with pytest.raises(pint.DimensionalityError):
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


def test_quantities_of_another_registry_are_understood():
    registry = pint.UnitRegistry()
    material = ls.ClothMaterial(
        density=registry.Quantity(150, "g/m^2"), bending_weft=registry.Quantity(1e-5, "N*m")
    )
    assert material.density == pytest.approx(0.15) and material.bending_weft == pytest.approx(1e-5)
    with pytest.raises(ls.InvalidInput, match=r"ClothMaterial.density must be in kg/m\^2: 3 m"):
        ls.ClothMaterial(density=registry.Quantity(3, "m"))


DESCRIPTIONS = [kind for kind in vars(ls).values() if hasattr(kind, "field_names")]
NUMBERS = [
    (kind, name)
    for kind in DESCRIPTIONS
    for name in kind.field_names
    if re.search(r"\[[^\]]+\]", getattr(kind, name).__doc__)
    and not (kind is ls.Cloth and name == "rest")
]


@pytest.mark.parametrize("kind, name", NUMBERS, ids=lambda value: getattr(value, "__name__", value))
def test_every_number_of_a_description_takes_its_unit_and_refuses_others(kind, name):
    unit = re.search(r"\[([^\]]+)\]", getattr(kind, name).__doc__)[1]
    assert unit in units
    for wrong in (1.0 * units["cd"], [1.0, 2.0, 3.0] * units["cd"]):  # no field has this unit
        said = rf"{kind.__name__}.{name} must be .*: .* has the dimension"
        with pytest.raises(ls.InvalidInput, match=said):
            kind(**{name: wrong})


def test_arrays_and_lists_of_a_description_are_converted():
    centimetres = units["cm"]
    ball = ls.RigidBody(position=(1, 2, 3) * centimetres, velocity=[1 * units["km/h"], 0, 0])
    assert ball.position == pytest.approx((0.01, 0.02, 0.03))
    assert ball.velocity == pytest.approx((1 / 3.6, 0, 0))
    moved = ls.Obstacle(
        times=[0, 500] * units["ms"], positions=[(0, 0, 0), (0, 0, 5)] * centimetres
    )
    assert moved.times == [0.0, 0.5] and moved.positions[1, 2] == pytest.approx(0.05)
    assert ls.Camera(field_of_view_degrees=0.5 * units["rad"]).field_of_view_degrees == (
        pytest.approx(np.degrees(0.5))
    )
    assert ls.Camera(field_of_view_degrees=30 * units["deg"]).field_of_view_degrees == 30.0


def test_functions_take_quantities():
    cm = units["cm"]
    assert ls.meshes.sphere(radius=5 * cm) == ls.meshes.sphere(radius=0.05)
    assert ls.grid(size=(50 * cm, 0.5), cells=(2, 2)) == ls.grid(size=(0.5, 0.5), cells=(2, 2))
    magnet = ls.magnetics.cuboid(size=(1, 1, 1) * cm, polarization=(0, 0, 1000) * units["mT"])
    plain = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    points = np.array([[0, 0, 3.0]])
    assert np.array_equal(
        ls.magnetics.field(magnet, points * cm), ls.magnetics.field(plain, points * 0.01)
    )
    assert magnet.moved((0, 0, 1) * cm).position == pytest.approx((0, 0, 0.01))
    assert magnet.rotated((0, 0, 90) * units["deg"]).orientation == pytest.approx(
        (0.5**0.5, 0, 0, 0.5**0.5)
    )
    mesh = ls.TriangleMesh(np.eye(3) * cm, [[0, 1, 2]])
    assert mesh.vertices.max() == 0.01 and mesh.moved((1, 0, 0) * cm).vertices.max() == 0.02
    query = ls.meshes.SpatialQuery(ls.meshes.sphere(radius=0.1))
    assert query.closest((0, 0, 12) * cm, 3 * cm).distance == pytest.approx(0.02, abs=1e-3)
    assert ls.meshes.mass_properties(
        ls.meshes.box(size=(1, 1, 1) * cm), 1 * units["g/cm^3"]
    ).mass == pytest.approx(1e-3)
    assert ls.garments.Plane(origin=(1 * cm, 0, 0)).origin == (0.01, 0, 0)
    with pytest.raises(
        ls.InvalidInput, match="sphere: radius must be in m: 2 kg has the dimension"
    ):
        ls.sphere(radius=2 * units["kg"])
    with pytest.raises(ls.InvalidInput, match="vertices must be in m"):
        ls.TriangleMesh(np.eye(3) * units["s"], [[0, 1, 2]])
    with pytest.raises(ls.InvalidInput, match="must be in m: 1 s has the dimension s"):
        query.closest((0, 0, 0), 1 * units["s"])


def test_a_simulation_takes_quantities(hanging):
    sim = ls.Simulation(hanging, integrator=ls.SemiImplicitEuler(step=4 * units["ms"]), threads=1)
    assert sim.step_size == 0.004
    assert len(list(sim.frames(duration=80 * units["ms"], rate=25 * units["Hz"]))) == 3
    assert sim.frame_at(80 * units["ms"]).time == pytest.approx(0.08)
    sim.velocities = np.ones((81, 3)) * units["cm/s"]
    assert sim.velocities.max() == 0.01
    sim.state.external_forces = np.ones((81, 3)) * units["mN"]
    assert sim.external_forces.max() == pytest.approx(1e-3)
    with pytest.raises(ls.InvalidInput, match="velocities must be in m/s"):
        sim.velocities = np.ones((81, 3)) * units["m"]
    with pytest.raises(ls.InvalidInput, match="frames: duration must be in s"):
        sim.frames(duration=1 * units["m"])


def test_the_registry_is_built_where_it_is_used():
    code = "import sys, loomstone; assert 'pint' not in sys.modules; loomstone.units; import pint"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_text_in_place_of_a_duration_is_refused_in_one_sentence(tmp_path):
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(2, 2)))]))
    with pytest.raises(ls.InvalidInput, match="duration must be a number, got '1'"):
        sim.run(out=tmp_path / "run", duration="1")
    with pytest.raises(ls.InvalidInput, match="rate must be a number, got None"):
        next(sim.frames(duration=0.04, rate=None))


def test_gauss_and_oersted_are_accepted_from_any_registry():
    for registry, accuracy in ((units, 1e-15), (pint.UnitRegistry(), 1e-9)):
        polarization = (0.0, 0.0, 12_000.0) * registry.gauss
        ball = ls.magnetics.sphere(radius=0.01, polarization=polarization)
        plain = ls.magnetics.sphere(radius=0.01, polarization=(0.0, 0.0, 1.2))
        assert ball.moment[2] == pytest.approx(plain.moment[2], rel=accuracy)
    with pytest.raises(ls.InvalidInput, match="polarization must be in T"):
        ls.magnetics.sphere(radius=0.01, polarization=(0.0, 0.0, 1.0) * units.oersted)
