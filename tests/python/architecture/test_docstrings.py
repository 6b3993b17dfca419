"""The examples in docstrings give the output that they show."""

import doctest
import importlib
import pkgutil

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
