"""Time integrators: one class for each method, and their base class Integrator.

The C++ core defines the fields of these classes and their defaults.

>>> import loomstone as ls
>>> ls.BDF2(step=2e-3).method
'bdf2'
>>> isinstance(ls.BDF2(), ls.Integrator)
True
"""

from __future__ import annotations

from typing import Any, Literal

from ._core import (
    BDF2,
    Asynchronous,
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
    "Asynchronous",
    "BackwardEuler",
    "ExplicitEuler",
    "ImplicitMidpoint",
    "Integrator",
    "NonlinearMidpoint",
    "SemiImplicitEuler",
    "SymplecticEuler",
]

# The integrator classes by the names that they have on the command line and in files.
METHODS: dict[str, type[Integrator]] = {
    kind.method: kind
    for kind in (
        BDF2,
        Asynchronous,
        BackwardEuler,
        ExplicitEuler,
        ImplicitMidpoint,
        NonlinearMidpoint,
        SemiImplicitEuler,
        SymplecticEuler,
    )
}


def with_method(options: Integrator, name: str, where: str = "integrator") -> Integrator:
    """Returns an integrator of the method `name`. Fields that `options` also has are copied.

    Raises InvalidInput for an unknown method.
    """
    check_method(name, where)
    return _made(METHODS[name], options.to_dict())


def check_method(name: str, where: str) -> None:
    """Raises InvalidInput unless `name` is an integration method, a key of METHODS.

    where : name of the option in the message
    """
    if name not in METHODS:
        raise InvalidInput(f"{where} must be one of {', '.join(sorted(METHODS))}, got {name!r}")


def parse_step(text: str) -> float | Literal["auto"]:
    """Parses the time step given on the command line: a number [s] or "auto"."""
    if text == "auto":
        return "auto"
    try:
        return float(text)
    except ValueError:
        raise InvalidInput(f"--step must be a time [s] or auto, got {text!r}") from None


def step_text(options: Integrator) -> str:
    """Returns a text such as "step 0.004 s" or "automatic steps"."""
    return "automatic steps" if options.step == "auto" else f"step {options.step:g} s"


def to_record(options: Integrator) -> dict[str, Any]:
    """Returns the fields as plain values for JSON, together with the name of the method."""
    return {"method": options.method, **options.to_dict()}


def from_record(record: dict[str, Any]) -> Integrator:
    """Returns the integrator that to_record() stored; raises KeyError if its method is unknown."""
    return _made(METHODS[record["method"]], record)


def _made(kind: Any, values: dict[str, Any]) -> Integrator:
    made: Integrator = kind(**{name: values[name] for name in kind.field_names if name in values})
    return made
