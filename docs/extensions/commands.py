"""The directive `commands`: the help of every command of the program `loomstone`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from docutils import nodes
from loomstone.cli.application import app as program
from sphinx.util.docutils import SphinxDirective
from typer.main import get_command


def helps(command: Any, words: str) -> Iterator[tuple[str, str]]:
    """Yields the name and the help text of a command, then those of each of its subcommands."""
    width = {"terminal_width": 80, "max_content_width": 80}
    with command.make_context(words, [], resilient_parsing=True, **width) as context:
        yield words, command.get_help(context)
    for name, each in getattr(command, "commands", {}).items():
        yield from helps(each, f"{words} {name}")


class Commands(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        found: list[nodes.Node] = []
        for words, text in helps(get_command(program), "loomstone"):
            section = nodes.section(ids=[nodes.make_id(words)], names=[words])
            section += nodes.title("", "", nodes.literal("", words))
            section += nodes.literal_block(text, text, language="text")
            found.append(section)
        return found


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True}
