"""Rendering speed [pictures/s] of a stored run, with and without writing PNG files.

    python tests/benchmarks/pictures.py out/drape [--jobs 2 --width 1280 --height 720 --pictures 24]

The clock starts when every process has drawn one picture.
"""

import argparse
import multiprocessing
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import loomstone as ls
from loomstone.pictures.directory import picture
from loomstone.runs.scene_file import stored_options
from smoke import SCENES, parsed


def draw(run, look, indices, out, start, spent):
    frames, renderer = ls.Run(run), ls.pictures.Renderer(ls.Run(run).topology, look)
    renderer.fit(frames[0])
    renderer.render(frames[0])
    start.wait()
    before = time.process_time()
    for i in indices:
        image = renderer.render(frames[i])
        if out:
            ls.pictures.write_png(str(picture(out, i)), image)
    spent.put(time.process_time() - before)


def measure(run, look, n, jobs, out):
    """Returns pictures per second and processor time per picture [s]."""
    context = multiprocessing.get_context("spawn")
    start, spent, n_frames = context.Barrier(jobs + 1), context.Queue(), len(ls.Run(run))
    shares = [[i % n_frames for i in range(job, n, jobs)] for job in range(jobs)]
    processes = [
        context.Process(target=draw, args=(run, look, share, out, start, spent)) for share in shares
    ]
    for process in processes:
        process.start()
    start.wait()
    began = time.perf_counter()
    busy = sum(spent.get() for _ in processes)
    seconds = time.perf_counter() - began
    for process in processes:
        process.join()
    return n / seconds, busy / n


def a_run(out):
    """Creates a run with two frames of a small cloth."""
    command = ["-m", "loomstone", "run", SCENES / "hanging.py", "-p", "triangles=50", "--out", out]
    subprocess.run([sys.executable, *command, "--duration", "0.04"], check=True)
    return out


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path, nargs="?", default=Path("out/drape"))
    for name, default in (("jobs", 2), ("width", 1280), ("height", 720), ("pictures", 24)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parsed(parser, jobs=1, width=64, height=48, pictures=2)
    with tempfile.TemporaryDirectory() as out:
        if given.smoke:
            given.run = a_run(Path(out) / "run")
        source = ls.Run(given.run)
        look = stored_options(source)[3] if "render" in source.metadata else ls.RenderOptions()
        look = look.replace(width=given.width, height=given.height)
        for words, directory in (("with PNG files", Path(out)), ("without", None)):
            rate, busy = measure(given.run, look, given.pictures, given.jobs, directory)
            print(
                f"{words}: {rate:.2f} pictures/s, {1e3 * busy:.0f} ms of processor a picture",
                flush=True,
            )


if __name__ == "__main__":
    main()
