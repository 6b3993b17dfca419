"""Parameters of scene(): values given as text, and the types that scene() expects.

The annotation of a parameter decides which values it accepts. If there is no annotation that can be
evaluated, but a default of type bool, int, float or str, the type of the default decides. In all
other cases, the parameter accepts every value.
"""

from __future__ import annotations

import ast
import inspect
import json
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Union

from .._core import InvalidInput

__all__ = [
    "Given",
    "Parameter",
    "given_parameters",
    "literals",
    "parameters_of",
    "parse_parameters",
]


@dataclass(frozen=True)
class Given:
    """A value as given on the command line by -p name=text."""

    name: str
    text: str

    @property
    def value(self) -> Any:
        """The value of the text if it is a Python literal, or else the text.

        A number such as 5e3, with an exponent and without a point, is an int if it is whole. Raises
        InvalidInput for literals that cannot be stored as JSON, such as 1e400, which is infinite.
        """
        try:
            value = ast.literal_eval(self.text)
        except (ValueError, SyntaxError, TypeError):  # TypeError: a set of lists
            value = self.text
        if (
            isinstance(value, float)
            and value.is_integer()
            and "e" in self.text.lower()
            and "." not in self.text
        ):
            value = int(value)  # a value such as 5e3 counts as a whole number
        try:
            json.dumps(value, allow_nan=False)
        except (TypeError, ValueError):
            raise InvalidInput(
                f"-p {self.name} must be a number, text, list or dict, without infinite numbers,"
                f" got {self.text}"
            ) from None
        return value

    @property
    def words(self) -> str:
        """The text as it stands or, if it is a Python string literal, the value of this literal."""
        try:
            value = ast.literal_eval(self.text)
        except (ValueError, SyntaxError, TypeError):  # TypeError: a set of lists
            return self.text
        return value if isinstance(value, str) else self.text


def given_parameters(items: Sequence[str]) -> dict[str, Given]:
    """Splits items such as "triangles=5000" and "fabric=silk" at the equals signs.

    Raises InvalidInput for an item of another form, or a name that is given twice.
    """
    found: dict[str, Given] = {}
    for item in items:
        name, equals, text = item.partition("=")
        if not equals or not name.isidentifier():
            raise InvalidInput(
                f"-p must be name=value, got {item!r}; for instance -p triangles=5000"
            )
        if name in found:
            raise InvalidInput(f"-p {name} must be given once, got {found[name].text} and {text}")
        found[name] = Given(name, text)
    return found


def parse_parameters(items: Sequence[str]) -> dict[str, Any]:
    """Parses items such as "triangles=5000" and "fabric=silk".

    Values are Python literals where possible, and text otherwise.
    """
    return {name: given.value for name, given in given_parameters(items).items()}


def literals(parameters: Mapping[str, Any]) -> dict[str, str]:
    """Returns Python literals of the values that JSON would change, such as tuples."""
    return {
        name: repr(value)
        for name, value in parameters.items()
        if repr(json.loads(json.dumps(value))) != repr(value)
    }


class _Refused(Exception):
    """Raised for a value that a type does not accept."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of scene().

    kind : the type in its annotation; inspect.Parameter.empty without an annotation that can be
        evaluated
    """

    name: str
    default: Any
    kind: Any

    @property
    def takes_text(self) -> bool:
        """Whether the type of the parameter accepts only strings."""
        choices = typing.get_args(self._kind)
        if typing.get_origin(self._kind) is Literal:
            return all(isinstance(choice, str) for choice in choices)
        return self._kind is str

    @property
    def _kind(self) -> Any:
        if self.kind is not inspect.Parameter.empty:
            return self.kind
        return type(self.default) if type(self.default) in (bool, int, float, str) else Any

    def read(self, given: Any) -> Any:
        """Returns the value that scene() gets for `given`, which is a Given or any other value.

        Raises InvalidInput if the type of the parameter does not accept `given`. None is always
        accepted if it is the default.
        """
        try:
            value = _read(given, self._kind)
        except _Refused:
            value = given.value if isinstance(given, Given) else given
            if value is None and self.default is None:
                return None
            raise InvalidInput(
                f"parameter {self.name} must be {_described(self._kind)}{self._like()}, got"
                f" {value!r}"
            ) from None
        untyped = self.kind is inspect.Parameter.empty and isinstance(value, (list, tuple))
        if untyped and type(self.default) in (list, tuple):
            return type(self.default)(value)
        return value

    def _like(self) -> str:
        """Returns " like " and the default, as an example in a message.

        Returns "" if the type does not accept the default, or is neither in _NAMES nor a list or
        tuple of given types.
        """
        try:
            default = _read(self.default, self._kind)
        except _Refused:
            return ""
        simple = self._kind in _NAMES or typing.get_origin(self._kind) in (list, tuple)
        return f" like {default!r}" if simple else ""


