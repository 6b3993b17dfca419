"""The version is that of CMakeLists.txt everywhere; fragments of the changelog have valid names."""

import re
from pathlib import Path

import loomstone as ls

ROOT = Path(__file__).resolve().parents[3]
TYPES = {"added", "changed", "removed", "fixed"}
NO_FRAGMENTS = {"README.md", "template.jinja"}


def first(pattern, file):
    found = re.search(pattern, (ROOT / file).read_text(encoding="utf-8"), re.M)
    assert found, f"{file} has no match for {pattern}"
    return found[1]


VERSION = first(r"^project\(loomstone VERSION ([0-9.]+)", "CMakeLists.txt")


def wrongly_named(names):
    """Returns the names that lack the form NAME.TYPE.md with a known TYPE and no dot in NAME."""
    wanted = re.compile(rf"[^.]+\.({'|'.join(TYPES)})\.md")
    return sorted(name for name in names if not wanted.fullmatch(name))


def test_the_package_has_the_version_of_cmake():
    assert ls.__version__ == VERSION


def test_the_citation_has_the_version_of_cmake():
    assert first(r"^version: (\S+)$", "CITATION.cff") == VERSION


def test_pyproject_and_the_documentation_have_no_version_of_their_own():
    assert first(r"^dynamic = (\S+)", "pyproject.toml") == '["version"]'
    assert first(r"^version = release = (.+)$", "docs/conf.py") == "loomstone.__version__"


def test_pyproject_reads_the_version_from_cmake():
    provider = r'^input = "CMakeLists\.txt"\nregex = \'(.+)\'$'
    read = re.search(first(provider, "pyproject.toml"), (ROOT / "CMakeLists.txt").read_text())
    assert read and read["value"] == VERSION


def test_the_changelog_has_an_entry_for_the_version():
    entry = rf"^## ({re.escape(VERSION)}) \((?:unreleased|\d{{4}}-\d\d-\d\d)\)$"
    assert first(entry, "CHANGELOG.md") == VERSION


def test_the_types_of_fragments_are_those_of_towncrier():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    types = re.findall(r'\[\[tool\.towncrier\.type\]\]\ndirectory = "(\w+)"', text)
    assert len(types) == len(TYPES) and set(types) == TYPES


def test_every_fragment_has_a_name_and_a_known_type():
    names = {path.name for path in (ROOT / "changes").iterdir()} - NO_FRAGMENTS
    assert wrongly_named(names) == []


def test_a_fragment_without_a_known_type_is_found():
    assert wrongly_named(["a.added.md", "b.feature.md", "c.md", "d.fixed.txt", ".fixed.md"]) == [
        ".fixed.md",
        "b.feature.md",
        "c.md",
        "d.fixed.txt",
    ]
