"""Descriptions such as ls.Cloth are frozen and compare by value. Errors name the invalid field."""

from pathlib import Path

import loomstone as ls
import numpy as np
import pytest
from loomstone import _core
from loomstone.integrators import with_method

ALL = [
    ls.ClothMaterial,
    ls.Cloth,
    ls.Obstacle,
    ls.Attachment,
    ls.Air,
    ls.Scene,
    ls.SemiImplicitEuler,
    ls.BackwardEuler,
    ls.ImplicitMidpoint,
    ls.NonlinearMidpoint,
    ls.BDF2,
    ls.LimitOptions,
    ls.RigidBody,
    ls.Camera,
    ls.RenderOptions,
]


@pytest.mark.parametrize("description", ALL)
def test_every_description_can_be_made_without_arguments_compared_and_listed(description):
    made = description()
    assert made == description()
    assert not made != description()  # noqa: SIM202
    assert repr(made) == f"{description.__name__}()"
    assert list(made.to_dict()) == list(description.field_names)
    assert made.replace() == made


@pytest.mark.parametrize("description", ALL)
def test_every_field_can_be_read_says_what_it_means_and_cannot_be_written(description):
    made = description()
    for name in description.field_names:
        assert getattr(description, name).__doc__
        with pytest.raises(AttributeError):
            setattr(made, name, getattr(made, name))


def test_units_limits_and_defaults_come_from_the_core():
    assert ls.ClothMaterial.density.__doc__ == "mass per area [kg/m^2]; > 0; default 0.3"


def test_a_misspelt_field_is_refused_and_the_right_one_named():
    with pytest.raises(
        TypeError, match="ClothMaterial has no field 'dencity'; did you mean 'density'"
    ):
        ls.ClothMaterial(dencity=0.3)
    with pytest.raises(TypeError, match="Air has no field 'gustt'; did you mean 'gust'"):
        ls.Air().replace(gustt=0.5)
    with pytest.raises(TypeError, match="known: .*wind"):
        ls.Air(foo=1)


def test_a_number_outside_its_limits_is_refused():
    with pytest.raises(
        ls.InvalidInput, match=r"ClothMaterial.density must be > 0 \[kg/m\^2\], got -1"
    ):
        ls.ClothMaterial(density=-1)
    with pytest.raises(ls.InvalidInput, match="poisson must be in"):
        ls.ClothMaterial().replace(poisson=3.0)
    with pytest.raises(ls.InvalidInput, match="density"):
        ls.ClothMaterial(density=float("nan"))


def test_an_array_of_the_wrong_shape_is_refused_with_its_shape():
    with pytest.raises(
        ls.InvalidInput, match=r"Air.wind must be numbers of shape \(3,\), got shape \(2,\)"
    ):
        ls.Air(wind=(1, 2))
    with pytest.raises(
        ls.InvalidInput, match=r"velocities must be numbers of shape \(n, 3\), got shape \(1, 2\)"
    ):
        ls.Cloth(velocities=[[0, 1]])


def test_a_value_of_the_wrong_kind_is_refused_with_what_is_wanted():
    with pytest.raises(
        TypeError, match=r"ClothMaterial.density \(mass per area .* cannot be a str"
    ):
        ls.ClothMaterial(density="heavy")


GRID = ls.grid(cells=(2, 2))


