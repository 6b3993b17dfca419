"""Compares a scene with other programs in one run on one machine: seconds per 25 Hz frame, largest
stretch and intersecting triangles.

    python tests/benchmarks/peers.py --shared ../shared [--scene drape|twist] [--step 4e-3]
            [--peer-python PYTHON] [--mujoco]

The other programs' scripts are in SHARED/peers. PYTHON is an interpreter with the other programs
installed (bpy, mujoco). A missing program is left out and reported in one line. The frames of all
programs are evaluated here: stretch is the largest principal stretch, and intersecting pairs are
found in exact arithmetic. Times depend on the machine, so quote only ratios.
"""

import argparse
import importlib.util
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import loomstone as ls
import numpy as np
from smoke import SCENES, SHARED, parsed

NAMES = {"drape": "W1", "twist": "W3"}  # scene names in SHARED/peers
QUALITY = {"drape": 10, "twist": 30}  # Blender's steps per frame; with fewer, the twist fails


class Seen(NamedTuple):
    seconds: float  # per frame
    stretch: float
    pairs: int  # intersecting pairs in the worst frame

    def __str__(self) -> str:
        return (
            f"{self.seconds:.3f} s a frame, stretch {self.stretch:.3f}, "
            f"intersecting pairs {self.pairs}"
        )


def ours(name: str, options: argparse.Namespace) -> Seen:
    spec = importlib.util.spec_from_file_location(name, SCENES / f"{name}.py")
    scene = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scene)
    size = {} if options.triangles is None else {"triangles": options.triangles}
    integrator = getattr(scene, "integrator", ls.SemiImplicitEuler())
    if options.step is not None:
        integrator = ls.SemiImplicitEuler(step=options.step)
    sim = ls.Simulation(scene.scene(**size), integrator=integrator, threads=options.threads)
    stretch, pairs, frames = 1.0, 0, 0
    seconds = 0.0
    start = time.perf_counter()
    for frame in sim.frames(duration=options.duration, rate=25):
        seconds += time.perf_counter() - start
        stretch = max(stretch, float(frame.stretch.max()))
        pairs = max(pairs, len(sim.intersecting_pairs()))
        frames += 1
        start = time.perf_counter()
    return Seen(seconds / (frames - 1), stretch, pairs)


def looked_at(path: Path) -> Seen:
    """Evaluates another program's result file.

    The file contains uv (n x 2), faces (m x 3), X (frames x n x 3) and the time that the run took.
    """
    run = np.load(path)
    uv, faces = run["uv"], run["faces"]
    rest = np.linalg.inv(
        np.stack([uv[faces[:, 1]] - uv[faces[:, 0]], uv[faces[:, 2]] - uv[faces[:, 0]]], axis=2)
    )
    stretch, pairs = 1.0, 0
    for x in run["X"]:
        gradient = (
            np.stack([x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]]], axis=2)
            @ rest
        )
        stretch = max(stretch, float(np.linalg.norm(gradient, ord=2, axis=(1, 2)).max()))
        pairs = max(pairs, len(ls.collision.intersecting_pairs(x, faces)))
    return Seen(float(json.loads(str(run["meta"]))["wall_per_25hz_frame"]), stretch, pairs)


def peer(python: str, script: Path, arguments: list[str], out: Path) -> Seen | str:
    """Runs another program. Returns its result, or the reason if it produced none."""
    environment = {**os.environ, "PEERS_OUT": str(out), "PYTHONPATH": str(script.parent)}
    environment.pop("OMP_WAIT_POLICY", None)
    done = subprocess.run(
        [python, str(script), *arguments], capture_output=True, text=True, env=environment
    )
    written = sorted(out.glob("*.npz"))
    if done.returncode or not written:
        return (done.stderr.strip().splitlines() or ["no output"])[-1]
    return looked_at(written[-1])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--shared", type=Path, default=SHARED)
    parser.add_argument("--scene", choices=list(NAMES), default="drape")
    parser.add_argument("--peer-python", default="python3")
    parser.add_argument(
        "--blender-quality", type=int, help="steps a frame (default: 10 for drape, 30 for twist)"
    )
    parser.add_argument("--duration", type=float, default=1.0)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument(
        "--step", type=float, help="ours [s]; Blender's own in drape is 4e-3 (default: the scene's)"
    )
    parser.add_argument("--mujoco", action="store_true", help="also MuJoCo (minutes)")
    parser.add_argument("--triangles", type=int, help="ours (default: the scene's)")
    options = parsed(parser, duration=0.08, threads=1, triangles=200)
    mine = ours(options.scene, options)
    print(f"loomstone  {mine}", flush=True)
    quality = options.blender_quality or QUALITY[options.scene]
    blender = ["--quality", str(quality), "--cq", "4", "--T", str(options.duration)]
    programs = {"blender": ("run_blender.py", blender)}
    if options.mujoco:
        programs["mujoco"] = ("run_mujoco.py", ["--T", str(min(options.duration, 0.12))])
    for name, (script, arguments) in programs.items():
        path = options.shared / "peers" / script
        if not path.exists():
            print(f"{name}: left out, {script} is not in the shared folder")
            continue
        with tempfile.TemporaryDirectory() as out:
            seen = peer(options.peer_python, path, [NAMES[options.scene], *arguments], Path(out))
        if isinstance(seen, str):
            print(f"{name}: left out, {seen}")
        else:
            print(
                f"{name:9s}  {seen}; loomstone takes {mine.seconds / seen.seconds:.2f} of the time",
                flush=True,
            )


if __name__ == "__main__":
    main()
