"""The directive `scene-gallery`: every scene file with docstring, picture, size, times and source.

tests/benchmarks/gallery.py draws the pictures and writes docs/gallery.json. A scene that is not in
docs/gallery.json appears without picture, size and times.
"""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "docs/gallery.json"


def measured(numbers: dict[str, float]) -> str:
    """Returns a text about a scene.

    It has the size, the duration, the computing time and the instant that the picture shows.
    """
    surfaces = [
        f"{numbers[key]:,} {key if key == 'triangles' else 'bodies and obstacles'}"
        for key in ("triangles", "bodies")
        if numbers[key]
    ]
    return (
        f"{', '.join(surfaces)}; {numbers['duration']:g} s of motion take"
        f" {numbers['processor_seconds']:g} s on one thread. The picture shows"
        f" {numbers['instant']:g} s."
    )


def entry(path: Path, numbers: dict[str, float] | None) -> str:
    """Returns one scene as Markdown."""
    name, source = path.stem, path.read_text(encoding="utf-8")
    said = ast.get_docstring(ast.parse(source)) or ""
    picture = f"![{said.splitlines()[0]}](../images/scenes/{name}.jpg)\n\n" if numbers else ""
    size = f"{measured(numbers)}\n\n" if numbers else ""
    return (
        f"## {name}\n\n{picture}{said}\n\n{size}"
        f"<details><summary>scenes/{name}.py</summary>\n\n"
        f"```{{literalinclude}} ../../scenes/{name}.py\n```\n\n</details>\n"
    )


class SceneGallery(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        table = json.loads(TABLE.read_text(encoding="utf-8"))
        self.env.note_dependency(str(TABLE))
        lines: list[str] = []
        for path in sorted((ROOT / "scenes").glob("*.py")):
            self.env.note_dependency(str(path))
            lines += entry(path, table.get(path.stem)).splitlines() + [""]
        found = nodes.section()
        found.document = self.state.document
        content = StringList(lines, source=str(TABLE))
        self.state.nested_parse(content, self.content_offset, found, match_titles=True)
        return found.children


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("scene-gallery", SceneGallery)
    return {"parallel_read_safe": True}
