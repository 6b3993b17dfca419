"""Tables from the declarations in the sources: the directives `fields` and `columns`.

`fields` takes the name of a class of loomstone that declares its parameters, such as ClothMaterial,
and lists these parameters. `columns` lists the numbers of a StepReport. The texts come from
fields() of the C++ structs. The bindings copy them to the docstrings of the properties.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

import loomstone
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

FIELD_WIDTHS = {"parameter": 20, "meaning": 55, "allowed": 13, "default": 12}
COLUMN_WIDTHS = {"column": 30, "meaning": 70}


def declaration(text: str) -> tuple[str, str, str]:
    """Splits the docstring of a field into meaning, limits and default. Missing parts are empty."""
    parts = text.split("; ")
    default = parts.pop().removeprefix("default ") if parts[-1].startswith("default ") else ""
    limits = parts.pop() if re.match(r"[<>]=? |in [\[(]", parts[-1]) else ""
    return "; ".join(parts), limits, default


def table(widths: dict[str, int], rows: Iterable[tuple[str, ...]], code: set[int]) -> nodes.table:
    """Returns a table of strings. Columns whose indices are in `code` are formatted as code."""

    def row(texts: Iterable[str], code: set[int]) -> nodes.row:
        made = nodes.row()
        for i, text in enumerate(texts):
            shown = nodes.literal(text, text) if i in code and text else nodes.Text(text)
            made += nodes.entry("", nodes.paragraph("", "", shown))
        return made

    group = nodes.tgroup(cols=len(widths))
    group += [nodes.colspec(colwidth=width) for width in widths.values()]
    group += nodes.thead("", row(widths, set()))
    group += nodes.tbody("", *(row(texts, code) for texts in rows))
    return nodes.table("", group)


class Fields(SphinxDirective):
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        described = getattr(loomstone, self.arguments[0], None)
        if not hasattr(described, "field_names"):
            raise self.error(f"loomstone has no description {self.arguments[0]!r}")
        rows = (
            (name, *declaration(getattr(described, name).__doc__)) for name in described.field_names
        )
        return [table(FIELD_WIDTHS, rows, {0, 3})]


def numbers(report: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yields the path and the description of every number in a report."""
    for name, declared in vars(type(report)).items():
        value = getattr(report, name)
        if isinstance(declared, property) and hasattr(value, "to_dict"):
            yield from numbers(value, f"{prefix}{name}.")
        elif isinstance(declared, property):
            yield prefix + name, declared.__doc__ or ""


class Columns(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        cloth = loomstone.Cloth(mesh=loomstone.grid(cells=(1, 1)))
        report = loomstone.Simulation(loomstone.Scene(cloths=[cloth]), threads=1).report
        return [table(COLUMN_WIDTHS, numbers(report), {0})]


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("fields", Fields)
    app.add_directive("columns", Columns)
    return {"parallel_read_safe": True}
