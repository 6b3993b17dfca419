"""Integrators: a class for each, with the fields it has, and Integrator, the base of all.

Fields and defaults are those of the C++ descriptions.

>>> import loomstone as ls
>>> ls.BDF2(step=2e-3).method
'bdf2'
>>> isinstance(ls.BDF2(), ls.Integrator)
True
"""

from __future__ import annotations

from typing import Any

from ._core import (
    BDF2,
    BackwardEuler,
    ExplicitEuler,
    ImplicitMidpoint,
    Integrator,
    InvalidInput,
    NonlinearMidpoint,
    SemiImplicitEuler,
    SymplecticEuler,
)

__all__ = [
    "BDF2",
    "BackwardEuler",
    "ExplicitEuler",
    "ImplicitMidpoint",
    "Integrator",
    "NonlinearMidpoint",
    "SemiImplicitEuler",
    "SymplecticEuler",
]

# By the names that the command line and files use.
METHODS: dict[str, type[Integrator]] = {
    kind.method: kind
    for kind in (
        BDF2,
        BackwardEuler,
        ExplicitEuler,
        ImplicitMidpoint,
        NonlinearMidpoint,
        SemiImplicitEuler,
        SymplecticEuler,
    )
}


def with_method(options: Integrator, name: str, where: str = "integrator") -> Integrator:
    """The integrator of this name with those values of `options` that it has a field for."""
    if name not in METHODS:
        raise InvalidInput(f"{where} must be one of {', '.join(sorted(METHODS))}, got {name!r}")
    return _made(METHODS[name], options.to_dict())


def to_record(options: Integrator) -> dict[str, Any]:
    """Plain values for JSON, the method's name among them."""
    return {"method": options.method, **options.to_dict()}


def from_record(record: dict[str, Any]) -> Integrator:
    """The integrator of which to_record() made this; KeyError where there is none of its name."""
    return _made(METHODS[record["method"]], record)


def _made(kind: Any, values: dict[str, Any]) -> Integrator:
    made: Integrator = kind(**{name: values[name] for name in kind.field_names if name in values})
    return made
