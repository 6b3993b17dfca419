"""Rules for the structure of the sources: includes between modules and between their rooms, the
files that may include an external library, unique names of types, and the size of files and
folders.
"""

import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# Modules that a module may include, besides itself and base.
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
    "core/electrodynamics": {
        "core/parallel",
        "core/linalg",
        "core/mesh",
        "core/magnetics",
        "core/rigid",
    },
    "core/sim": {
        "core/parallel",
        "core/linalg",
        "core/mesh",
        "core/cloth",
        "core/integration",
        "core/collision",
        "core/rigid",
        "core/magnetics",
        "core/electrodynamics",
    },
    "renderer": {"core/mesh", "core/cache"},
}

# Folders (rooms) of a module, lowest first. A file includes files of its module only from its own
# folder and from lower folders. Files at the top of the module may include all files of the module.
# Folders in one set do not include each other.
ROOMS = {
    "core/cloth": [{"material"}, {"membrane", "bending"}, {"limits"}],
    "core/collision": [
        {"model"},
        {"narrow_phase"},
        {"broad_phase"},
        {"tangle"},
        {"response"},
        {"certify"},
    ],
    "core/magnetics": [{"sources"}, {"fast_sums"}, {"forces"}, {"induction"}, {"field_lines"}],
    "core/rigid": [{"contacts"}],
    "core/sim": [{"scene"}, {"model"}, {"step"}, {"record"}],
}

# Each key is a regular expression for the use of an external library, such as the inclusion of its
# header. Its value matches the paths of the only files of core, renderer and bindings that may use
# the library.
DOORS = {
    r"<fmt/": r"core/base/message\.h$",
    r"<omp\.h>|#pragma omp": r"core/parallel/",
    r"<mpi\.h>": r"core/parallel/",
    r"<hdf5\.h>": r"core/cache/hdf5_\w+\.(h|cpp)$",
    r"<(bullet/)?bt|BulletDynamics|BulletCollision": r"core/rigid/bullet\.h$",
    r"<embree3/": r"core/(mesh/spatial_query|collision/broad_phase/embree\w*)\.cpp$",
    r"cholmod\.h": r"core/linalg/cholmod_solver\.cpp$",
    r"<metis\.h>": r"core/parallel/vertex_order\.cpp$",
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


def room(path: str) -> str:
    """Returns the folder within the module; empty for a file at the module's top."""
    parts = path.split("/")
    return parts[2] if len(parts) > 3 else ""


@pytest.mark.parametrize("own", ROOMS)
def test_a_room_includes_only_rooms_below_it(own: str) -> None:
    order = {name: level for level, names in enumerate(ROOMS[own]) for name in names}
    order[""] = len(ROOMS[own])
    wrong = []
    for path in sources(own):
        here = room(name(path))
        for include in re.findall(r'^#include "([^"]+)"', path.read_text(), re.M):
            if module(include) != own or (there := room(include)) == here:
                continue
            if order[there] >= order[here]:
                wrong.append(f"{name(path)} includes {include}")
    assert not wrong


@pytest.mark.parametrize("header", DOORS)
def test_an_external_library_is_included_only_by_its_files(header: str) -> None:
    for path in sources("core", "renderer", "bindings"):
        lines = [line for line in path.read_text().splitlines() if line.lstrip().startswith("#")]
        if any(re.search(header, line) for line in lines):
            assert re.search(DOORS[header], name(path)), f"{name(path)} opens {header}"


def test_types_of_headers_have_different_names() -> None:
    # Two types of the same name in one namespace would violate the one-definition rule: a program
    # that contains both could destroy an object of one type with the destructor of the other.
    declared = (
        r"^(?:struct|class|enum class) (?:alignas\([^)]*\) )?(\w+)(?: final)?(?: :[^{;]*)? \{"
    )
    found: dict[tuple[str, str], list[str]] = {}
    for path in sources("core", "renderer", "bindings"):
        if path.suffix != ".h":
            continue
        text = path.read_text()
        for match in re.finditer(declared, text, re.MULTILINE):
            space = re.findall(r"^namespace ([\w:]+) \{", text[: match.start()], re.MULTILINE)[-1:]
            found.setdefault((*space, match[1]), []).append(name(path))
    assert len(found) > 300
    assert not {key: paths for key, paths in found.items() if len(paths) > 1}


def code() -> list[Path]:
    python = [p for root in ("python", "scenes", "tests") for p in (ROOT / root).rglob("*.py")]
    scripts = [p for p in (ROOT / "scripts").iterdir() if p.is_file()]
    return sources("core", "renderer", "bindings", "tests") + python + scripts


def test_files_stay_short() -> None:
    long = {name(p): n for p in code() if (n := len(p.read_text().splitlines())) > 500}
    assert not long


def test_folders_stay_small() -> None:
    held = Counter(name(path.parent) for path in code())
    assert not {folder: n for folder, n in held.items() if n > 40}
