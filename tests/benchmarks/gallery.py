"""Pictures and times of the scenes, for the gallery of the documentation.

    python tests/benchmarks/gallery.py [--scenes drape twist --out docs]

Runs the given scenes or, by default, all scenes that OUT/gallery.json does not list, so that a new
call continues an interrupted one. Each scene runs with its default parameters on one thread. One
frame of each run is drawn as OUT/images/scenes/NAME.jpg. For each scene, OUT/gallery.json lists the
number of cloth triangles, the number of bodies and obstacles, the simulated time, the instant of
the picture and the processor time. All scenes together take about 20 minutes.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from smoke import ROOT, SCENES, package, parsed

# Instants [s] at which these scenes are drawn. The other scenes are drawn at their end.
INSTANTS = {
    "bin": 2.0,
    "dragon": 0.5,
    "dress": 2.2,
    "fold": 0.2,
    "funnel": 0.4,
    "hanging": 0.4,
    "obstacle_walk": 2.0,
    "plunger": 0.2,
    "ribbon": 1.5,
    "sphere_slide": 0.6,
    "stack": 1.0,
    "swing": 1.0,
    "swing_integrators": 1.0,
    "twist": 1.2,
}


def processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def call(*arguments: str) -> None:
    """Runs a command of loomstone. If it fails, exits with the last line of its error message."""
    command = [sys.executable, "-m", "loomstone", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise SystemExit(f"loomstone {' '.join(arguments)}: {said}")


def simulate(name: str, run: Path, duration: list[str]) -> float:
    """Runs a scene and returns its processor time [s]."""
    before = processor_seconds()
    call("run", str(SCENES / f"{name}.py"), "--out", str(run), "--threads", "1", *duration)
    return processor_seconds() - before


def draw(run: Path, frame: int, name: str, width: int) -> np.ndarray[Any, Any]:
    look = SceneFile.open(SCENES / f"{name}.py", {}).render
    height = round(width * look.height / look.width)
    size = ["--width", str(2 * width), "--height", str(2 * height)]
    call("render", str(run), "--frame", str(frame), "--out", str(run / "p"), *size)
    drawn = package("matplotlib.image").imread(next((run / "p").glob("*.png")))[:, :, :3]
    halved = drawn.reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
    return (255 * halved + 0.5).astype(np.uint8)


def write(path: Path, picture: np.ndarray[Any, Any]) -> None:
    partial = path.with_name(f"{path.stem}-partial.jpg")
    package("matplotlib.image").imsave(partial, picture, pil_kwargs={"quality": 82})
    partial.rename(path)


def entry(name: str, options: argparse.Namespace) -> dict[str, float]:
    """Runs and draws a scene; returns its entry in gallery.json."""
    duration = [] if options.duration is None else ["--duration", str(options.duration)]
    with tempfile.TemporaryDirectory() as directory:
        run = Path(directory) / "run"
        seconds = simulate(name, run, duration)
        stored = ls.Run(run)
        times = [frame.time for frame in stored]
        shown = int(np.abs(np.array(times) - INSTANTS.get(name, times[-1])).argmin())
        write(options.out / f"images/scenes/{name}.jpg", draw(run, shown, name, options.width))
        return {
            "triangles": len(stored.topology.triangles),
            "bodies": len(stored.topology.body_names),
            "duration": round(times[-1], 6),
            "instant": round(times[shown], 6),
            "processor_seconds": float(f"{seconds:.2g}"),
        }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = sorted(path.stem for path in SCENES.glob("*.py"))
    parser.add_argument("--scenes", nargs="+", choices=known, help="default: all that are missing")
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    parser.add_argument("--width", type=int, default=420, help="width of the pictures [pixels]")
    parser.add_argument("--duration", type=float, help="simulated time [s]; default: that of each")
    tiny = dict(scenes=["hanging"], out=Path("docs"), width=64, duration=0.04)
    options = parsed(parser, **tiny)
    os.environ["OMP_WAIT_POLICY"] = "passive"
    (options.out / "images/scenes").mkdir(parents=True, exist_ok=True)
    table = options.out / "gallery.json"
    done = json.loads(table.read_text()) if table.exists() else {}
    for name in options.scenes or [each for each in known if each not in done]:
        done[name] = entry(name, options)
        partial = table.with_suffix(".partial")
        partial.write_text(json.dumps(done, indent=1, sort_keys=True) + "\n")
        partial.rename(table)
        print(name, done[name], flush=True)


if __name__ == "__main__":
    main()
