"""Runs one combination of parameters in a separate process."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base.safe_path import python
from ..runs.checkpoints import checkpoint_files
from ..runs.lock import DirectoryLock

__all__ = ["finished", "run_point"]

# A worker may be a task of srun or mpirun. Its runs must not count as ranks of that job, so they
# do not receive environment variables with these prefixes.
_OF_LAUNCHERS = ("OMPI_", "PMI", "MPI_LOCAL", "SLURM_STEP", "SLURM_PROCID")


def finished(directory: Path) -> dict[str, Any] | None:
    """Returns the report of a finished run, or None."""
    try:
        report = json.loads((directory / "report.json").read_text())
    except (OSError, ValueError):
        return None
    return report if isinstance(report, dict) else None


def run_point(
    directory: str,
    arguments: list[str],
    options: list[str],
    watch: Callable[[subprocess.Popen[bytes]], None] = lambda _: None,
) -> int:
    """Runs or resumes a scene in a directory; returns the exit code.

    A run that has finished before is not repeated, and gives 0.

    arguments : arguments of `loomstone run`, without --out
    options : further options, which `loomstone run` and `loomstone resume` both accept
    watch : function called with the process when it has started

    The output is appended to log.txt. The process of the run holds a lock on the directory until it
    ends, even if the worker that started it is killed. Another worker waits for the lock.
    """
    place = Path(directory)
    place.mkdir(parents=True, exist_ok=True)
    with DirectoryLock(place, "lock") as lock, (place / "log.txt").open("ab") as log:
        lock.take(wait=True)
        if finished(place):
            return 0
        command = [*python(), "-m", "loomstone"]
        if checkpoint_files(place):
            command += ["resume", directory, *options]
        else:  # a run that was killed before its first checkpoint begins again
            command += ["run", *arguments, "--out", directory, "--overwrite", *options]
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            pass_fds=lock.descriptors,
            env={k: v for k, v in os.environ.items() if not k.startswith(_OF_LAUNCHERS)},
        )
        watch(process)
        return process.wait()
