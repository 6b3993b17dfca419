"""The command `loomstone`, with one module for each command or group of commands."""

# The help lists commands in the order of these imports.
from . import run, sweep, render, view, export, check, plot, replay, fabrics, versions  # noqa: F401, I001
from .application import app, main

__all__ = ["app", "main"]
