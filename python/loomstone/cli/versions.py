"""The command loomstone versions."""

from __future__ import annotations

from ..versions import show_versions
from .application import app


@app.command()
def versions() -> None:
    """Prints the versions of loomstone, Python and selected packages.

    Include the output in problem reports.
    """
    show_versions()
