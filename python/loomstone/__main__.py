"""Entry point of `python -m loomstone`."""

from .cli import main

main()
