"""The code blocks of a Markdown page, and how they run.

Every block names its language. Blocks of Python and of the shell run in order, in a directory that
stands for the root of the repository. Three remarks in the text before a block change this:

- a sentence with "save" and one `name` in backticks, ending in a colon: the block is this file
- `<!-- not run: reason -->`: the block does not run
- `<!-- runs nightly: reason -->`: the block runs only with the slow tests
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PAGES = sorted(
    path
    for path in (
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        ROOT / "core/references.md",
    )
)
LANGUAGES = {"python", "sh", "text"}
FENCE = re.compile(r"(?ms)^( *)```(.*?)\n(.*?)^\1```$")
REMARK = re.compile(r"<!-- (not run|runs nightly): (.+?) -->\s*\Z", re.S)
SAVED = re.compile(r"\b[Ss]ave\b[^`]*`([\w.]+)`[^`]*:\s*\Z")


@dataclass(frozen=True)
class Block:
    line: int  # number of its first line of code in the page
    language: str
    code: str
    remark: str  # "not run", "runs nightly" or empty
    reason: str
    file: str  # name of the file whose content the block shows, or empty


def blocks(page: str) -> list[Block]:
    """Returns the code blocks of a page in order, without directives of Sphinx."""
    found, end = [], 0
    for match in FENCE.finditer(page):
        before, end = page[end : match.start()], match.end()
        remark = REMARK.search(before)
        saved = SAVED.search(before[: remark.start()] if remark else before)
        if match[2].startswith("{"):
            continue
        found.append(
            Block(
                line=page.count("\n", 0, match.start(3)) + 1,
                language=match[2],
                code=re.sub(f"(?m)^{match[1]}", "", match[3]),
                remark=remark[1] if remark else "",
                reason=remark[2] if remark else "",
                file=saved[1] if saved else "",
            )
        )
    return found


class Session:
    """One page read from top to bottom by somebody who pastes every block."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.names: dict[str, object] = {"__name__": "__main__"}
        for name in (".venv", "build", "core", "scenes", "tests"):
            if (ROOT / name).exists():
                (directory / name).symlink_to(ROOT / name)

    def run(self, block: Block, page: Path) -> None:
        where = f"{page.relative_to(ROOT)}, line {block.line}"
        if block.file:
            (self.directory / block.file).write_text(block.code, encoding="utf-8")
            self.names["__file__"] = str(self.directory / block.file)
        if block.language == "python":
            # With the empty lines, tracebacks give line numbers of the page.
            code = "\n" * (block.line - 1) + block.code
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(code, str(page), "exec"), self.names)
        elif block.language == "sh":
            self.run_shell(block.code, where)

    def run_shell(self, code: str, where: str) -> None:
        programs = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
        environment = {
            **os.environ,
            "PATH": programs,
            "OMP_WAIT_POLICY": "passive",
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        }
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", code],
            cwd=self.directory,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,  # ends a block that hangs
        )
        assert done.returncode == 0, f"{where}\n{code}\n{done.stdout}\n{done.stderr}"
