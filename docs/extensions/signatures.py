"""Takes the signatures of the compiled module from its stub, _core.pyi, for autodoc.

Types are shown in a short form. Classes get an attribute __signature__, because handlers of the
event autodoc-process-signature can only replace a signature that autodoc has found.
"""

from __future__ import annotations

import ast
import inspect
import re
from functools import cache
from pathlib import Path
from typing import Any

import loomstone
from loomstone import _core
from numpy.typing import ArrayLike
from sphinx.util.inspect import stringify_signature
from sphinx.util.typing import stringify_annotation

STUB = Path(loomstone.__file__).parent / "_core.pyi"
NUMBERS = {
    "typing.SupportsFloat | typing.SupportsIndex": "float",
    "typing.SupportsInt | typing.SupportsIndex": "int",
}


# Matches the type of an array in an annotation: `Floats`, or numpy's full type. A ~ tells Sphinx to
# hide the name of the module.
ARRAY = re.compile(
    r"\bFloats\b|~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[(~?[\w.]+)\]\]"
)


def with_arrays(text: str) -> str:
    """Replaces types of arrays in annotations by short names, such as NDArray[float64]."""
    array_like = stringify_annotation(ArrayLike, "smart", short_literals=True)
    text = text.replace(array_like, "ArrayLike")
    return ARRAY.sub(lambda match: f"NDArray[{match[1] or 'float64'}]", text)


class WithoutAnnotated(ast.NodeTransformer):
    """Replaces Annotated[type, ...] by the type, because the docstrings state array shapes."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        if ast.unparse(node.value) == "typing.Annotated" and isinstance(node.slice, ast.Tuple):
            return node.slice.elts[0]
        return node


class Shown:
    """A default value that is shown as its source text."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def shortened(node: ast.expr | None) -> Any:
    """Returns a type as a string without module names.

    The result is an empty annotation for Any and object, and if there is no type.
    """
    text = ast.unparse(WithoutAnnotated().visit(node)) if node else "typing.Any"
    for long, short in NUMBERS.items():
        text = text.replace(long, short)
    text = re.sub(r"\b(loomstone\._core|collections\.abc|numpy\.typing|typing|numpy)\.", "", text)
    return inspect.Signature.empty if text in {"Any", "object"} else text


def signature(function: ast.FunctionDef) -> inspect.Signature:
    """Returns the signature of a function of the stub without `self`."""
    given = function.args
    positional = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(positional) - len(given.defaults)) + list(given.defaults)
    found = []
    for kind, arguments, values in (
        (inspect.Parameter.POSITIONAL_OR_KEYWORD, positional, defaults),
        (inspect.Parameter.KEYWORD_ONLY, given.kwonlyargs, given.kw_defaults),
    ):
        for argument, value in zip(arguments, values, strict=True):
            default = inspect.Parameter.empty if value is None else Shown(ast.unparse(value))
            kept = inspect.Parameter(
                argument.arg, kind, default=default, annotation=shortened(argument.annotation)
            )
            found += [kept] if argument.arg != "self" else []
    return inspect.Signature(found, return_annotation=shortened(function.returns))


@cache
def stub() -> dict[str, inspect.Signature]:
    """Returns the stub's signatures by name ("TriangleMesh.moved", "TriangleMesh.__init__").

    If a function is overloaded, its first signature is used.
    """
    found: dict[str, inspect.Signature] = {}
    for node in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.setdefault(node.name, signature(node))
        elif isinstance(node, ast.ClassDef):
            for method in node.body:
                if isinstance(method, ast.FunctionDef):
                    found.setdefault(f"{node.name}.{method.name}", signature(method))
    return found


def give_signatures_to_classes() -> None:
    for described in vars(_core).values():
        if not isinstance(described, type):
            continue
        made = stub().get(f"{described.__name__}.__init__", inspect.Signature())
        # Without a signature of their own, derived classes would show that of their base.
        for derived in described.__subclasses__():
            if derived.__module__ != "loomstone._core":
                derived.__signature__ = inspect.signature(derived)
        described.__signature__ = made.replace(return_annotation=inspect.Signature.empty)


def process(app: Any, what: str, name: str, obj: Any, *given: Any) -> tuple[str, str] | None:
    """Returns the arguments and return type of a signature as strings; None without a signature.

    given : the options of autodoc, and the arguments and the return type that autodoc has found
    """
    _, signature, result = given
    if signature is None:
        return None
    known = stub().get(".".join(name.split(".")[-2 if what == "method" else -1 :]))
    if what not in {"function", "method"} or hasattr(obj, "__code__") or known is None:
        return with_arrays(signature), with_arrays(result or "")
    returned = known.return_annotation
    arguments = stringify_signature(known, show_return_annotation=False)
    return arguments, "" if returned is inspect.Signature.empty else returned


def setup(app: Any) -> dict[str, bool]:
    give_signatures_to_classes()
    app.connect("autodoc-process-signature", process)
    return {"parallel_read_safe": True}