@pytest.mark.parametrize(
    "mistake, said",
    [
        (lambda: ls.ClothMaterial(0.3), r"ClothMaterial takes keyword arguments only, as in .*0.3"),
        (
            lambda: ls.Scene([ls.Cloth()]),
            r"Scene takes keyword arguments only, as .*\(cloths",
        ),
        (
            lambda: ls.BDF2(1e-3),
            r"BDF2 takes keyword arguments only, as in BDF2\(step",
        ),
        (
            lambda: ls.StrainLimit(0.1, 0.2, 0.3, 0.4),
            "StrainLimit takes at most 3 arguments without a keyword, .* got 0.4 without one",
        ),
        (lambda: ls.StrainLimit(0.1, weft=0.2), "StrainLimit must get weft once, got it with and"),
        (
            lambda: ls.Cloth(material="cotton"),
            r"Cloth.material must be a ClothMaterial, got the str 'cotton'; a fabric is"
            r" loomstone.fabrics\['cotton'\]",
        ),
        (
            lambda: ls.Cloth(mesh="a.obj"),
            r"Cloth.mesh must be a TriangleMesh, got the str 'a.obj'; read the file with"
            r" loomstone.meshes.read\(path\)$",
        ),
        (
            lambda: ls.Obstacle(mesh=Path("a.obj")),
            r"Obstacle.mesh must be a TriangleMesh, got the PosixPath .*; read the file with",
        ),
        (
            lambda: ls.RigidBody(mesh=[[0, 0, 0]]),
            r"RigidBody.mesh must be a TriangleMesh, got the list .*; create one with"
            r" TriangleMesh\(vertices, triangles\), or read a file with"
            r" loomstone.meshes.read\(path\)",
        ),
        (lambda: ls.Scene(air=3), "Scene.air must be an Air, got the int 3"),
        (
            lambda: ls.Scene(cloths=[ls.Cloth(), GRID]),
            r"Scene.cloths\[1\] must be a Cloth, got the TriangleMesh",
        ),
        (lambda: ls.Scene(cloths=[None]), r"Scene.cloths\[0\] must be a Cloth, got None"),
        (
            lambda: ls.Scene(cloths=ls.Cloth()),
            r"Scene.cloths must be a list of Cloth, got the Cloth Cloth\(\); put it into a list",
        ),
        (
            lambda: ls.Cloth(pins=[0, 1.5]),
            r"Cloth.pins\[1\] must be a whole number, got the float 1.5",
        ),
        (
            lambda: ls.Cloth(pins=3),
            "pins must be a list of whole numbers, got the int 3; put",
        ),
        (lambda: ls.Cloth(pins=["a"]), r"Cloth.pins\[0\] must be a whole number, got the str 'a'"),
        (
            lambda: ls.Cloth(script_times=[0, "b"]),
            r"script_times\[1\] must be a number, got",
        ),
    ],
)
def test_arguments_of_the_wrong_type_are_one_sentence(mistake, said):
    with pytest.raises(TypeError, match=said) as told:
        mistake()
    assert "\n" not in str(told.value)


def test_the_first_limits_of_strain_may_be_given_by_position():
    assert ls.StrainLimit(0.1, 0.2, shear=0.3) == ls.StrainLimit(weft=0.1, warp=0.2, shear=0.3)


def test_lists_tuples_and_arrays_are_the_same_to_a_field():
    assert (
        ls.Air(wind=[1, 2, 3]) == ls.Air(wind=(1, 2, 3)) == ls.Air(wind=np.array([1.0, 2.0, 3.0]))
    )
    assert ls.Cloth(pins=np.array([1, 2])).pins == [1, 2]


def test_descriptions_with_equal_meshes_are_equal_and_others_are_not():
    one, same = (ls.Cloth(mesh=ls.grid(cells=(2, 2))) for _ in range(2))
    assert one == same
    assert one != same.replace(mesh=ls.grid(cells=(2, 3)))
    assert ls.Scene(cloths=[one]) == ls.Scene(cloths=[same]) != ls.Scene()


def test_repr_shows_what_differs_from_the_default():
    assert repr(ls.ClothMaterial(density=0.2)) == "ClothMaterial(density=0.2)"
    assert "material=ClothMaterial(density=0.2)" in repr(
        ls.Cloth(material=ls.ClothMaterial(density=0.2))
    )


def test_a_description_is_not_changed_by_writing_to_what_it_returned():
    air = ls.Air(wind=(1, 2, 3))
    wind = air.wind
    wind[:] = 0
    assert list(air.wind) == [1, 2, 3]


@pytest.mark.parametrize(
    "error, standard",
    [
        ("InvalidInput", ValueError),
        ("SolverFailure", RuntimeError),
        ("CacheError", OSError),
        ("Unsupported", NotImplementedError),
    ],
)
def test_each_error_is_a_standard_one_and_one_of_ours(error, standard):
    assert issubclass(getattr(ls, error), standard) and issubclass(getattr(ls, error), ls.Error)


def test_another_method_on_the_command_line_keeps_the_options_that_it_has():
    scene = ls.BackwardEuler(step=2e-3, linear_solver="direct", jacobian="exact")
    assert with_method(scene, "symplectic-euler") == ls.SymplecticEuler(step=2e-3)
    assert with_method(scene, "bdf2") == ls.BDF2(
        step=2e-3, linear_solver="direct", jacobian="exact"
    )


def test_integrators_differ_from_the_default_by_name_and_what_is_given():
    made = [
        ls.ExplicitEuler(step=1e-4),
        ls.SymplecticEuler(step=1e-4),
        ls.SemiImplicitEuler(step=1e-4),
        ls.BackwardEuler(step=1e-4),
        ls.ImplicitMidpoint(step=1e-4),
        ls.NonlinearMidpoint(step=1e-4),
        ls.BDF2(step=1e-4),
        ls.Asynchronous(step=1e-4),
    ]
    assert len({options.method for options in made}) == 8
    assert all(options.step == 1e-4 for options in made)
    assert all(isinstance(options, ls.Integrator) for options in made)
    assert all(a != b for a in made for b in made if a is not b)
    assert repr(made[0]) == "ExplicitEuler(step=0.0001)"


