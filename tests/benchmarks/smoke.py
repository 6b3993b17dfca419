"""What programs here share: --smoke, and how they end where something they need is missing.

With --smoke a program takes its tiny sizes as defaults and ends within seconds; the tests run it
so. Status 77 says that data or a package is missing, in one sentence on the standard error.
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
SHARED = ROOT.parent / "shared"  # data sets and programs of others, beside the project


def parsed(parser: argparse.ArgumentParser, **tiny: Any) -> argparse.Namespace:
    """The options given; --smoke takes those of `tiny` where none are."""
    parser.add_argument("--smoke", action="store_true", help="tiny sizes, a few seconds")
    if "--smoke" in sys.argv:
        parser.set_defaults(**tiny)
    return parser.parse_args()


def missing(what: str) -> NoReturn:
    print(f"left out: {what}", file=sys.stderr)
    raise SystemExit(77)


def package(name: str) -> ModuleType:
    """The package, or the end with status 77."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        missing(f"{name} cannot be imported: {error}")


def present(path: Path) -> Path:
    """The path, or the end with status 77."""
    if not path.exists():
        missing(f"{path} is not there")
    return path
