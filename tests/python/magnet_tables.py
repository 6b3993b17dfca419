"""Reference tables for magnets, stored next to the project. Tests that need a missing table are
skipped.
"""

import json
from pathlib import Path
from typing import Any

import pytest

TABLES = Path(__file__).resolve().parents[3] / "shared" / "data" / "magnets"


def cases(name: str) -> list[dict[str, Any]]:
    """Returns the cases of a table, or skips the calling test if the table is missing."""
    path = TABLES / f"{name}.json"
    if not path.exists():
        pytest.skip(f"reference values not found: {path.name} beside the project")
    return json.loads(path.read_text())["cases"]


def each_case(name: str) -> pytest.MarkDecorator:
    """Returns a mark that runs a test for each `case` of a table, or skips the test if the table is
    missing.
    """
    if not (TABLES / f"{name}.json").exists():
        return pytest.mark.skip(f"reference values not found: {name}.json beside the project")
    return pytest.mark.parametrize("case", cases(name), ids=lambda case: case["id"])
