"""Functions shared by the benchmarks: they add the option --smoke and parse the options, exit if
something is missing, and return the mpirun command for several ranks.

With --smoke a program defaults to tiny sizes and ends within seconds; the tests run it this way.
Exit status 77 means that something that the program needs is missing; a message on the standard
error names it.
"""

from __future__ import annotations

import argparse
import importlib
import shutil
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
SHARED = ROOT.parent / "shared"  # external data sets and programs, next to the project directory


# Environment variables that allow root to use mpirun. In many containers, root is the only user.
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def parsed(parser: argparse.ArgumentParser, **tiny: Any) -> argparse.Namespace:
    """Adds --smoke to the options of `parser`, and returns the parsed options.

    With --smoke, the values in `tiny` replace the defaults of the options that they name.
    """
    parser.add_argument("--smoke", action="store_true", help="tiny sizes, a few seconds")
    if "--smoke" in sys.argv:
        parser.set_defaults(**tiny)
    return parser.parse_args()


def missing(what: str) -> NoReturn:
    print(f"left out: {what}", file=sys.stderr)
    raise SystemExit(77)


def package(name: str) -> ModuleType:
    """Imports and returns the package or module, or exits with status 77 if this fails."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        missing(f"{name} cannot be imported: {error}")


def present(path: Path) -> Path:
    """Returns the path if it exists, or exits with status 77."""
    if not path.exists():
        missing(f"{path} is not there")
    return path


def mpirun(ranks: int) -> list[str]:
    """Returns the words to put before a command that is to run on `ranks` ranks.

    Ranks may share processors. If the user is root, the command needs AS_ROOT in its environment.
    Exits with status 77 if mpirun is not installed.
    """
    if shutil.which("mpirun") is None:
        missing("mpirun is not installed")
    return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)]
