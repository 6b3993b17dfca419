"""The command-line application with its help, and the session in which every command runs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import typer

from .. import _core
from .._core import Communicator, Error
from ..ranks import launched_rank, share_failure

__all__ = ["app", "main", "report", "session"]

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"max_content_width": 100},
    rich_markup_mode=None,  # plain text, because units in brackets are not markup
    help="""Simulates cloth and renders it.

    A scene file is Python with a function scene() that returns a loomstone.Scene; see the
    directory scenes. First steps:

    \b
        loomstone run scenes/hanging.py --out out/hanging --render
        loomstone info out/hanging
    """,
)

report = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Virtual laboratory tests against published values.",
)
app.add_typer(report, name="report")


@contextmanager
def session(parallel: bool = True) -> Iterator[Communicator]:
    """Yields the communicator of the ranks that run a command, and reports errors.

    An error of loomstone is printed as one sentence. A failure on one rank ends all ranks.
    """

    def fail(message: str) -> NoReturn:
        print(f"loomstone: {message}", file=sys.stderr, flush=True)
        raise typer.Exit(1)

    communicator = _core.single_communicator()
    if parallel and _core.launched_by_mpi():
        try:
            communicator = _core.mpi_communicator()
        except Error as error:  # the same on all ranks
            if launched_rank() != 0:
                raise typer.Exit(1) from None
            fail(str(error))
    try:
        yield communicator
    except (Error, OSError) as error:
        share_failure(communicator, error)
        if communicator.rank != 0:  # rank 0 has received the same error and prints it
            raise typer.Exit(1) from None
        fail(str(error))
    except AssertionError as error:
        fail(f"a claim does not hold: {error}")
    except KeyboardInterrupt:
        fail("interrupted")
    except (typer.Exit, typer.Abort):
        raise
    except BaseException:
        if communicator.size > 1:
            import traceback

            traceback.print_exc()
            sys.stderr.flush()
            communicator.abort(1)
        raise


def main() -> Any:
    """Entry point of the command `loomstone`."""
    return app()
