"""Runs all points (combinations of parameters) of a sweep: in processes on this machine, or on the
workers of a Dask cluster.

Dask distributes tasks to workers on any number of hosts, with and without Slurm. If a worker is
lost, Dask gives its tasks to other workers, which resume the runs from their checkpoints, if any.
"""

from __future__ import annotations

import importlib
import signal
import subprocess
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .._core import InvalidInput, Unsupported
from ..runs.signals import Interrupted, Received, noted_signals
from .plan import Point
from .point import run_point

__all__ = ["Command", "on_dask", "on_this_machine"]


@dataclass(frozen=True)
class Command:
    """Arguments of `loomstone run` for all points, and options of both `run` and `resume`."""

    arguments: list[str]
    options: list[str]

    def of(self, point: Point) -> tuple[str, list[str], list[str]]:
        """Returns the arguments of run_point, with an absolute path of the point's directory."""
        values = [word for k, v in point.parameters.items() for word in ("-p", f"{k}={v!r}")]
        return str(point.directory.resolve()), [*self.arguments, *values], self.options


def on_this_machine(
    points: Sequence[Point], command: Command, jobs: int
) -> Iterator[tuple[Point, int]]:
    """Runs at most `jobs` points at a time; yields each with its exit code when it ends.

    After SIGINT, SIGTERM or SIGUSR1, the runs in progress save their states and end, no further run
    begins, and Interrupted is raised.
    """
    with noted_signals() as received, ThreadPoolExecutor(jobs) as pool:
        running = _Running(received)
        futures = {
            pool.submit(running.run, *command.of(point), stop=received): point for point in points
        }
        watcher = threading.Thread(target=running.pass_signal_on, daemon=True)
        watcher.start()
        try:
            for future in as_completed(futures):
                code = future.result()
                if code is not None and not received.number:
                    yield futures[future], code
        finally:
            running.over.set()
        if received.number:
            raise Interrupted(received.number)


class _Running:
    """The processes of the runs in progress, to which a signal is passed on as SIGTERM."""

    def __init__(self, received: Received) -> None:
        self.over = threading.Event()
        self._received, self._lock = received, threading.Lock()
        self._processes: set[subprocess.Popen[bytes]] = set()

    def run(
        self, directory: str, arguments: list[str], options: list[str], stop: Received
    ) -> int | None:
        """Runs a point and returns its exit code, or None if a signal came before it began."""
        if stop.number:
            return None
        return run_point(directory, arguments, options, self._add)

    def _add(self, process: subprocess.Popen[bytes]) -> None:
        with self._lock:
            self._processes.add(process)

    def pass_signal_on(self) -> None:
        while not self.over.wait(0.1):
            if self._received.number:
                with self._lock:
                    ended = {process for process in self._processes if process.poll() is not None}
                    self._processes -= ended
                    for process in self._processes:
                        process.send_signal(signal.SIGTERM)
                self.over.wait(2.0)


def on_dask(
    points: Sequence[Point], command: Command, scheduler: str
) -> Iterator[tuple[Point, int]]:
    """Runs points on the workers of a Dask cluster; yields each with its exit code when it ends.

    scheduler : address of the scheduler, or its scheduler file

    A point whose workers die repeatedly has the exit code 137. Raises Unsupported without Dask, and
    InvalidInput if there is no such scheduler.
    """
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise Unsupported(
            "--scheduler needs Dask, which is not installed; pip install 'loomstone[cluster]'"
        ) from None
    target: dict[str, Any] = {"address": scheduler}
    if Path(scheduler).exists():
        target = {"scheduler_file": scheduler}
    try:
        client = distributed.Client(**target, timeout=20)
    except (OSError, ValueError) as error:
        raise InvalidInput(
            f"--scheduler must be the address or file of a Dask scheduler, got {scheduler!r}:"
            f" {error}"
        ) from None
    with client:
        futures = {
            client.submit(run_point, *command.of(point), pure=False): point for point in points
        }
        for future in distributed.as_completed(futures):
            try:
                code = future.result()
            except distributed.scheduler.KilledWorker:
                code = 128 + signal.SIGKILL
            yield futures[future], int(code)
