"""The command `loomstone`: one file a command or a group of them."""

# In the order in which the help lists them.
from . import run, render, check, plot, fabrics, versions  # noqa: F401, I001
from .application import app, main

__all__ = ["app", "main"]
