"""The documentation builds without a warning, and its tables and its gallery are complete."""

import json
import re
import subprocess
import sys

import loomstone as ls
import pytest
from code_blocks import ROOT


def test_the_documentation_builds_without_a_warning(tmp_path):
    for package in ("sphinx", "furo", "myst_parser"):
        pytest.importorskip(package, reason="the extra `docs` is not installed")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going"]
    places = ["-c", ROOT / "docs", "-d", tmp_path / "trees", ROOT, tmp_path / "pages"]
    done = subprocess.run([*command, *map(str, places)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    reference = tmp_path / "pages/docs/reference"
    assert "mass per area [kg/m^2]" in (reference / "parameters.html").read_text(), (
        "the tables come from the declarations"
    )
    magnetics = (reference / "magnetics.html").read_text()
    assert "ArrayLike" in magnetics and "_SupportsArray" not in magnetics, "types are readable"


def test_every_description_has_its_table_of_parameters():
    page = (ROOT / "docs/reference/parameters.md").read_text()
    described = {name for name in ls.__all__ if getattr(getattr(ls, name), "field_names", ())}
    assert set(re.findall(r"```\{fields\} (\w+)", page)) == described


def test_every_scene_of_the_gallery_exists_and_has_a_picture():
    for name in json.loads((ROOT / "docs/gallery.json").read_text()):
        assert (ROOT / f"scenes/{name}.py").exists(), name
        assert (ROOT / f"docs/images/scenes/{name}.jpg").exists(), name
