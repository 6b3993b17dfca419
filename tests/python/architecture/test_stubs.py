"""The committed stub matches the built module."""

import ast
from pathlib import Path

import loomstone
from loomstone import _core

STUB = Path(loomstone.__file__).parent / "_core.pyi"


def names_of(body):
    return {node.name for node in body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


def test_stub_and_module_have_the_same_names_members_and_keywords():
    tree = ast.parse(STUB.read_text())
    built = {name for name in dir(_core) if not name.startswith("_")}
    assert names_of(tree.body) == built, "run scripts/stubs"
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            members = {
                name
                for name, value in vars(getattr(_core, node.name)).items()
                if not name.startswith("_") and not isinstance(value, (str, tuple))
            }
            assert {name for name in names_of(node.body) if not name.startswith("_")} == members, (
                node.name
            )
            fields = getattr(getattr(_core, node.name), "field_names", ())
            made = [f for f in node.body if isinstance(f, ast.FunctionDef) and f.name == "__init__"]
            if fields:
                positional = made[0].args.args[1:]
                assert [a.arg for a in positional + made[0].args.kwonlyargs] == list(fields), (
                    node.name
                )
