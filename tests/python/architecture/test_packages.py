"""The recipe for Spack has the dependencies of the package, faulty wheels are refused, and a build
of several wheels forgets the Python interpreter of the preceding wheel.
"""

import re
import runpy
import subprocess
import sys
import types
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
SPACK = ROOT / "scripts" / "spack" / "packages" / "loomstone" / "package.py"
CONTENTS = runpy.run_path(str(ROOT / "tests" / "wheel" / "contents.py"))
LICENSES = runpy.run_path(str(ROOT / "scripts" / "wheel_licenses.py"))
# Specs of Spack packages. The keys are the libraries for which CMake searches.
OF_CMAKE = {
    "Eigen3 3.4": "eigen@3.4:3",
    "fmt 9": "fmt@9:",
    "embree 3": "embree@3.13:3",
    "hdf5": "hdf5~mpi@1.10:",
    "bullet": "bullet3+double",
    "cholmod": "suite-sparse@5.12:",
    "metis": "metis@5.1:",
    "PNG": "libpng@1.6:",
    "MPI": "mpi",
}


# Maps the specs of the other dependencies, except Python packages, to a pattern and a file. A match
# of the pattern in the file shows that the dependency is needed.
OF_OTHERS = {
    "c": (r"LANGUAGES C CXX", "CMakeLists.txt"),
    "cxx": (r"LANGUAGES C CXX", "CMakeLists.txt"),
    "cmake@3.25:": (r"cmake_minimum_required\(VERSION 3\.25\)", "CMakeLists.txt"),
    "python@3.10:": (r'requires-python = ">=3\.10"', "pyproject.toml"),
    "ninja": (r"ninja\.make-fallback = false", "pyproject.toml"),
    "pkgconfig": (r"find_package\(PkgConfig", "core/dependencies.cmake"),
    "tbb": (r"find_package\(embree", "core/dependencies.cmake"),  # Embree uses it
    "mesa@:25.0+osmesa": (r"find_path\(OSMESA_INCLUDE_DIR", "renderer/CMakeLists.txt"),
    "egl": (r"find_path\(EGL_INCLUDE_DIR", "renderer/CMakeLists.txt"),
}
# A spec of Spack: a name, versions, and variants, as in hdf5~mpi@1.10: and mesa@:25.0+osmesa.
SPEC = r"[a-z][a-z0-9-]*(@(\d+(\.\d+)*)?(:(\d+(\.\d+)*)?)?|[+~][a-z]+)*"


@pytest.fixture(scope="module")
def recipe(tmp_path_factory):
    """Returns what the recipe declares: for each directive, the first argument of every call; in
    "options", the first argument and the options of every call; in "class", the class of the
    package.
    """
    said = {"version": [], "depends_on": [], "options": []}
    package = types.ModuleType("spack.package")

    def noting(directive):
        def note(spec, **options):
            said.setdefault(directive, []).append(spec)
            said["options"].append((spec, options))

        return note

    for name in ("license", "version", "variant", "depends_on", "conflicts"):
        setattr(package, name, noting(name))
    system = types.ModuleType("spack_repo.builtin.build_systems.python")
    system.PythonPackage = object
    names = {
        "spack.package": package,
        "spack_repo.builtin.build_systems.python": system,
    }
    for name in ("spack", "spack_repo", "spack_repo.builtin", "spack_repo.builtin.build_systems"):
        names[name] = types.ModuleType(name)
    with pytest.MonkeyPatch.context() as patch:
        for name, module in names.items():
            patch.setitem(sys.modules, name, module)
        said["class"] = runpy.run_path(str(SPACK))["Loomstone"]
    return said


def test_the_recipe_for_spack_has_the_version_of_cmake(recipe):
    version = re.search(
        r"project\(loomstone VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()
    )
    assert recipe["version"] == [version[1]]


def test_the_recipe_for_spack_has_the_dependencies_of_the_python_package(recipe):
    text = (ROOT / "pyproject.toml").read_text()
    found = [
        *re.findall(
            r'"([\w-]+)>=([\d.]+)"', re.search(r"(?s)\ndependencies = (\[.*?\n\])", text)[1]
        ),
        *re.findall(r'"([\w-]+)>=([\d.]+)"', re.search(r"\nrequires = (\[.*\])", text)[1]),
    ]
    assert len(found) >= 8
    for name, least in found:
        least = re.sub(r"(\.0)+$", "", least)
        assert f"py-{name}@{least}:" in recipe["depends_on"], name


@pytest.mark.parametrize("name", OF_CMAKE)
def test_the_recipe_for_spack_has_the_libraries_that_cmake_looks_for(recipe, name):
    looked_for = rf"(find_package|find_library|pkg_search_module)\([^)]*\b{re.escape(name)}\b"
    assert re.search(looked_for, (ROOT / "core" / "dependencies.cmake").read_text())
    assert OF_CMAKE[name] in recipe["depends_on"]


def test_the_recipe_for_spack_has_no_other_dependencies(recipe):
    others = set(recipe["depends_on"]) - set(OF_CMAKE.values())
    others = {spec for spec in others if not spec.startswith("py-")}
    assert others == OF_OTHERS.keys()
    for spec, (wanted, file) in OF_OTHERS.items():
        assert re.search(wanted, (ROOT / file).read_text()), f"{spec}: {wanted} in {file}"
    text = (ROOT / "pyproject.toml").read_text()
    for spec in recipe["depends_on"]:
        name = spec.partition("@")[0].removeprefix("py-")
        assert not spec.startswith("py-") or f'"{name}>=' in text, spec


