"""Structure of the Python package: allowed imports, and public names of each subpackage (room)."""

import ast
import importlib
import pkgutil
import subprocess
import sys
import types
from pathlib import Path

import loomstone
import pytest

ROOT = Path(loomstone.__file__).parent

# Rooms (subpackages and modules) in order of dependency: each imports only itself and earlier ones.
ORDER = [
    "_core",
    "base",
    "ranks",
    "versions",
    "collision",
    "limits",
    "exchange",
    "meshes",
    "obstacles",
    "magnetics",
    "integrators",
    "pictures",
    "runs",
    "plausibility",
    "simulation",
    "viewer",
    "sweeps",
    "fabrics",
    "garments",
    "",  # the package itself
    "cli",
    "__main__",
]

MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    .removesuffix("__init__")
    .rstrip("."): path
    for path in sorted(ROOT.rglob("*.py"))
}

PUBLIC = ["", "collision", "fabrics", "fabrics.measurements", "garments", "limits", "magnetics",
          "meshes", "obstacles", "pictures", "ranks", "viewer"]  # fmt: skip


def imports(module: str) -> set[str]:
    """Returns the modules of loomstone that a module imports, at its top or inside functions."""
    path = MODULES[module]
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    package = [part for part in package if part]
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            assert all(alias.name.split(".")[0] != "loomstone" for alias in node.names), module
        if not isinstance(node, ast.ImportFrom):
            continue
        if node.level == 0:
            assert node.module is None or node.module.split(".")[0] != "loomstone", module
            continue
        base = package[: len(package) - node.level + 1] + (node.module or "").split(".")
        source = ".".join(part for part in base if part)
        for alias in node.names:
            inner = f"{source}.{alias.name}".lstrip(".")
            # An imported name is a module itself or a name inside the module `source`.
            found.add(inner if inner in MODULES or inner == "_core" else source)
    return found


def room(module: str) -> str:
    return module.split(".")[0]


@pytest.mark.parametrize("module", MODULES)
def test_a_room_imports_only_rooms_before_it(module):
    for other in imports(module):
        assert ORDER.index(room(other)) <= ORDER.index(room(module)), f"{module} imports {other}"


def test_no_imports_are_circular():
    graph = {module: imports(module) & set(MODULES) for module in MODULES}
    done: set[str] = set()

    def visit(module: str, way: tuple[str, ...]) -> None:
        assert module not in way, " -> ".join([*way[way.index(module) :], module])
        if module not in done:
            for other in sorted(graph[module]):
                visit(other, (*way, module))
            done.add(module)

    for module in graph:
        visit(module, ())


@pytest.mark.parametrize(
    "module", [name for name, path in MODULES.items() if path.stem == "__init__"]
)
def test_no_attribute_hides_a_module_of_the_same_name(module):
    package = importlib.import_module(f"loomstone.{module}".rstrip("."))
    for found in pkgutil.iter_modules(package.__path__):
        if found.name.startswith("lib") or found.name == "units":
            continue  # skips the MPI plug-in and the registry of units
        shown = getattr(package, found.name, None)
        assert shown is None or isinstance(shown, types.ModuleType), f"{module}: {found.name}"


@pytest.mark.parametrize("module", PUBLIC)
def test_a_room_shows_its_public_names_and_nothing_else(module):
    shown = importlib.import_module(f"loomstone.{module}".rstrip("."))
    assert sorted(dir(shown)) == sorted(shown.__all__)
    assert all(hasattr(shown, name) for name in shown.__all__)


def test_fabrics_are_a_module_that_names_index():
    import loomstone.fabrics

    assert loomstone.fabrics is importlib.import_module("loomstone.fabrics")
    assert isinstance(loomstone.fabrics, types.ModuleType)
    assert loomstone.fabrics["silk"] == loomstone.fabrics.catalogue["silk"]


def test_the_command_line_loads_only_what_every_command_needs():
    late = [f"loomstone.{room}" for room in ("fabrics", "garments", "viewer")]
    late += ["matplotlib", "pint", "rich", "scipy"]
    code = f"import sys, loomstone.cli; print([name for name in {late} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "[]\n"
