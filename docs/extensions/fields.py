"""The directive `fields`: a table of the parameters of a description, from its declarations.

Its argument is the name of a class of loomstone, such as ClothMaterial. The declarations are the
fields() of the C++ struct, which the docstrings of the properties state.
"""

from __future__ import annotations

import re
from typing import Any

import loomstone
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

COLUMNS = {"parameter": 20, "meaning": 55, "allowed": 13, "default": 12}


def declaration(text: str) -> tuple[str, str, str]:
    """Splits the docstring of a field into its meaning, its limits and its default."""
    parts = text.split("; ")
    default = parts.pop().removeprefix("default ") if parts[-1].startswith("default ") else ""
    limits = parts.pop() if re.match(r"[<>]=? |in [\[(]", parts[-1]) else ""
    return "; ".join(parts), limits, default


def row(cells: list[nodes.Node]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", cell)) for cell in cells))


def table(described: Any) -> nodes.table:
    group = nodes.tgroup(cols=len(COLUMNS))
    group += [nodes.colspec(colwidth=width) for width in COLUMNS.values()]
    group += nodes.thead("", row([nodes.Text(title) for title in COLUMNS]))
    body = nodes.tbody()
    for name in described.field_names:
        meaning, limits, default = declaration(getattr(described, name).__doc__)
        shown = nodes.literal("", default) if default else nodes.Text("")
        body += row([nodes.literal("", name), nodes.Text(meaning), nodes.Text(limits), shown])
    group += body
    return nodes.table("", group, classes=["fields"])


class Fields(SphinxDirective):
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        described = getattr(loomstone, self.arguments[0], None)
        if not hasattr(described, "field_names"):
            raise self.error(f"loomstone has no description {self.arguments[0]!r}")
        return [table(described)]


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("fields", Fields)
    return {"parallel_read_safe": True}
