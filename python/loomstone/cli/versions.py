"""loomstone versions."""

from __future__ import annotations

from ..versions import show_versions
from .application import app


@app.command()
def versions() -> None:
    """Prints what this installation consists of.

    Paste it into reports of problems.
    """
    show_versions()
