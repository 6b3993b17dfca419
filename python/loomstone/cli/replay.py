"""The command loomstone replay."""

from __future__ import annotations

import math
import sys
from typing import Annotated

import typer

from ..runs import replay as replays
from ..runs.motions import motion_files
from .application import WrongCommand, app, command_line, session
from .options import RunArgument


@app.command()
def replay(
    run: RunArgument,
    ranks: Annotated[
        str, typer.Option(help="numbers of ranks: 1,2,12, or 1:4096 for powers of two")
    ] = "1:4096",
    decomposition: Annotated[
        list[str], typer.Option(help=f"{' | '.join(replays.REPLAYED)}; may be repeated")
    ] = list(replays.REPLAYED),  # noqa: B006
    latency: Annotated[
        float, typer.Option(help="time of a message besides its size / bandwidth [s]")
    ] = 1.5e-6,
    bandwidth: Annotated[float, typer.Option(help="bandwidth of the network [bytes/s]")] = 1e10,
    overhead: Annotated[
        float, typer.Option(help="processor time to send, receive or poll for a message [s]")
    ] = 0.2e-6,
    poll_interval: Annotated[
        float,
        typer.Option(help="time between two polls of a rank that has work [s]; not for predicted"),
    ] = 5e-6,
) -> None:
    """Predicts the time of collision searches on many ranks.

    Uses the motions that `loomstone run --record-tasks` has recorded. Measures each search on one
    thread, and simulates how ranks share it. Prints the mean time per step, the part of this time
    in which ranks exchange data, the efficiency (time on one rank divided by the sum of the times
    of all ranks), and mean numbers of transferred tasks and refused requests. Writes replay.csv.

    \b
        loomstone run scenes/drape.py --record-tasks 20
        loomstone replay out/drape --ranks 1:4096
    """
    with session(parallel=False):
        _check(decomposition, latency, overhead, bandwidth, poll_interval)
        network = replays.Network(latency, bandwidth, overhead, poll_interval)
        with command_line():
            numbers = replays.parse_ranks(ranks)
        steps = len(motion_files(run))
        found = replays.replay(
            run,
            numbers,
            decomposition,
            network,
            observer=lambda path: print(path, file=sys.stderr),
        )
        print(f"{steps} recorded steps; times of a step")
        print("ranks  decomposition  time [ms]  exchange [ms]  efficiency  transfers  refusals")
        for each in found:
            print(
                f"{each.ranks:5d}  {each.decomposition:13}  {1e3 * each.seconds / steps:9.4f}"
                f"  {1e3 * each.exchange / steps:13.4f}  {each.efficiency:10.3f}"
                f"  {each.transfers // steps:9d}  {each.refusals // steps:8d}"
            )
        replays.write_predictions(run / "replay.csv", found)
        print(f"table: {run / 'replay.csv'}")


def _check(
    decompositions: list[str],
    latency: float,
    overhead: float,
    bandwidth: float,
    poll_interval: float,
) -> None:
    """Raises WrongCommand for unknown decompositions, and for times or bandwidths out of range."""
    for name in decompositions:
        if name not in replays.REPLAYED:
            raise WrongCommand(
                f"--decomposition must be predicted, static or dynamic, got {name!r}"
            )
    for what, value in (("latency", latency), ("overhead", overhead)):
        if not 0.0 <= value < math.inf:
            raise WrongCommand(f"--{what} must be at least 0 s and finite, got {value:g}")
    for what, value in (("bandwidth", bandwidth), ("poll-interval", poll_interval)):
        if not 0.0 < value < math.inf:
            raise WrongCommand(f"--{what} must be above 0 and finite, got {value:g}")
