"""Who may include whom, which file opens the door to which library, and how long a file may grow."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# A module may include itself, base and these.
USES = {
    "core/base": set(),
    "core/parallel": set(),
    "core/mesh": set(),
    "core/cache": set(),
    "core/linalg": {"core/parallel"},
    "core/rigid": {"core/mesh"},
    "core/magnetics": {"core/parallel", "core/mesh"},
    "core/cloth": {"core/parallel", "core/linalg", "core/mesh"},
    "core/collision": {"core/parallel", "core/linalg", "core/mesh"},
    "core/integration": {"core/cloth", "core/parallel", "core/linalg", "core/mesh"},
    "core/sim": {
        "core/parallel",
        "core/linalg",
        "core/mesh",
        "core/cloth",
        "core/integration",
        "core/collision",
        "core/rigid",
        "core/magnetics",
    },
    "renderer": {"core/mesh", "core/cache"},
}

# Headers of outside libraries and the files that may include them.
DOORS = {
    r"<fmt/": r"core/base/message\.h$",
    r"<omp\.h>|#pragma omp": r"core/parallel/",
    r"<mpi\.h>": r"core/parallel/",
    r"<hdf5\.h>": r"core/cache/hdf5_file\.(h|cpp)$",
    r"<(bullet/)?bt|BulletDynamics|BulletCollision": r"core/rigid/bullet\.h$",
    r"<embree3/": r"core/(mesh/spatial_query|collision/embree\w*)\.cpp$",
    r"cholmod\.h": r"core/linalg/cholmod_solver\.cpp$",
    r"<metis\.h>": r"core/parallel/partition\.cpp$",
    r"<GL/osmesa|<EGL/": r"renderer/context\.cpp$",
    r"<png\.h>": r"renderer/|tests/",
    r"<pybind11/": r"bindings/",
}


def sources(*roots: str) -> list[Path]:
    found = [p for root in roots for p in (ROOT / root).rglob("*") if p.suffix in {".h", ".cpp"}]
    return [p for p in found if "third_party" not in p.parts]


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def module(path: str) -> str:
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] == "core" else parts[0]


@pytest.mark.parametrize("path", sources("core", "renderer"), ids=name)
def test_a_module_includes_only_modules_below_it(path: Path) -> None:
    own = module(name(path))
    for include in re.findall(r'^#include "([^"]+)"', path.read_text(), re.M):
        used = module(include)
        assert used in {own, "core/base"} | USES[own], f"{name(path)} includes {include}"
        assert (ROOT / include).exists(), f"{include} is not a path from the root"


@pytest.mark.parametrize("header", DOORS)
def test_an_outside_library_has_one_door(header: str) -> None:
    for path in sources("core", "renderer", "bindings"):
        lines = [line for line in path.read_text().splitlines() if line.lstrip().startswith("#")]
        if any(re.search(header, line) for line in lines):
            assert re.search(DOORS[header], name(path)), f"{name(path)} opens {header}"


def test_files_stay_short() -> None:
    paths = sources("core", "renderer", "bindings", "tests") + list((ROOT / "python").rglob("*.py"))
    long = {name(p): n for p in paths if (n := len(p.read_text().splitlines())) > 500}
    assert not long
