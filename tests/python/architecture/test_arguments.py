"""Numbers that public functions take have units, and wrong arguments are refused with advice."""

import dataclasses
import importlib
import inspect
import re

import loomstone as ls
import pytest

ROOMS = ["fabrics", "fabrics.measurements", "garments", "limits", "magnetics", "meshes",
         "obstacles", "pictures"]  # fmt: skip

# Parameters whose values have no unit: options, counts, choices, patterns and tables of steps.
WITHOUT = {"with_uv", "threads", "quantity", "progress", "steps", "pattern"}


def functions():
    for room in ROOMS:
        module = importlib.import_module(f"loomstone.{room}")
        for name in module.__all__:
            made = getattr(module, name)
            ours = getattr(made, "__module__", "").startswith("loomstone.")
            result = isinstance(made, type) and not hasattr(made.__init__, "units")
            if callable(made) and ours and not made.__module__.endswith("_core") and not result:
                yield pytest.param(made, id=f"{room}.{name}")


def units_of(function):
    return getattr(function.__init__ if isinstance(function, type) else function, "units", {})


@pytest.mark.parametrize("function", list(functions()))
def test_every_number_of_a_public_function_has_a_unit(function):
    for name, parameter in inspect.signature(function).parameters.items():
        kind = str(parameter.annotation)
        if (
            name not in WITHOUT
            and re.search(r"\bfloat\b|ArrayLike", kind)
            and "Callable" not in kind
        ):
            assert name in units_of(function), f"{name}: {kind}"


@pytest.mark.parametrize("function", list(functions()))
def test_a_misspelt_keyword_is_refused_with_the_right_one(function):
    names = list(inspect.signature(function).parameters)
    if not units_of(function) and not names:
        return
    with pytest.raises(TypeError, match=f"has no argument '{names[-1]}x'; did you mean"):
        function(**{f"{names[-1]}x": 1})


@pytest.mark.parametrize(
    "call, right",
    [
        (lambda: ls.sphere(radius=1, center=(0, 0, 0)), "centre"),
        (lambda: ls.magnetics.field_lines([], center=(0, 0, 0)), "centre"),
        (lambda: ls.RenderOptions(colour_by="cloth"), "color_by"),
        (lambda: ls.RenderOptions(colour_map="magma"), "color_map"),
        (lambda: ls.garments.Cylinder(radius=1, center=(0, 0, 0)), "centre"),
    ],
)
def test_the_other_spelling_is_refused_with_ours(call, right):
    with pytest.raises(TypeError, match=f"did you mean '{right}'"):
        call()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: ls.sphere(0.1),
            r"sphere() takes keyword arguments only, as in sphere(radius=...)",
        ),
        (lambda: ls.grid((1, 1), 50), "grid() takes keyword arguments only, as in grid(size=...)"),
        (
            lambda: ls.Simulation(ls.Scene(), ls.BDF2()),
            "Simulation() takes no argument without a keyword except scene, got BDF2(); known:",
        ),
        (lambda: ls.Simulation(ls.Scene(), thread=1), "Simulation() has no argument 'thread'"),
        (
            lambda: ls.obstacles.mesh(ls.grid(cells=(1, 1)), "name"),
            "mesh() takes no argument without a keyword except mesh, got 'name'",
        ),
    ],
)
def test_an_argument_that_needs_a_keyword_is_refused_with_one(call, said):
    with pytest.raises(TypeError, match=re.escape(said)):
        call()


def test_results_are_named_tuples_or_frozen():
    for made in (ls.fabrics.ModeFit, ls.fabrics.measurements.Rest):
        assert dataclasses.is_dataclass(made) and made.__dataclass_params__.frozen


@pytest.mark.parametrize(
    "call",
    [
        lambda: ls.obstacles.mesh("ball.obj"),
        lambda: ls.obstacles.mesh(mesh="ball.obj"),
        lambda: ls.magnetics.mesh("ball.obj", polarization=(0, 0, 1)),
        lambda: ls.meshes.quality("ball.obj"),
        lambda: ls.meshes.nearest_vertices("ball.obj", [(0, 0, 0)]),
        lambda: ls.limits.strain([(0, 0, 0)], "ball.obj"),
    ],
)
def test_a_path_in_place_of_a_mesh_is_refused_with_the_function_that_reads_it(call):
    said = r"mesh must be a TriangleMesh, got the str 'ball.obj'; .*loomstone.meshes.read\(path\)"
    with pytest.raises(TypeError, match=said):
        call()


def test_functions_of_the_core_name_the_function_that_reads_meshes():
    with pytest.raises(TypeError, match=r"SpatialQuery\('a.obj'\) has .* loomstone.meshes.read\("):
        ls.meshes.SpatialQuery("a.obj")
    mesh = ls.grid(cells=(2, 2))
    with pytest.raises(TypeError) as told:  # "a" is not a path in place of a mesh
        mesh.moved((0, 0, 0), 1, scale="a")
    assert "meshes.read" not in str(told.value)
