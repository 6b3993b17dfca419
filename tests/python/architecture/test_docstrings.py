"""Public names have docstrings, whose examples give the output that they show."""

import doctest
import importlib
import inspect
import pkgutil
import re

import loomstone
import pytest

MODULES = [
    found.name
    for found in pkgutil.walk_packages(loomstone.__path__, "loomstone.")
    if not found.name.endswith(("__main__", "_mpi", "._core"))
]


@pytest.mark.parametrize("name", ["loomstone", *MODULES])
def test_the_examples_of_a_module_give_what_they_say(name):
    module = importlib.import_module(name)
    assert doctest.testmod(module).failed == 0


ROOMS = [loomstone] + [
    value for name in loomstone.__all__ if inspect.ismodule(value := getattr(loomstone, name))
]


def says_nothing(value, name):
    """Returns whether there is no docstring, or only the signature that pybind11 writes."""
    text = inspect.getdoc(value) or ""
    return not re.sub(rf"\A{name}\(.*\n*", "", text)


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: room.__name__)
def test_every_public_name_and_member_has_a_docstring(room):
    missing = []
    for name in room.__all__:
        public = getattr(room, name)
        members = vars(public).items() if isinstance(public, type) else ()
        missing += [name] if says_nothing(public, name) else []
        missing += [
            f"{name}.{member}"
            for member, value in members
            if isinstance(value, property) or callable(value)
            if not member.startswith("_") and says_nothing(value, member)
        ]
    assert not missing
