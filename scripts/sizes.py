"""Lists functions that exceed the size limits: 60 lines, 4 nested control structures, 6 parameters.

Functions named in tests/python/architecture/size_exceptions.txt are left out. Names in this file
that need not be there are listed, too. Keyword-only parameters in Python do not count, because a
call names them like the fields of a struct. Parameters of command-line commands do not count
either, because they are the command's options.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import lizard

ROOT = Path(__file__).resolve().parents[1]
EXCEPTIONS = ROOT / "tests/python/architecture/size_exceptions.txt"
LINES, NESTING, PARAMETERS = 60, 4, 6


@dataclass(frozen=True)
class Function:
    path: str
    name: str
    line: int
    lines: int
    nesting: int
    parameters: int

    @property
    def key(self) -> str:
        return f"{self.path} {self.name}"

    def excesses(self) -> list[str]:
        """Returns one message for each exceeded limit."""
        measured = [
            (self.lines, LINES, "lines"),
            (self.nesting, NESTING, "nested control structures"),
            (self.parameters, PARAMETERS, "parameters"),
        ]
        return [f"{n} {what} (at most {limit})" for n, limit, what in measured if n > limit]


# Python functions are measured on the syntax tree.

NESTING_NODES = (
    ast.For,
    ast.AsyncFor,
    ast.While,
    ast.If,
    ast.With,
    ast.AsyncWith,
    ast.Try,
    ast.Match,
)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def python_nesting(statements: list[ast.stmt]) -> int:
    return max((python_depth(statement) for statement in statements), default=0)


def python_depth(statement: ast.stmt) -> int:
    if isinstance(statement, (*FUNCTIONS, ast.ClassDef)) or not isinstance(
        statement, NESTING_NODES
    ):
        return 0
    depth = 0
    for field in ("body", "handlers", "finalbody", "cases"):
        for child in getattr(statement, field, []):
            inner = (
                child.body if isinstance(child, (ast.ExceptHandler, ast.match_case)) else [child]
            )
            depth = max(depth, 1 + python_nesting(inner))
    otherwise: list[ast.stmt] = getattr(statement, "orelse", [])
    chained = (
        isinstance(statement, ast.If) and len(otherwise) == 1 and isinstance(otherwise[0], ast.If)
    )
    return max(depth, python_nesting(otherwise) + (0 if chained else 1))


def python_parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    commands = [ast.unparse(d) for d in function.decorator_list]
    if any(".command(" in command or ".callback(" in command for command in commands):
        return 0
    positional = [a.arg for a in function.args.posonlyargs + function.args.args]
    return len(positional) - (positional[:1] in (["self"], ["cls"]))


def python_functions(path: str) -> Iterator[Function]:
    def visit(node: ast.AST, prefix: str) -> Iterator[Function]:
        for child in ast.iter_child_nodes(node):
            name = prefix
            if isinstance(child, (*FUNCTIONS, ast.ClassDef)):
                name = f"{prefix}.{child.name}".lstrip(".")
            if isinstance(child, FUNCTIONS):
                lines = (child.end_lineno or child.lineno) - child.lineno + 1
                depth = python_nesting(child.body)
                yield Function(path, name, child.lineno, lines, depth, python_parameters(child))
            yield from visit(child, name)

    yield from visit(ast.parse((ROOT / path).read_text()), "")


# In C++, lizard finds functions and parameters; nesting is counted on the tokens of each function.

TOKENS = re.compile(
    r"//[^\n]*|/\*.*?\*/|#[^\n]*|"  # comments, preprocessor
    r'R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|'  # strings, characters
    r"\w+|[^\w\s]",
    re.S,
)
COMMENTS = ("//", "/*", "#")


class CppNesting:
    """Counts the nesting depth of control structures in C++ text.

    An `else if` is as deep as its `if`; a lambda adds no depth.
    """

    def __init__(self, text: str):
        self.tokens = [t for t in TOKENS.findall(text) if not t.startswith(COMMENTS)]
        self.at = 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1]

    def depth(self) -> int:
        """Returns the largest nesting depth of the statements in the text."""
        deepest = 0
        while self.peek():
            deepest = max(deepest, self.statement())
        return deepest

    def block(self) -> int:
        deepest = 0
        self.take()
        while self.peek() and self.peek() != "}":
            deepest = max(deepest, self.statement())
        if self.peek():
            self.take()
        return deepest

    def parentheses(self) -> int:
        """Returns the nesting depth inside parentheses, where arguments may contain lambdas."""
        deepest, open_ = 0, 0
        while self.peek():
            if self.peek() == "{":
                deepest = max(deepest, self.block())
                continue
            token = self.take()
            open_ += (token == "(") - (token == ")")
            if open_ == 0:
                break
        return deepest

    def statement(self) -> int:
        token = self.peek()
        if token == "{":
            return self.block()
        if token in ("if", "for", "while", "switch", "catch"):
            return self.conditional()
        if token in ("do", "try"):
            self.take()
            return 1 + self.statement()
        return self.expression()

    def conditional(self) -> int:
        self.take()
        if self.peek() == "constexpr":
            self.take()
        depth = max(self.parentheses(), 1 + self.statement())
        if self.peek() == "else":
            self.take()
            chained = self.peek() == "if"
            depth = max(depth, self.statement() + (0 if chained else 1))
        return depth

    def expression(self) -> int:
        """Returns the nesting depth of a statement that ends in a semicolon, a colon or a block."""
        deepest = 0
        while self.peek() and self.peek() != "}":
            if self.peek() == "(":
                deepest = max(deepest, self.parentheses())
            elif self.peek() == "{":
                return max(deepest, self.block())
            elif self.take() in (";", ":"):
                break
        return deepest


def cpp_functions(path: str) -> Iterator[Function]:
    text = (ROOT / path).read_text()
    rows = text.splitlines()
    for found in lizard.analyze_file.analyze_source_code(path, text).function_list:
        body = "\n".join(rows[found.start_line - 1 : found.end_line])
        depth = CppNesting(body).depth()
        yield Function(
            path, found.name, found.start_line, found.length, depth, found.parameter_count
        )


def sources() -> list[str]:
    tracked = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    kinds = (".cpp", ".h", ".py")
    return [
        p for p in tracked if p.endswith(kinds) and "third_party" not in p and (ROOT / p).exists()
    ]


def offenders(paths: list[str]) -> list[Function]:
    found = []
    for path in paths:
        functions = python_functions(path) if path.endswith(".py") else cpp_functions(path)
        found += [function for function in functions if function.excesses()]
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--shrink", action="store_true", help="remove exceptions that are no longer needed"
    )
    found = offenders(sources())
    offending = {function.key for function in found}
    excepted = set(EXCEPTIONS.read_text().splitlines()) if EXCEPTIONS.exists() else set()
    if parser.parse_args().shrink:
        EXCEPTIONS.write_text("".join(f"{key}\n" for key in sorted(excepted & offending)))
        excepted &= offending
    new = [function for function in found if function.key not in excepted]
    for function in new:
        print(f"{function.path}:{function.line}: {function.name}: {', '.join(function.excesses())}")
    settled = sorted(excepted - offending)
    for key in settled:
        print(f"{EXCEPTIONS.name}: '{key}' is no longer needed; remove it by sizes.py --shrink")
    return 1 if new or settled else 0


if __name__ == "__main__":
    sys.exit(main())
