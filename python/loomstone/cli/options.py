"""Arguments and options shared by several commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated

import typer

__all__ = [
    "AsJson",
    "Decomposition",
    "Parameters",
    "Quiet",
    "RecordTasks",
    "Render",
    "RunArgument",
    "SceneArgument",
    "StoredDecomposition",
    "StoredRecordTasks",
    "Threads",
    "Trust",
    "one_of",
]


def one_of(names: Iterable[str]) -> Callable[[str], list[str]]:
    """Returns a function that lists the `names` that begin with a text, for shell completion."""
    known = sorted(names)

    def matching(incomplete: str) -> list[str]:
        return [name for name in known if name.startswith(incomplete)]

    return matching


SceneArgument = Annotated[Path, typer.Argument(help="Python file with a function scene()")]
RunArgument = Annotated[Path, typer.Argument(help="directory of a run")]
Parameters = Annotated[
    list[str],
    typer.Option("-p", "--parameter", help="parameter of scene() as name=value; may be repeated"),
]
Threads = Annotated[
    int, typer.Option(help="number of threads; 0: OMP_NUM_THREADS or all processors", min=0)
]
_DECOMPOSITION = (
    "predicted | static | dynamic: how ranks divide the search for collisions; results do not"
    " depend on it"
)
_RECORD_TASKS = "record the motion of surfaces in every n-th step for loomstone replay; 0: never"
_STORED = "; default: as the run began"
Decomposition = Annotated[str, typer.Option(help=_DECOMPOSITION)]
StoredDecomposition = Annotated[str | None, typer.Option(help=_DECOMPOSITION + _STORED)]
RecordTasks = Annotated[int, typer.Option(help=_RECORD_TASKS, min=0)]
StoredRecordTasks = Annotated[int | None, typer.Option(help=_RECORD_TASKS + _STORED, min=0)]
Render = Annotated[bool, typer.Option("--render", help="draw every frame and make a video")]
Quiet = Annotated[bool, typer.Option("--quiet", help="print only warnings and errors")]
AsJson = Annotated[bool, typer.Option("--json", help="print only the result, as JSON")]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        help="run the program stored in the run even if it differs from the scene file on disk",
    ),
]
