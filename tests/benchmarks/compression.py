"""Size, writing time and reading time of frames at several levels of compression.

Frames of a drape are simulated once, and then written and read at each level. Times are processor
times.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import loomstone as ls
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=14450)
    parser.add_argument("--frames", type=int, default=26)
    options = parsed(parser, triangles=450, frames=2)
    file = SceneFile.open(SCENES / "drape.py", {"triangles": options.triangles})
    sim = ls.Simulation(file.scene(), integrator=file.integrator)
    duration = (options.frames - 1) / file.rate
    frames = list(sim.frames(duration=duration, rate=file.rate))
    for level in (0, 1, 4, 9):
        with tempfile.TemporaryDirectory() as name:
            start = time.process_time()
            writer = ls._core.FrameWriter(name, sim.topology, "{}", level)
            for frame in frames:
                writer.write(frame)
            written = time.process_time() - start
            del writer
            start = time.process_time()
            with ls.Run(name) as run:
                assert sum(1 for _ in run) == len(frames)
            read = time.process_time() - start
            size = sum(512 * path.stat().st_blocks for path in Path(name).iterdir())
        print(
            f"level {level}: {size / 1e6:.1f} MB, {1e3 * written / len(frames):.1f} ms to write"
            f" and {1e3 * read / len(frames):.1f} ms to read a frame",
            flush=True,
        )


if __name__ == "__main__":
    main()
