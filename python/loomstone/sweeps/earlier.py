"""Runs that earlier sweeps of the same scene have finished in the directory of a sweep."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from inspect import Parameter
from pathlib import Path
from typing import Any

from .._core import CacheError
from ..runs.cache import Run
from ..runs.scene_file import SceneFile
from ..runs.stored_program import stored_program
from .plan import Point
from .point import finished

__all__ = ["with_earlier"]


def with_earlier(points: Sequence[Point], file: SceneFile, out: Path) -> list[Point]:
    """Returns the points and, after them, those of other finished runs of `file` in `out`.

    A parameter that is missing at some of these points gets its default there, if it has one.
    """
    own = {point.directory.name for point in points}
    places = sorted(path.parent for path in out.glob("*/log.txt"))
    found = [_earlier(place, file) for place in places if place.name not in own]
    every = [*points, *(point for point in found if point)]
    names = list(dict.fromkeys(name for point in every for name in point.parameters))
    defaults = {
        name: file.known[name]
        for name in names
        if file.known.get(name, Parameter.empty) is not Parameter.empty
    }
    return [_filled(point, names, defaults) for point in every]


def _earlier(directory: Path, file: SceneFile) -> Point | None:
    """Returns the point of the run in a directory; None unless it is a finished run of `file`."""
    if not finished(directory):
        return None
    try:
        with Run(directory) as run:
            program = stored_program(run)
    except CacheError:
        return None
    return Point(program.parameters, directory) if program.source == file.source else None


def _filled(point: Point, names: Sequence[str], defaults: dict[str, Any]) -> Point:
    values = defaults | point.parameters
    return dataclasses.replace(point, parameters={n: values[n] for n in names if n in values})