def test_the_specs_of_the_recipe_are_valid(recipe):
    for spec in recipe["depends_on"]:
        assert re.fullmatch(SPEC, spec), spec
    assert not re.fullmatch(SPEC, "fmt@9.:") and not re.fullmatch(SPEC, "hdf5~")
    for _, options in recipe["options"]:
        if "when" in options:
            assert options["when"][0] in "+~" and options["when"][1:] in recipe["variant"]
        kinds = options.get("type", ())
        assert set([kinds] if isinstance(kinds, str) else kinds) <= {"build", "link", "run", "test"}


def test_the_variants_of_the_recipe_change_the_options_of_cmake(recipe):
    assert recipe["variant"] == ["mpi"]
    assert "find_package(MPI" in (ROOT / "core" / "dependencies.cmake").read_text()
    for chosen, disabled in (("+mpi", "OFF"), ("~mpi", "ON")):

        class Spec:
            def satisfies(self, asked, chosen=chosen):
                return asked == chosen

        settings = recipe["class"]().config_settings(Spec(), "/prefix")
        assert settings == {"cmake.define.CMAKE_DISABLE_FIND_PACKAGE_MPI": disabled}


def test_every_library_that_cmake_looks_for_is_compared():
    text = (ROOT / "core" / "dependencies.cmake").read_text()
    found = set(re.findall(r"(?m)^(?:find_package|find_library|pkg_\w+_module)\((\w+)", text))
    without_package = {"OpenMP", "Threads", "PkgConfig"}
    assert len(found - without_package) == len(OF_CMAKE)


GOOD = [
    "loomstone/_core.cpython-311-x86_64-linux-gnu.so",
    "loomstone/libOSMesa.so.8",
    "loomstone/scenes/drape.py",
    "loomstone-0.1.0.dist-info/licenses/LICENSE",
    "loomstone-0.1.0.dist-info/licenses/third_party/README.md",
    "loomstone-0.1.0.dist-info/licenses/third_party/cholmod.txt",
]


def faults(names=(), functions=("cholmod_analyze", "cholmod_scale_factor"), size=5e7):
    return list(CONTENTS["faults"]([*GOOD, *names], {"libcholmod.so.3": list(functions)}, size))


def test_a_wheel_with_functions_under_the_gpl_is_refused():
    assert faults() == []
    (said,) = faults(functions=["cholmod_analyze", "cholmod_super_numeric", "cholmod_updown"])
    assert said.endswith("has functions under the GPL: cholmod_super_numeric, cholmod_updown")


def test_a_wheel_with_unwanted_libraries_or_without_licences_is_refused():
    (said,) = faults(["loomstone.libs/libcurl-8a2f.so.4"])
    assert said == "it must not contain loomstone.libs/libcurl-8a2f.so.4"
    assert faults(["loomstone/libloomstone_mpi.so"]) == [
        "it must not contain loomstone/libloomstone_mpi.so"
    ]
    (said,) = faults(size=6.1e7)
    assert said == "it must have at most 60 MB, got 61.0 MB"
    for name in GOOD:
        rest = [each for each in GOOD if each != name]
        assert len(list(CONTENTS["faults"](rest, {"libcholmod.so.3": []}, 1e6))) == 1


def test_the_build_of_several_wheels_forgets_the_last_interpreter(tmp_path):
    cache = tmp_path / "CMakeCache.txt"
    cache.write_text(
        "# external\n\n//Path to a program.\nCMAKE_AR:FILEPATH=/usr/bin/ar\n\n"
        "Python_EXECUTABLE:PATH=/python\n\n//The directory containing a CMake\n"
        "// configuration file for pybind11.\npybind11_DIR:PATH=/pybind11\n\n"
        "# internal\n\n//ADVANCED property\nCMAKE_AR-ADVANCED:INTERNAL=1\n"
        "_PYTHON_INTERNAL:INTERNAL=1\n//reason of failure\n_Python_REASON:INTERNAL=\n"
    )
    script = ROOT / "scripts" / "wheel_cache"
    subprocess.run([script, cache], check=True)
    # CMake refuses a file with a comment that no variable follows.
    assert cache.read_text() == (
        "# external\n\n//Path to a program.\nCMAKE_AR:FILEPATH=/usr/bin/ar\n\n\n\n"
        "# internal\n\n//ADVANCED property\nCMAKE_AR-ADVANCED:INTERNAL=1\n"
    )
    subprocess.run([script, tmp_path / "absent"], check=True)


def test_a_library_without_a_licence_is_refused(tmp_path):
    wheel = tmp_path / "loomstone-0.1.0"
    (wheel / "loomstone.libs").mkdir(parents=True)
    (wheel / "loomstone.libs" / "libpng16-12ab.so.16").touch()
    found = {each.name for each in LICENSES["contained"](wheel)}
    assert found == {"libpng", "Eigen", "pybind11"}
    (wheel / "loomstone.libs" / "libstranger.so.1").touch()
    with pytest.raises(LICENSES["Incomplete"], match=r"libstranger\.so\.1 has no entry"):
        LICENSES["contained"](wheel)
    unknown = LICENSES["Library"]("stranger", "MIT", "libstranger", "no-such-package")
    with pytest.raises(LICENSES["Incomplete"], match="no licence of stranger was found"):
        LICENSES["text_of"](unknown, tmp_path)
