"""Tables of reference values for magnets, read where they lie beside the project; what needs them
is skipped without them.
"""

import json
from pathlib import Path
from typing import Any

import pytest

TABLES = Path(__file__).resolve().parents[3] / "shared" / "data" / "magnets"


def cases(name: str) -> list[dict[str, Any]]:
    """The cases of a table. Skips the test that asks where there is none."""
    path = TABLES / f"{name}.json"
    if not path.exists():
        pytest.skip(f"reference values not found: {path.name} beside the project")
    return json.loads(path.read_text())["cases"]


def each_case(name: str) -> pytest.MarkDecorator:
    """Runs a test once for every case, as its argument `case`."""
    if not (TABLES / f"{name}.json").exists():
        return pytest.mark.skip(f"reference values not found: {name}.json beside the project")
    return pytest.mark.parametrize("case", cases(name), ids=lambda case: case["id"])
