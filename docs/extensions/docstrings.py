"""Converts docstrings of this project to reStructuredText for autodoc.

A docstring consists of paragraphs, examples (>>>), indented code, lists (lines `- text`), and lines
`name : text` that describe parameters. Indented lines continue list items and parameters. Words in
single backticks are code. The heading "Parameters (keywords)" is left out.
"""

from __future__ import annotations

import re
import textwrap
from typing import Any

from sphinx.util import logging

PARAMETER = re.compile(r"([a-z_]\w*(?:, [a-z_]\w*)*) : (.+)")
NAME = re.compile(r"[A-Za-z_][\w.]*(\(\))?")


def inline(text: str) -> str:
    """Escapes special characters of reStructuredText, and converts text in backticks.

    A name in backticks becomes a cross-reference, and other text in backticks becomes code.
    """
    pieces = text.split("`")
    if len(pieces) % 2 == 0:
        raise ValueError(f"a docstring has an odd number of backticks: {text}")
    for i, piece in enumerate(pieces):
        if i % 2 == 0:
            pieces[i] = re.sub(r"([\\*_|])", r"\\\1", piece)
        elif NAME.fullmatch(piece):
            pieces[i] = f"\\ :py:obj:`{piece}`\\ "
        else:
            pieces[i] = f"\\ ``{piece}``\\ "
    joined = "".join(pieces)
    return f"\\{joined}" if re.match(r"\(?\w+[.)] |[-+:.(]", joined) else joined


def blocks(lines: list[str]) -> list[list[str]]:
    """Splits lines into blocks at blank lines, and where a list of parameters begins or ends."""
    found: list[list[str]] = [[]]
    for line in lines:
        parameter = bool(PARAMETER.fullmatch(line))
        inside = bool(found[-1]) and bool(PARAMETER.fullmatch(found[-1][0]))
        if not line.strip():
            found.append([])
            continue
        if (parameter and not inside) or (inside and not parameter and not line.startswith(" ")):
            found.append([])
        found[-1].append(line)
    return [block for block in found if block]


def parameters(block: list[str]) -> list[str]:
    out = [":Parameters:"]
    for line in block:
        match = PARAMETER.fullmatch(line)
        if match:
            names = ", ".join(f"**{name}**" for name in match[1].split(", "))
            out.append(f"   * {names}: {inline(match[2])}")
        else:
            out.append(f"     {inline(line.strip())}")
    return out


def bullets(block: list[str]) -> list[str]:
    joined = re.sub(r"\n +", " ", "\n".join(block)).splitlines()
    return [f"* {inline(line.removeprefix('- '))}" for line in joined]


def converted(lines: list[str]) -> list[str]:
    """Returns the lines of a docstring as reStructuredText."""
    lines = textwrap.dedent("\n".join(lines)).splitlines()
    text = re.sub(r"\n?Parameters \(keywords\)\n-+\n", "\n", "\n".join(lines))
    out: list[str] = []
    for block in blocks(text.splitlines()):
        if block[0].startswith(">>>"):
            out += [re.sub(r" *# doctest: \+SKIP", "", line) for line in block]
        elif PARAMETER.fullmatch(block[0]):
            out += parameters(block)
        elif block[0].startswith("- "):
            out += bullets(block)
        elif block[0].startswith("    "):
            out += ["::", "", *(f"   {line}" for line in block)]
        else:
            out.append(inline(" ".join(line.strip() for line in block)))
        out.append("")
    return out


def process(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = converted(lines)
    if not any(lines):  # autodoc drops text that looks like a signature: "time [s]"
        logging.getLogger(__name__).warning("%s has no text in the reference", name)


def skip(app: Any, what: str, name: str, obj: Any, skipped: bool, options: Any) -> bool | None:
    """Omits the fields of named tuples, because the docstring of the class describes them."""
    return True if (obj.__doc__ or "").startswith("Alias for field number") else None


def setup(app: Any) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", process)
    app.connect("autodoc-skip-member", skip)
    return {"parallel_read_safe": True}
