"""Live view of the drape: pictures per second, and the ratio of simulated to elapsed time, with the
page open in a headless Chromium.

    python tests/benchmarks/live_view.py [--triangles 3600 --threads 0 --spans 3 --span 10]

The simulation starts after the page has been drawn a few times, because a browser needs seconds to
compile the shaders. Every line shows one span of elapsed time, but its first two columns are means
over at most the last 10 s. Chromium draws without a GPU here, so its threads compete with the
simulation for the processors. The last two columns show the processor time of the simulation and of
Chromium per second of elapsed time.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from smoke import ROOT, SCENES, missing, package, parsed

COUNT = """window.repaints = 0;
(function count() { window.repaints++; requestAnimationFrame(count); })()"""


def processor_time(name: str) -> float:
    """Returns the processor time of all processes with this name [s]."""
    total = 0.0
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and (entry / "comm").read_text().strip() == name:
                times = (entry / "stat").read_text().rsplit(")", 1)[1].split()[11:13]
                total += sum(map(int, times)) / os.sysconf("SC_CLK_TCK")
        except OSError:  # the process has ended
            continue
    return total


def repaints(page: Any) -> int:
    """Returns how many times the page has been drawn since start_counting()."""
    answer = page.call("Runtime.evaluate", expression="String(window.repaints)")
    return int(answer["result"]["value"])


def start_counting(page: Any, live: Any) -> None:
    """Starts to count the repaints of the page, and waits for 20 of them. Exits with status 77 if
    this takes more than 60 s.
    """
    deadline = time.monotonic() + 60.0
    while not live.page.server.get_clients() and time.monotonic() < deadline:
        time.sleep(0.1)
    page.call("Runtime.evaluate", expression=COUNT)
    while repaints(page) < 20:
        if time.monotonic() > deadline:
            missing("Chromium did not draw the page within 60 s")
        time.sleep(0.1)


def measure(page: Any, live: Any, span: float) -> str:
    """Waits `span` [s] while the simulation runs; returns a line of the table."""
    browser, own, begun = processor_time("chromium"), time.process_time(), time.monotonic()
    drawn = repaints(page)
    time.sleep(span)
    pairs = len(live.intersecting_pairs())
    elapsed = time.monotonic() - begun
    pictures, speed = live.rates()
    return (
        f"{pictures:10.1f}{speed:17.2f}{pairs:20d}{(repaints(page) - drawn) / elapsed:12.1f}"
        f"{(time.process_time() - own) / elapsed:12.2f}"
        f"{(processor_time('chromium') - browser) / elapsed:10.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=3600)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--spans", type=int, default=3, help="number of spans")
    parser.add_argument("--span", type=float, default=10.0, help="elapsed time of a span [s]")
    given = parsed(parser, triangles=128, spans=1, span=1.0)
    package("viser"), package("websockets")
    sys.path.insert(0, str(ROOT / "tests" / "python" / "viewer"))
    from browser import CHROMIUM, Browser

    if CHROMIUM is None:
        missing("chromium is not installed")
    from loomstone import viewer
    from loomstone.runs.scene_file import SceneFile

    logging.disable(logging.ERROR)  # hides errors of connections that Chromium does not use
    scene = SceneFile.open(SCENES / "drape.py", {"triangles": given.triangles}).scene()
    live = viewer.live(scene, threads=given.threads, port=0, paused=True)
    try:
        with (
            tempfile.TemporaryDirectory() as profile,
            Browser(live.page.url, Path(profile)) as page,
        ):
            start_counting(page, live)
            print(
                "pictures/s  times real time  intersecting pairs  repaints/s  simulation  Chromium"
            )
            live.start()
            for _ in range(given.spans):
                print(measure(page, live, given.span), flush=True)
    finally:
        live.stop()


if __name__ == "__main__":
    main()
