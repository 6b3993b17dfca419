"""Records hashes of the state after 45 steps of every case in cases.py, or compares them with the
record. If names are given, takes only cases whose names contain one of them. If a step fails, the
hash is that of the state before this step.

    python tests/digests/digests.py --compare [--threads 2] [names ...]
    mpirun -n 2 python tests/digests/digests.py --compare
    python tests/digests/digests.py --compare --decomposition dynamic
    python tests/digests/digests.py --record [names ...]

The 45 steps include the rebuild of the rigid-body world at step 40. A change that must not affect
results leaves all digests unchanged. A commit that affects results must contain new digests and
explain them in its message. Digests are valid only on the machine on which they were recorded. On
another machine, --compare prints the properties (machine.py) that differ and exits with status 77.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import loomstone as ls
from cases import Case, cases
from loomstone import _core
from machine import machine

RECORD = Path(__file__).with_name("digests.json")
STEPS = 45


@dataclass(frozen=True)
class Layout:
    """Threads, ranks and decomposition. None of them affects results."""

    threads: int
    ranks: _core.Communicator
    decomposition: Any


def digest(make: Callable[[], Case], layout: Layout) -> str:
    scene, integrator = make()
    sim = ls.Simulation(
        scene,
        integrator=integrator,
        threads=layout.threads,
        communicator=layout.ranks,
        decomposition=layout.decomposition,
    )
    failure = ""
    try:
        for _ in range(STEPS):
            sim.step()
    except ls.SolverFailure:
        failure = f" failed at step {sim.step_index}"
    return sim.digest() + failure


def digests(names: list[str], layout: Layout) -> Iterator[tuple[str, str]]:
    """Yields the name and digest of each case.

    If `names` is not empty, skips cases whose names contain none of its elements. On several ranks,
    skips the cases that support one rank only.
    """
    for name, make in cases():
        if not names or any(part in name for part in names):
            try:
                yield name, digest(make, layout)
            except ls.Unsupported:
                if layout.ranks.size == 1:
                    raise


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--record", action="store_true")
    what.add_argument("--compare", action="store_true")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--decomposition", default="predicted")
    parser.add_argument("names", nargs="*")
    given = parser.parse_args()
    ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
    record = json.loads(RECORD.read_text()) if RECORD.exists() else {"machine": {}, "digests": {}}
    here = machine()
    if given.compare:
        other = [f"{key}: {here[key]}" for key in here if here[key] != record["machine"].get(key)]
        if other:
            print(f"recorded on another machine; here {'; '.join(other)}", file=sys.stderr)
            raise SystemExit(77)
    layout = Layout(given.threads, ranks, given.decomposition)
    found = dict(digests(given.names, layout))
    if ranks.rank != 0:
        return
    if given.record:
        kept = record["digests"] if given.names and record["machine"] == here else {}
        record = {"machine": here, "digests": dict(sorted((kept | found).items()))}
        RECORD.write_text(json.dumps(record, indent=1) + "\n")
        return
    different = [name for name in found if found[name] != record["digests"].get(name)]
    print(f"{len(found)} digests, {len(different)} differ from the record", *different, sep="\n")
    raise SystemExit(1 if different else 0)


if __name__ == "__main__":
    main()
