"""Combinations of parameters, and the directory of each."""

from __future__ import annotations

import hashlib
import itertools
import json
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._core import CacheError, InvalidInput
from ..runs.parameters import Given, given_parameters
from ..runs.scene_file import SceneFile
from ..runs.writer import visible_names

__all__ = [
    "MOST_POINTS",
    "Point",
    "claim",
    "first_values",
    "open_with",
    "parse_values",
    "points_of",
]

MOST_POINTS = 100_000
_LONGEST_NAME = 120  # longest name without a hash; file systems allow 255 bytes
# A string literal that is followed by a comma or by the end of the text.
_QUOTED = re.compile(r"""('|")(?:\\.|(?!\1).)*\1(?=,|$)""")


@dataclass(frozen=True)
class Point:
    """One combination of parameters, and the directory of its run."""

    parameters: dict[str, Any]
    directory: Path

    @property
    def name(self) -> str:
        return self.directory.name


def parse_values(items: Sequence[str], texts: Collection[str] = ()) -> dict[str, list[Any]]:
    """Returns the values of each parameter of a sweep.

    Values are separated by commas; values with commas can be quoted. first:last:count gives equally
    spaced values, which are integers if all of them are whole and the text has no decimal point.
    Raises InvalidInput unless each item is name=values, each name is given once, the values of a
    name differ, ranges have finite ends and a count of at least 2, and there are at most
    MOST_POINTS combinations.

    texts : names of the parameters whose values are strings, even if they look like numbers or
        ranges

    >>> parse_values(["triangles=800,3200", "friction=0.1:0.5:5"])
    {'triangles': [800, 3200], 'friction': [0.1, 0.2, 0.3, 0.4, 0.5]}
    >>> parse_values(["case=free,parallel", "spheres=1:3:3"])
    {'case': ['free', 'parallel'], 'spheres': [1, 2, 3]}
    >>> parse_values(["title='one, two',three"])
    {'title': ['one, two', 'three']}
    """
    found: dict[str, list[Any]] = {}
    for item in items:
        name, text = next((each.name, each.text) for each in given_parameters([item]).values())
        pieces = _pieces(text)
        values = [value for piece in pieces for value in _values(name, piece, name in texts)]
        if name in found:
            raise InvalidInput(f"-p {name} must be given once; separate its values by commas")
        keys = [json.dumps(value) for value in values]
        if len(set(keys)) < len(keys):
            raise InvalidInput(f"-p {name} must have different values, got {text}")
        found[name] = values
    n_points = int(np.prod([len(each) for each in found.values()], dtype=float))
    if n_points > MOST_POINTS:
        raise InvalidInput(
            f"a sweep must have at most {MOST_POINTS} runs, got {n_points}; give fewer values"
        )
    return found


def first_values(items: Sequence[str]) -> dict[str, Any]:
    """Returns the first value of each parameter of a sweep, with which its scene can be opened.

    A range that parse_values() would refuse counts as a string, which the parameter may accept.

    >>> first_values(["triangles=800,3200", "case=1:2:1"])
    {'triangles': 800, 'case': '1:2:1'}
    """
    found = {}
    for item in items:
        each = next(iter(given_parameters([item]).values()))
        piece = _pieces(each.text)[0]
        try:
            found[each.name] = _values(each.name, piece, text=False)[0]
        except InvalidInput:
            found[each.name] = Given(each.name, piece).words
    return found


def _pieces(text: str) -> list[str]:
    """Splits a text at the commas that are neither inside brackets nor in a quoted piece.

    Omits empty pieces; if all are empty, returns one empty piece.

    >>> _pieces("'a, b',[1,2],it's")
    ["'a, b'", '[1,2]', "it's"]
    """
    pieces, depth, place = [""], 0, 0
    while place < len(text):
        quoted = _QUOTED.match(text, place) if not pieces[-1] else None
        taken = quoted[0] if quoted else text[place]
        place += len(taken)
        if not quoted:
            depth = max(0, depth + (taken in "([{") - (taken in ")]}"))
        if taken == "," and depth == 0:
            pieces.append("")
        else:
            pieces[-1] += taken
    return [piece for piece in pieces if piece] or [""]


def _values(name: str, piece: str, text: bool) -> list[Any]:
    given = Given(name, piece)
    return [given.words] if text else _spaced(name, piece) or [given.value]


