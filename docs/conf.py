"""Configuration of the documentation, which scripts/docs builds.

The pages are the Markdown files that include_patterns names. They keep their paths, so that
relative links work in the documentation as in the repository. The Python reference comes from
docstrings and _core.pyi.
"""

import sys
from pathlib import Path

import loomstone

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))

project = "loomstone"
author = "the loomstone developers"
copyright = author
version = release = loomstone.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "docstrings",
    "signatures",
    "fields",
    "scene_gallery",
    "commands",
]
root_doc = f"{HERE.name}/index"
include_patterns = [
    "docs/**",
    "core/references.md",
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
]
exclude_patterns = [".venv", ".git", "build*", "out", "dist", "tests", "python", "scenes", "**/__*"]

myst_heading_anchors = 4
smartquotes = False  # keeps straight quotes, because most of them are code

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True  # shows defaults as they are written
autodoc_typehints_format = "short"
python_display_short_literal_types = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 90
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"loomstone {version}"
html_extra_path = ["redirect"]  # contains index.html, which redirects to the first page
html_copy_source = False
