"""The code blocks of a Markdown page, and how they run.

Every block names its language. Blocks of Python and of the shell run in order, in a directory that
stands in for the root of the repository. Four things in the text before a block change this:

- a sentence with "save" and one `name` in backticks, ending in a colon: the block is first saved as
  this file
- `<!-- not run: reason -->`: the block does not run
- `<!-- runs nightly: reason -->`: the block runs only with the slow tests
- `<!-- output -->`: the block shows what the preceding block prints; `difference` compares the two
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from itertools import zip_longest
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
OUTPUT = re.compile(r"<!-- output -->\s*\Z")
SAVED = re.compile(r"\b[Ss]ave\b[^`]*`([\w.]+)`[^`]*:\s*\Z")


@dataclass(frozen=True)
class Block:
    line: int  # line of the page at which the code begins, counted from 1
    language: str
    code: str
    remark: str  # "not run", "runs nightly", "output" or empty
    reason: str
    file: str  # name of the file whose content the block shows, or empty


def blocks(page: str) -> list[Block]:
    """Returns the code blocks of a page in order, without directives of Sphinx."""
    found, end = [], 0
    for match in FENCE.finditer(page):
        before, end = page[end : match.start()], match.end()
        remark = REMARK.search(before)
        saved = SAVED.search(before[: remark.start()] if remark else before)
        output = OUTPUT.search(before) is not None
        if match[2].startswith("{"):
            continue
        found.append(
            Block(
                line=page.count("\n", 0, match.start(3)) + 1,
                language=match[2],
                code=re.sub(f"(?m)^{match[1]}", "", match[3]),
                remark="output" if output else remark[1] if remark else "",
                reason=remark[2] if remark else "",
                file=saved[1] if saved else "",
            )
        )
    return found


NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def difference(shown: str, printed: str) -> str:
    """Returns the first difference between the output that a page shows and the printed one.

    An empty result means that they agree. Words must be equal, and `...` in `shown` stands for any
    text of one line. Numbers may differ by 10 % or by one unit of the last decimal, because other
    compilers change last bits, which contacts amplify.
    """
    lines = zip_longest(shown.splitlines(), printed.splitlines())
    for line, given in lines:
        if line is None or given is None or not agree(line, given):
            return f"the page shows {line!r}, but the block prints {given!r}"
    return ""


def agree(line: str, given: str) -> bool:
    parts = re.split(rf"({NUMBER})", line)
    words = [re.escape(part).replace(r"\.\.\.", ".*?") for part in parts[::2]]
    match = re.fullmatch(f"({NUMBER})".join(words), given)
    return match is not None and all(
        abs(float(a) - float(b)) <= max(0.1 * abs(float(a)), 1.001 * last_digit(a))
        for a, b in zip(parts[1::2], match.groups(), strict=True)
    )


def last_digit(number: str) -> float:
    """Returns one unit of the last decimal of a number, and 0 for a number without decimals."""
    digits, _, power = number.partition("e")
    decimals = len(digits.partition(".")[2])
    return 10.0 ** (int(power or 0) - decimals) if decimals else 0.0


class Session:
    """Runs the blocks of one page in order, as if a reader pasted each of them."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.names: dict[str, object] = {"__name__": "__main__"}
        self.printed = ""  # output of the preceding block
        for name in (".venv", "build", "core", "scenes", "tests"):
            if (ROOT / name).exists():
                (directory / name).symlink_to(ROOT / name)

    def run(self, block: Block, page: Path) -> None:
        where = f"{page.relative_to(ROOT)}, line {block.line}"
        if block.remark == "output":
            assert not (found := difference(block.code, self.printed)), (
                f"{where}: {found}\n{self.printed}"
            )
            return
        self.printed = ""
        if block.file:
            (self.directory / block.file).write_text(block.code, encoding="utf-8")
            self.names["__file__"] = str(self.directory / block.file)
        if block.language == "python":
            # With the empty lines, tracebacks give line numbers of the page.
            code = "\n" * (block.line - 1) + block.code
            with contextlib.redirect_stdout(io.StringIO()) as output:
                exec(compile(code, str(page), "exec"), self.names)
            self.printed = output.getvalue()
        elif block.language == "sh":
            self.printed = self.run_shell(block.code, where)

    def run_shell(self, code: str, where: str) -> str:
        """Runs commands and returns their standard output. Raises AssertionError if one fails."""
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
        return done.stdout