def _spaced(name: str, text: str) -> list[Any]:
    """Returns the values of first:last:count, or an empty list if the text has another form.

    Raises InvalidInput if an end is not finite or the count is below 2.
    """
    parts = text.split(":")
    if len(parts) != 3:
        return []
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[2])
    except ValueError:
        return []
    if count < 2 or not np.isfinite([first, last]).all():
        raise InvalidInput(
            f"-p {name} must be first:last:count with finite numbers and at least 2 values, got"
            f" {text}"
        )
    # Values are rounded to 12 digits, to give 0.3 instead of 0.30000000000000004.
    values = [float(f"{value:.12g}") for value in np.linspace(first, last, count)]
    whole = all(value.is_integer() for value in values) and "." not in text
    return [int(value) for value in values] if whole else values


def points_of(values: dict[str, list[Any]], scene: Path, out: Path) -> list[Point]:
    """Returns a Point for each combination.

    A hash of the parameters is appended to the names of directories that combinations would share.

    Raises InvalidInput for values that the scene does not accept.
    """
    for name, several in values.items():
        for value in several:
            others = {other: each[0] for other, each in values.items()}
            open_with(scene, {**others, name: value})
    chosen = [dict(zip(values, each, strict=True)) for each in itertools.product(*values.values())]
    names = [_directory_name(each) for each in chosen]
    shared = {name for name, count in Counter(names).items() if count > 1}
    return [
        Point(each, out / (f"{name}_{_digest(each)}" if name in shared else name))
        for each, name in zip(chosen, names, strict=True)
    ]


def open_with(scene: Path, parameters: dict[str, Any]) -> SceneFile:
    """Opens a scene file with the values of a Point, read as `loomstone run` reads them."""
    return SceneFile.open(scene, {k: Given(k, repr(value)) for k, value in parameters.items()})


def _directory_name(parameters: dict[str, Any]) -> str:
    """Returns a name for a run with these parameters, independent of other runs of the sweep.

    A hash of the parameters is appended if characters are left out, if the name is cut short, or if
    a string could be read as a further parameter.

    >>> _directory_name({"triangles": 800, "friction": 0.1})
    'triangles-800_friction-0.1'
    """
    plain = "_".join(f"{name}-{value}" for name, value in parameters.items()) or "default"
    name = re.sub(r"[^A-Za-z0-9_.+-]", "", plain)
    clear = not any(isinstance(value, str) and "_" in value for value in parameters.values())
    if name == plain and len(name) <= _LONGEST_NAME and clear:
        return name
    return f"{name[:_LONGEST_NAME]}_{_digest(parameters)}"


def _digest(parameters: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(parameters).encode()).hexdigest()[:12]


def claim(out: Path, settings: dict[str, Any], *, besides: str = "") -> None:
    """Makes the directory of a sweep, or checks that an existing directory can be used.

    Raises CacheError if the directory cannot be written, if its runs have other settings, or if it
    contains files that no sweep has written.

    settings : what all runs have in common, stored as JSON in sweep.json
    besides : name of a file that may already be in the directory: the file of a Dask scheduler
    """
    note, before = out / "sweep.json", settings
    temporary = note.with_suffix(".new")
    try:
        out.mkdir(parents=True, exist_ok=True)
        if note.exists():
            before = json.loads(note.read_text())
            if not isinstance(before, dict):
                raise ValueError("it must contain a JSON object")
        elif others := [
            name for name in visible_names(out) if name not in (temporary.name, besides)
        ]:
            more = f" and {len(others) - 1} more" if len(others) > 1 else ""
            raise CacheError(
                f"{out} must be empty or absent, but contains {others[0]}{more}, which no sweep has"
                " written; give another directory by --out"
            )
        else:
            temporary.write_text(json.dumps(settings, indent=1) + "\n")
            temporary.replace(note)
    except CacheError:
        raise
    except OSError as error:
        raise CacheError(f"{out}: the sweep cannot be written: {error.strerror}") from error
    except ValueError as error:
        raise CacheError(f"{note} cannot be read: {error}; give another directory") from error
    if different := [name for name in settings if before.get(name) != settings[name]]:
        raise CacheError(
            f"{out} has runs of another {different[0]}; give another directory by --out, or the"
            " same scene and options"
        )
