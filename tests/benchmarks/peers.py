"""The drape beside other programs, in one run on one machine: seconds a 25 Hz frame, largest stretch, intersections.

    python tests/benchmarks/peers.py --shared ../shared [--peer-python PYTHON] [--blender-quality 10] [--duration 1.0]

The other programs' scripts lie in SHARED/peers; PYTHON is an interpreter that has them (bpy, mujoco). What is not there is
left out with a line that says so. Times depend on the machine: quote the ratios.
"""

import argparse
import importlib.util
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import loomstone as ls

ROOT = Path(__file__).resolve().parents[2]


def ours(duration: float, threads: int, step: float | None) -> dict[str, float]:
    spec = importlib.util.spec_from_file_location("drape", ROOT / "scenes" / "drape.py")
    drape = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(drape)
    integrator = drape.integrator() if step is None else ls.SemiImplicitEuler(step=step)
    sim = ls.Simulation(drape.scene(), integrator=integrator, threads=threads)
    stretch, pairs, frames = 1.0, 0, 0
    seconds = 0.0
    start = time.perf_counter()
    for frame in sim.frames(duration=duration, rate=25):
        seconds += time.perf_counter() - start
        stretch = max(stretch, float(frame.stretch.max()))
        pairs = max(pairs, len(sim.intersecting_pairs()))
        frames += 1
        start = time.perf_counter()
    return {"frame": seconds / (frames - 1), "stretch": stretch, "pairs": pairs}


def peer(python: str, script: Path, arguments: list[str], out: Path) -> float | str:
    """Seconds a 25 Hz frame, or why there is no figure."""
    environment = {**os.environ, "PEERS_OUT": str(out), "PYTHONPATH": str(script.parent)}
    environment.pop("OMP_WAIT_POLICY", None)
    done = subprocess.run([python, str(script), "W1", *arguments], capture_output=True, text=True, env=environment)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not lines:
        return (done.stderr.strip().splitlines() or ["no output"])[-1]
    return float(json.loads(lines[-1])["wall_per_25hz_frame"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--peer-python", default="python3")
    parser.add_argument("--blender-quality", type=int, default=10)
    parser.add_argument("--duration", type=float, default=1.0)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--step", type=float, help="ours [s]; Blender's own is 4e-3 (default: the scene's)")
    parser.add_argument("--mujoco", action="store_true", help="also MuJoCo (minutes)")
    options = parser.parse_args()
    mine = ours(options.duration, options.threads, options.step)
    print(f"loomstone            {mine['frame']:.3f} s a frame, stretch {mine['stretch']:.3f}, pairs {mine['pairs']}", flush=True)
    runs = {"blender": ["run_blender.py", "--quality", str(options.blender_quality), "--cq", "4", "--T", str(options.duration)]}
    if options.mujoco:
        runs["mujoco"] = ["run_mujoco.py", "--T", str(min(options.duration, 0.12))]
    with tempfile.TemporaryDirectory() as out:
        for name, (script, *arguments) in runs.items():
            path = options.shared / "peers" / script
            if not path.exists():
                print(f"{name}: left out, {script} is not in the shared folder")
                continue
            seconds = peer(options.peer_python, path, arguments, Path(out))
            if isinstance(seconds, str):
                print(f"{name}: left out, {seconds}")
            else:
                print(f"{name:20s} {seconds:.3f} s a frame; loomstone takes {mine['frame'] / seconds:.2f} of it", flush=True)


if __name__ == "__main__":
    main()
