"""Predicts the time of collision searches on many ranks from the recorded motions of a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from .._core import CacheError, CollisionReplay, InvalidInput, RecordedTests
from .motions import motion_files, read_motion
from .tables import write_table

__all__ = ["REPLAYED", "Network", "Prediction", "parse_ranks", "replay", "write_predictions"]

REPLAYED = ("static", "dynamic")
MOST_RANKS = 65536


@dataclass(frozen=True)
class Network:
    """A network between ranks.

    latency : time that a message takes [s]
    bandwidth : [bytes/s]
    overhead : time on the processor to send, to receive or to look for a message [s]
    poll_interval : time between two polls of a rank that has work [s]
    """

    latency: float = 1.5e-6
    bandwidth: float = 1e10
    overhead: float = 0.2e-6
    poll_interval: float = 5e-6


@dataclass
class Prediction:
    """Predicted time of all recorded searches on a number of ranks.

    seconds : until all ranks have all results, summed over the searches [s]
    exchange : part of it in which ranks exchange results [s]
    serial : on one rank [s]
    busy : mean time that a rank spends on tests, summed over the searches [s]
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

    @property
    def efficiency(self) -> float:
        """Serial time over the time of all ranks together [1]."""
        return self.serial / (self.ranks * self.seconds) if self.seconds else 1.0


def parse_ranks(text: str) -> list[int]:
    """Returns numbers of ranks from a text such as "1:4096" (doubling) or "1,2,12"."""
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
            f"ranks must be numbers from 1 such as 1,2,12, or a range such as 1:4096, got {text!r}"
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
    """Predicts the time of the recorded searches of a run.

    The work of each recorded step is measured again for every number of ranks, because the
    partitions depend on it. Steps without candidate pairs count too. The time in which every rank
    updates its bounding volumes is the same on any number of ranks and does not count.

    observer : receives the path of each motion before it is measured

    Raises CacheError if no motions were recorded.
    """
    network = network or Network()
    files = motion_files(directory)
    if not files:
        raise CacheError(
            f"{directory}: has no recorded motions; run the scene with --record-tasks 10"
        )
    found = {
        (n, name): Prediction(n, name, network.latency) for n in ranks for name in decompositions
    }
    for path in files:
        if observer:
            observer(str(path))
        motion = CollisionReplay(read_motion(path))
        for search in (motion.contacts, motion.impacts):
            serial = search(1).work
            for n in ranks:
                _add(search(n), serial, n, found, network)
    return list(found.values())


def _add(
    tests: RecordedTests,
    serial: float,
    ranks: int,
    found: dict[tuple[int, str], Prediction],
    network: Network,
) -> None:
    for (n, name), prediction in found.items():
        if n != ranks:
            continue
        report = tests.replay(
            name,
            latency=network.latency,
            bandwidth=network.bandwidth,
            overhead=network.overhead,
            poll_interval=network.poll_interval,
        )
        prediction.seconds += report.seconds
        prediction.exchange += report.exchange
        prediction.serial += serial
        prediction.busy += report.mean_busy
        prediction.requests += report.requests
        prediction.transfers += report.transfers
        prediction.refusals += report.refusals


def write_predictions(path: Path, predictions: Sequence[Prediction]) -> None:
    """Writes a table with one row for each prediction."""
    names = (
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
    write_table(path, names, [[getattr(each, name) for name in names] for each in predictions])