def test_an_integrator_has_the_fields_of_its_family_and_no_others():
    implicit = ls.SemiImplicitEuler.field_names
    assert ls.ExplicitEuler.field_names == ls.SymplecticEuler.field_names == ("step",)
    assert implicit == ls.ImplicitMidpoint.field_names == ls.BDF2.field_names
    newton = (*implicit, "newton_tolerance", "max_newton_iterations")
    assert ls.BackwardEuler.field_names == ls.NonlinearMidpoint.field_names == newton
    with pytest.raises(TypeError, match="ExplicitEuler has no field 'jacobian'"):
        ls.ExplicitEuler(step=1e-4, jacobian="exact")
    own = (
        *("step", "schedule", "limit", "safety", "bending_multiple"),
        *("limiting", "predicted", "present"),
    )
    assert ls.Asynchronous.field_names == own
    assert ls.Asynchronous().step == 2.5e-3
    assert ls.ExplicitEuler().step == ls.SemiImplicitEuler().step == "auto"
    assert ls.BDF2(step="auto") == ls.BDF2() != ls.BDF2(step=1e-3)
    with pytest.raises(TypeError, match=r"BDF2.step must be a number \[s\] or 'auto', got 'fast'"):
        ls.BDF2(step="fast")
    with pytest.raises(TypeError, match=r"BDF2.step must be a number \[s\], got True"):
        ls.BDF2(step=True)
    assert ls.ExplicitEuler(step=1e-4).replace() == ls.ExplicitEuler(step=1e-4)


def test_a_choice_that_does_not_exist_is_refused_with_those_that_do():
    for make in (ls.BDF2, ls.BDF2().replace):
        with pytest.raises(
            ls.InvalidInput,
            match=r"BDF2.jacobian must be one of spd \| exact, got .exakt.; did you mean .exact.",
        ):
            make(jacobian="exakt")
    with pytest.raises(ls.InvalidInput, match="linear_solver must be .* choose one of them"):
        ls.SemiImplicitEuler(linear_solver="superlu")
    with pytest.raises(TypeError, match=r"Cloth.rest \(rest lengths: uv \(.*cannot be a int"):
        ls.Cloth(rest=1)
    assert ls.BDF2(jacobian="exact").to_dict()["jacobian"] == "exact"
    assert "uv (lengths of the pattern: uv in metres" in ls.Cloth.rest.__doc__


def test_fabrics_are_materials_and_softer_than_steel():
    assert {"cotton", "silk", "denim"} <= set(ls.fabrics)
    assert all(
        0.05 < material.density < 0.6 and material.weft_stiffness < 1e5
        for material in ls.fabrics.values()
    )
    assert ls.fabrics["silk"].density < ls.fabrics["denim"].density


def test_every_public_name_is_there_once():
    assert len(set(ls.__all__)) == len(ls.__all__)
    assert all(hasattr(ls, name) for name in ls.__all__)
    assert ls.__version__ == _core.__version__


def test_versions_are_printed(capsys):
    ls.show_versions()
    assert "numpy" in (text := capsys.readouterr().out) and ls.__version__ in text


@pytest.mark.parametrize(
    "mistake, said",
    [
        (
            lambda: ls.TriangleMesh(1),
            r"TriangleMesh\(1\) has wrong arguments; expected TriangleMesh\(vertices: object, ",
        ),
        (
            lambda: GRID.moved((0, 0, 0), 1, scale="a"),
            r"moved\(\(0, 0, 0\), 1, scale='a'\) has wrong arguments; expected moved\(transl",
        ),
        (lambda: ls.Air().replace(1), r"replace\(1\) has wrong arguments; expected replace\(\*"),
        (
            lambda: ls.collision.intersecting_pairs(GRID),
            r"intersecting_pairs\(TriangleMesh\(9 vertices, 8 triangles, uv\)\) has wrong",
        ),
        (lambda: ls.pictures.write_png(3, 4), r"write_png\(3, 4\) has wrong arguments; expected"),
    ],
)
def test_calls_that_the_core_rejects_are_one_sentence(mistake, said):
    with pytest.raises(TypeError, match=said) as told:
        mistake()
    assert "\n" not in str(told.value)


def test_functions_of_the_core_keep_their_names_and_help():
    assert ls.collision.intersecting_pairs.__module__ == "loomstone._core"
    assert ls.TriangleMesh.moved.__name__ == "moved" and "translation" in GRID.moved.__doc__
    with pytest.raises(ls.InvalidInput, match="must have shape"):  # other errors stay as they are
        GRID.moved((0, 0))
