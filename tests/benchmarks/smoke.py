"""Functions shared by the benchmarks: the --smoke option and the exit when something is missing.

With --smoke a program defaults to tiny sizes and ends within seconds; the tests run it this way.
Exit status 77 means that something that the program needs is missing; the standard error names it.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
SHARED = ROOT.parent / "shared"  # external data sets and programs, next to the project directory


def parsed(parser: argparse.ArgumentParser, **tiny: Any) -> argparse.Namespace:
    """Parses the options. With --smoke, `tiny` replaces the defaults."""
    parser.add_argument("--smoke", action="store_true", help="tiny sizes, a few seconds")
    if "--smoke" in sys.argv:
        parser.set_defaults(**tiny)
    return parser.parse_args()


def missing(what: str) -> NoReturn:
    print(f"left out: {what}", file=sys.stderr)
    raise SystemExit(77)


def package(name: str) -> ModuleType:
    """Imports the package, or exits with status 77."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        missing(f"{name} cannot be imported: {error}")


def present(path: Path) -> Path:
    """Returns the path if it exists, or exits with status 77."""
    if not path.exists():
        missing(f"{path} is not there")
    return path
