"""Exports a run, loads the export into Blender, compares positions and draws a picture.

    python tests/benchmarks/blender.py [RUN] [--to usd|gltf|alembic|pc2|mdd] [--frame N]
            [--out DIRECTORY] [--blender-python PYTHON] [--samples N]

Without RUN, the first second of scenes/drape.py is simulated with 3,600 triangles. PYTHON is an
interpreter that has the module bpy (Blender 5, Python 3.11). Without --to, all formats are tried.
For each format, Blender renders the frame (default: the last) with Cycles to
DIRECTORY/blender-FORMAT.png. Without --out, DIRECTORY is temporary and deleted at the end. The
program prints the total size of the files, the times of export, import and rendering, and the
largest distance between the position of a cloth vertex in Blender and that in the run.
"""

import argparse
import importlib.util
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import loomstone as ls
import numpy as np
from smoke import SCENES, missing, package, parsed

INSIDE = Path(__file__).parent / "inside_blender" / "run.py"
SUFFIXES = {"usd": "run.usdc", "gltf": "run.glb", "alembic": "run.abc", "pc2": "pc2", "mdd": "mdd"}


def simulated(directory: Path, triangles: int, duration: float) -> ls.Run:
    """Simulates scenes/drape.py and returns the run."""
    spec = importlib.util.spec_from_file_location("drape", SCENES / "drape.py")
    scene = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scene)
    sim = ls.Simulation(scene.scene(triangles=triangles))
    sim.run(out=directory, duration=duration, rate=25.0)
    return ls.Run(directory)


def shown(run: ls.Run, to: str, frame: int, settings: argparse.Namespace) -> str:
    """Exports a run, draws a frame in Blender, and returns a line: size, times, distance."""
    target = settings.out / SUFFIXES[to]
    begun = time.perf_counter()
    paths = run.export(target, to=to, overwrite=True)
    exported = time.perf_counter() - begun
    size = sum(path.stat().st_size for path in paths) / 2**20
    order = {
        "files": [str(path) for path in paths],
        "frame": frame,
        "rate": run.rate,
        "picture": str(settings.out / f"blender-{to}.png"),
        "positions": str(settings.out / f"positions-{to}.npz"),
        "samples": settings.samples,
        "width": settings.width,
    }
    done = subprocess.run(
        [settings.blender_python, str(INSIDE), json.dumps(order)], capture_output=True, text=True
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not lines:
        raise SystemExit(f"Blender failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    seen = json.loads(lines[-1])
    return (
        f"{to}: {size:.2f} MiB, export {exported:.2f} s, import {seen['import']:.2f} s, picture"
        f" {seen['picture']:.2f} s; largest distance of a vertex"
        f" {largest_distance(run[frame], run.topology, order['positions']):.2g} m"
    )


def largest_distance(frame: ls.Frame, topology: ls.FrameTopology, path: str) -> float:
    """Returns the largest distance [m] of a cloth vertex in Blender from its position in a frame.

    Blender keeps the order of the vertices. glTF files repeat some vertices, such as those at seams
    of uv; the copies follow all others. A cloth is compared with the mesh in Blender whose vertices
    are closest. If no mesh has enough vertices for a cloth, the distance is infinite.
    """
    with np.load(path) as arrays:
        found = [arrays[name] for name in sorted(arrays, key=int)]
    distances = []
    for index in range(len(topology.cloth_names)):
        wanted = frame.positions[topology.cloth_of_vertex == index]
        close = [
            np.linalg.norm(points[: len(wanted)] - wanted, axis=1).max()
            for points in found
            if len(points) >= len(wanted)
        ]
        distances.append(min(close, default=np.inf))
    return max(distances)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", nargs="?", type=Path)
    parser.add_argument("--to", choices=list(SUFFIXES), action="append")
    parser.add_argument("--frame", type=int, default=-1)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--blender-python", default=sys.executable)
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--width", type=int, default=960)
    settings = parsed(parser, samples=1, width=64)
    found = [settings.blender_python, "-c", "import bpy"]
    if subprocess.run(found, capture_output=True).returncode:
        missing(f"{settings.blender_python} cannot import bpy")
    for name in ("pxr", "pygltflib", "alembic3d"):
        package(name)
    with tempfile.TemporaryDirectory() as scratch:
        settings.out = settings.out or Path(scratch)
        settings.out.mkdir(parents=True, exist_ok=True)
        run = (
            ls.Run(settings.run)
            if settings.run
            else simulated(settings.out / "drape", *((200, 0.08) if settings.smoke else (3600, 1)))
        )
        frame = settings.frame % len(run)
        for to in settings.to or SUFFIXES:
            print(shown(run, to, frame, settings), flush=True)


if __name__ == "__main__":
    main()
