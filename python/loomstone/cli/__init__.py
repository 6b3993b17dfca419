"""The command `loomstone`, with one module for each command or group of commands."""

# The help lists commands in the order of these imports.
from . import new, scenes, run, sweep, render, demo, view, export  # noqa: F401, I001
from . import check, plot, replay, fabrics, versions  # noqa: F401
from .application import app, main

__all__ = ["app", "main"]
