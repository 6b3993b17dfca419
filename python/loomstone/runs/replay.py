"""Predicts the time of collision searches on many ranks from the recorded motions of a run."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from .._core import (
    CacheError,
    CollisionReplay,
    InvalidInput,
    RecordedLists,
    RecordedTests,
    ReplayReport,
)
from .motions import motion_files, read_motion
from .tables import write_table

__all__ = [
    "REPLAYED",
    "Network",
    "Prediction",
    "parse_ranks",
    "read_predictions",
    "replay",
    "write_predictions",
]

REPLAYED = ("predicted", "static", "dynamic")
MOST_RANKS = 65536


@dataclass(frozen=True)
class Network:
    """Model of the network between ranks.

    latency : time that a message takes in addition to its size / bandwidth [s]
    bandwidth : data rate between two ranks [bytes/s]
    overhead : processor time to send, receive or poll for a message [s]
    poll_interval : time between two polls of a rank that has work [s]
    """

    latency: float = 1.5e-6
    bandwidth: float = 1e10
    overhead: float = 0.2e-6
    poll_interval: float = 5e-6


@dataclass
class Prediction:
    """Predicted time of all recorded collision searches on a number of ranks.

    latency : latency of the network [s]
    seconds : time until all ranks have all results, summed over the searches [s]
    exchange : the part of `seconds` in which ranks exchange results and costs [s]
    serial : time of the searches on one rank [s]
    busy : time spent on tests or neighbour lists, averaged over the ranks and summed over the
        searches [s]
    requests, refusals : number of requests by idle ranks for tasks, and number of refused requests
    transfers : number of tasks that moved to another rank
    """

    ranks: int
    decomposition: str
    latency: float
    seconds: float = 0.0
    exchange: float = 0.0
    serial: float = 0.0
    busy: float = 0.0
    requests: int = 0
    transfers: int = 0
    refusals: int = 0

    def add(self, report: ReplayReport, serial: float) -> None:
        """Adds a search, which takes `serial` [s] on one rank."""
        self.seconds += report.seconds
        self.exchange += report.exchange
        self.serial += serial
        self.busy += report.mean_busy
        self.requests += report.requests
        self.transfers += report.transfers
        self.refusals += report.refusals

    @property
    def efficiency(self) -> float:
        """`serial` divided by the product of `ranks` and `seconds` [1]; 1 if `seconds` is 0."""
        return self.serial / (self.ranks * self.seconds) if self.seconds else 1.0


def parse_ranks(text: str) -> list[int]:
    """Returns numbers of ranks from a text such as "1:4096" (doubling) or "1,2,12", ascending.

    Raises InvalidInput for other text, and for numbers above MOST_RANKS.
    """
    numbers: list[int] = []
    try:
        for item in text.split(","):
            first, *last = map(int, item.split(":"))
            if len(last) > 1 or first < 1 or (last and last[0] < first):
                raise ValueError
            following = first
            while following <= (last or [first])[0] and following <= 2 * MOST_RANKS:
                numbers.append(following)
                following *= 2
    except ValueError:
        raise InvalidInput(
            "ranks must be whole numbers >= 1 such as 1,2,12, or a range such as 1:4096, got"
            f" {text!r}"
        ) from None
    if max(numbers) > MOST_RANKS:
        raise InvalidInput(f"ranks must be at most {MOST_RANKS}, got {max(numbers)}")
    return sorted(set(numbers))


def replay(
    directory: Path,
    ranks: Sequence[int],
    decompositions: Sequence[str],
    network: Network | None = None,
    observer: Callable[[str], None] | None = None,
) -> list[Prediction]:
    """Predicts the time of the recorded searches of a run for all given ranks and decompositions.

    The tests of the decompositions "static" and "dynamic" are measured again for every number of
    ranks, because the partitions depend on it. With "dynamic", costs in an earlier step determine
    with which tests each rank starts. The neighbour lists of "predicted" are measured once, and
    their costs in earlier steps determine which lists each rank gets. The time in which ranks
    update bounding volumes or search for new pairs of clusters does not count.

    observer : function called with the path of each motion before the motion is measured

    Raises CacheError if no motions were recorded or if a file is not a recorded motion, and OSError
    if a file cannot be read.
    """
    network = network or Network()
    files = motion_files(directory)
    if not files:
        raise CacheError(
            f"{directory}: has no recorded motions; run the scene with --record-tasks 10"
        )
    found = [Prediction(n, name, network.latency) for n in ranks for name in decompositions]
    for path in files:
        if observer:
            observer(str(path))
        motion = CollisionReplay(read_motion(path))
        if "predicted" in decompositions:
            for lists in motion.lists():
                _add_lists(lists, found, network)
        for search in (motion.contacts, motion.impacts):
            _add_searches(search, found, network)
    return found


def _add_searches(
    search: Callable[..., RecordedTests], predictions: Sequence[Prediction], network: Network
) -> None:
    """Measures the tests of `search` for the static and dynamic predictions, and replays them."""
    divided = [each for each in predictions if each.decomposition != "predicted"]
    if not divided:
        return
    serial = search(1).work
    for prediction in divided:
        tests = search(prediction.ranks, decomposition=prediction.decomposition)
        report = tests.replay(
            prediction.decomposition,
            latency=network.latency,
            bandwidth=network.bandwidth,
            overhead=network.overhead,
            poll_interval=network.poll_interval,
        )
        prediction.add(report, serial)


def _add_lists(lists: RecordedLists, predictions: Sequence[Prediction], network: Network) -> None:
    for prediction in predictions:
        if prediction.decomposition == "predicted":
            report = lists.replay(
                prediction.ranks,
                latency=network.latency,
                bandwidth=network.bandwidth,
                overhead=network.overhead,
            )
            prediction.add(report, lists.work)


_COLUMNS = (
    "ranks",
    "decomposition",
    "latency",
    "seconds",
    "exchange",
    "serial",
    "efficiency",
    "busy",
    "requests",
    "transfers",
    "refusals",
)


def write_predictions(path: Path, predictions: Sequence[Prediction]) -> None:
    """Writes a table with one row for each prediction."""
    write_table(path, _COLUMNS, [[getattr(p, name) for name in _COLUMNS] for p in predictions])


def read_predictions(path: Path) -> list[Prediction]:
    """Returns the predictions in a table, or an empty list if there is no such file.

    Raises CacheError if the file is not such a table.
    """
    types = {field.name: field.type for field in fields(Prediction)}
    convert = {"int": int, "float": float, "str": str}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file, strict=True))
        found = [
            Prediction(**{n: convert[str(t)](row[n]) for n, t in types.items()}) for row in rows
        ]
        for each in found:
            numbers = [value for value in vars(each).values() if not isinstance(value, str)]
            if each.ranks < 1 or not all(0 <= value < math.inf for value in numbers):
                raise ValueError(f"{each.ranks} ranks: all numbers must be finite and >= 0")
            if each.decomposition not in REPLAYED:
                raise ValueError(f"unknown decomposition {each.decomposition!r:.40}")
        return found
    except FileNotFoundError:
        return []
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise CacheError(
            f"{path}: is not a table of predictions ({error}); run `loomstone replay` again"
        ) from None