def parameters_of(function: Callable[..., Any], names: Mapping[str, Any]) -> dict[str, Parameter]:
    """Returns the parameters of a function that can be given by name.

    names : global names for the evaluation of annotations that are given as text
    """
    return {
        p.name: Parameter(p.name, p.default, _evaluated(p.annotation, names))
        for p in inspect.signature(function).parameters.values()
        if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)
    }


def _evaluated(annotation: Any, names: Mapping[str, Any]) -> Any:
    """Returns the type in an annotation; inspect.Parameter.empty if it cannot be evaluated."""
    if annotation is inspect.Parameter.empty:
        return annotation
    holder = types.SimpleNamespace(__annotations__={"it": annotation})
    try:
        return typing.get_type_hints(holder, dict(names))["it"]
    except Exception:  # the text of an annotation may be any expression
        return inspect.Parameter.empty


_NAMES = {
    bool: "a bool",
    int: "an int",
    float: "a float",
    str: "a str",
    list: "a list",
    tuple: "a tuple",
    type(None): "None",
}


def _is_union(kind: Any) -> bool:
    return typing.get_origin(kind) in (Union, types.UnionType)


def _described(kind: Any) -> str:
    if kind in _NAMES:
        return _NAMES[kind]
    if typing.get_origin(kind) is Literal:
        return " or ".join(map(repr, typing.get_args(kind)))
    if _is_union(kind):
        return " or ".join(map(_described, typing.get_args(kind)))
    return f"a {str(kind).replace('typing.', '')}"


def _read(value: Any, kind: Any) -> Any:
    """Returns a value converted to `kind`, or raises _Refused if this type does not accept it.

    Types other than bool, int, float, str, None, list, tuple, Literal and unions accept every
    value. A Given is read as its `words` for str and for strings of a Literal, otherwise as its
    `value`.
    """
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if _is_union(kind):
        return _of_union(value, arguments)
    if origin is Literal:
        return _of_literal(value, arguments)
    if kind is str:
        return _text(value)
    value = value.value if isinstance(value, Given) else value
    if kind is bool and value in ("true", "false"):
        return value == "true"
    if kind is float and type(value) is int:
        return float(value)
    if kind is int and type(value) is float and value.is_integer():
        return int(value)
    if kind in (bool, int, float, type(None)):
        if type(value) is not kind:
            raise _Refused
        return value
    if origin in (list, tuple) or kind in (list, tuple):
        return _of_sequence(value, origin or kind, arguments)
    return value


def _text(value: Any) -> str:
    if isinstance(value, Given):
        return value.words
    if not isinstance(value, str):
        raise _Refused
    return value


def _of_union(value: Any, kinds: Sequence[Any]) -> Any:
    """Returns `value` as read by the first of `kinds` that accepts it.

    They are tried in their order, with two exceptions. str comes last, because it accepts any text.
    If the value is a float, int comes after all others except str.
    """
    decimal = type(value.value if isinstance(value, Given) else value) is float
    for kind in sorted(kinds, key=lambda kind: (kind is str, kind is int and decimal)):
        try:
            return _read(value, kind)
        except _Refused:
            continue
    raise _Refused


def _of_literal(value: Any, choices: Sequence[Any]) -> Any:
    for choice in choices:
        form = value
        if isinstance(value, Given):
            form = value.words if isinstance(choice, str) else value.value
        if type(form) is type(choice) and form == choice:
            return choice
    raise _Refused


def _of_sequence(value: Any, kind: type[Any], elements: Sequence[Any]) -> Any:
    if not isinstance(value, (list, tuple)):
        raise _Refused
    if kind is list or elements[1:] == (...,):
        elements = list(elements[:1] or (Any,)) * len(value)
    elif not elements:
        elements = [Any] * len(value)
    if len(elements) != len(value):
        raise _Refused
    return kind(_read(each, of) for each, of in zip(value, elements, strict=True))
