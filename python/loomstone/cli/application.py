"""The command-line application with its help, and the session in which commands run."""

from __future__ import annotations

import os
import signal
import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any, NoReturn

import typer

from .. import _core
from .._core import Communicator, Error, InvalidInput
from ..base.cautions import SceneWarning
from ..base.claims import broken_claim
from ..base.interruption import leave_interrupts_to_python
from ..ranks import launched_rank, share_failure
from ..runs.signals import Abandoned
from .closed_streams import open_closed_streams

__all__ = [
    "WrongCommand",
    "app",
    "command_line",
    "main",
    "refuse_options",
    "report",
    "session",
]

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"max_content_width": 100},
    rich_markup_mode=None,  # plain text, because units in brackets are not markup
    help="""Simulates cloth, rigid bodies and magnets, and draws them.

    A scene file is Python with a function scene() that returns a loomstone.Scene. First steps:

    \b
        loomstone new mine.py
        loomstone run mine.py --out out/mine --render
        loomstone info out/mine
    """,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"loomstone {_core.__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="print the version, and exit"
        ),
    ] = False,
) -> None:
    pass


report = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Virtual laboratory tests against published values.",
)
app.add_typer(report, name="report")


class WrongCommand(InvalidInput):
    """Raised for an option or argument that is wrong whatever the scene or the run contains."""


@contextmanager
def command_line() -> Iterator[None]:
    """Turns an InvalidInput of the `with` block into a WrongCommand with the same message."""
    try:
        yield
    except InvalidInput as error:
        raise WrongCommand(str(error)) from error


def refuse_options(given: dict[str, bool], why: str) -> None:
    """Raises WrongCommand for the first option that is given although it has no effect.

    given : for each option, whether it differs from its default
    why : end of a sentence that begins with the option
    """
    for name in (name for name, is_given in given.items() if is_given):
        raise WrongCommand(f"{name} {why}; leave it out")


@contextmanager
def session(parallel: bool = True) -> Iterator[Communicator]:
    """Yields the communicator of the ranks that run a command, and reports errors.

    Errors of loomstone and of the operating system, and broken claims of scene files, are printed
    in one line. The exit code is then 2 for a WrongCommand, and 1 for the others. If one rank
    raises such an error, or an unexpected exception, all ranks end. If the reader of a pipe has
    closed the pipe, the command ends with exit code 1 and without a message. Ctrl-C ends the
    command with exit code 130, or with 1 if a signal has already asked a run to end.

    parallel : whether the ranks that MPI has launched work together; if False, each process runs
        the whole command
    """

    def fail(message: str, code: int = 1) -> NoReturn:
        print(f"loomstone: {message}", file=sys.stderr, flush=True)
        raise typer.Exit(code)

    leave_interrupts_to_python()
    communicator = _core.single_communicator()
    if parallel and _core.launched_by_mpi():
        try:
            communicator = _core.mpi_communicator()
        except Error as error:  # all ranks raise the same error
            if launched_rank() != 0:
                raise typer.Exit(1) from None
            fail(str(error))
    try:
        with _warnings_in_one_line():
            yield communicator
        sys.stdout.flush()  # Python would report a closed pipe only after the command
    except (Error, OSError, AssertionError) as error:
        failure = Error(broken_claim(error)) if isinstance(error, AssertionError) else error
        share_failure(communicator, failure)
        code = 2 if isinstance(error, WrongCommand) else 1
        if communicator.rank != 0:  # rank 0 has received the same error and prints it
            raise typer.Exit(code) from None
        if isinstance(error, BrokenPipeError):
            # Python flushes standard output once more when it exits. The null device accepts this.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(1) from None
        fail(_sentence(failure), code)
    except KeyboardInterrupt as error:
        abandoned = isinstance(error, Abandoned)
        code = 1 if abandoned else 128 + getattr(error, "signal", signal.SIGINT)
        try:
            fail("interrupted", code)
        finally:
            if communicator.size > 1:  # the other ranks may not have received the signal
                communicator.abort(code)
    except (typer.Exit, typer.Abort):
        raise
    except BaseException:
        if communicator.size > 1:
            traceback.print_exc()
            sys.stderr.flush()
            communicator.abort(1)
        raise


def _sentence(error: Exception) -> str:
    """Returns the message of an error; for an OSError, its reason after its file name, if any."""
    if isinstance(error, Error) or not isinstance(error, OSError) or not error.strerror:
        return str(error)
    return f"{error.filename}: {error.strerror}" if error.filename else error.strerror


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Prints each SceneWarning in the `with` block as one line on standard error."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", SceneWarning)
        show = warnings.showwarning

        def told(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
            if issubclass(category, SceneWarning):
                print(f"loomstone: warning: {message}", file=sys.stderr, flush=True)
            else:
                show(message, category, *where, **more)

        warnings.showwarning = told
        yield


def main() -> Any:
    """Entry point of the command `loomstone`."""
    open_closed_streams()
    return app()
