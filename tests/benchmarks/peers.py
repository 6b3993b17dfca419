"""Compares loomstone with other programs on one scene, in one run on one machine: seconds per frame
at 25 Hz, largest stretch and intersecting pairs of triangles. For the swing, the last number is the
energy that is left at the end, as a share of that at the start; the energy of the sheet at rest is
subtracted from both.

    python tests/benchmarks/peers.py --shared ../shared [--scene drape|twist|swing] [--step 4e-3]
            [--peer-python PYTHON] [--programs blender mujoco newton pypbd]

The other programs' scripts are in SHARED/peers. PYTHON is an interpreter with the chosen programs
installed. A missing program is left out and reported in one line. Stretch and intersecting pairs
are computed here from the frames of each program: the largest principal stretch, and pairs by
exact arithmetic. Times depend on the machine, so quote only ratios.

These commands repeat comparisons of docs/performance.md. Each program is installed into a virtual
environment of its own, because they need different versions of common packages:

    python3.11 -m venv blender && blender/bin/pip install bpy==5.0.1 numpy
    python3 -m venv mujoco && mujoco/bin/pip install mujoco==4.0.0 numpy
    python3 -m venv newton && newton/bin/pip install newton==1.8.0 warp-lang numpy
    python3 -m venv pypbd && pypbd/bin/pip install pyPBD==2.2.2 numpy

    python tests/benchmarks/peers.py --step 4e-3 --peer-python blender/bin/python
    python tests/benchmarks/peers.py --scene twist --duration 1.5 --peer-python blender/bin/python
    python tests/benchmarks/peers.py --scene swing --peer-python blender/bin/python
    python tests/benchmarks/peers.py --programs mujoco --peer-python mujoco/bin/python
    python tests/benchmarks/peers.py --programs newton --peer-python newton/bin/python
    python tests/benchmarks/peers.py --programs newton --scene twist --duration 2 --peer-python ...
    python tests/benchmarks/peers.py --programs pypbd --peer-python pypbd/bin/python

On two cores, Newton takes two minutes to compile its kernels the first time, and two to ten minutes
for a second of motion.
"""

import argparse
import importlib.util
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, NamedTuple

import loomstone as ls
import numpy as np
from numpy.typing import NDArray
from smoke import SCENES, SHARED, parsed

HELPERS = Path(__file__).with_name("peer_helpers")  # modules that scripts in SHARED/peers lack
NAMES = {"drape": "W1", "twist": "W3", "swing": "W2"}  # scene names in SHARED/peers
# Blender's steps per frame. The twist needs more of them than the other scenes.
QUALITY = {"drape": 10, "twist": 30, "swing": 10}
SCRIPTS = {  # in SHARED/peers
    "blender": "run_blender.py",
    "mujoco": "run_mujoco.py",
    "newton": "run_newton.py",
    "pypbd": "run_pbd.py",
}
DURATION = {"drape": 1.0, "twist": 1.0, "swing": 4.0}  # [s]


class Seen(NamedTuple):
    seconds: float  # computing time per frame [s]
    stretch: float
    pairs: int  # largest number of intersecting pairs in a frame
    kept: float | None = None  # energy at the end / energy at the start; see top of file

    def __str__(self) -> str:
        text = f"{self.seconds:.3f} s a frame, stretch {self.stretch:.3f}, "
        if self.kept is not None:
            return text + f"{25 * self.seconds:.2f} s per second, energy kept {self.kept:.3f}"
        return text + f"intersecting pairs {self.pairs}"


def opened(name: str, triangles: int | None) -> tuple[ls.Scene, ls.Integrator]:
    spec = importlib.util.spec_from_file_location(name, SCENES / f"{name}.py")
    scene = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scene)
    size = {} if triangles is None else {"triangles": triangles}
    if name == "swing":  # the integrator of the scene file dissipates energy
        if triangles is not None:
            columns = max(1, round(np.sqrt(0.5 * triangles * 0.44 / 0.57)))
            size = {"columns": columns, "rows": max(1, round(0.5 * triangles / columns))}
        return scene.scene(**size), ls.Asynchronous()
    return scene.scene(**size), getattr(scene, "integrator", ls.SemiImplicitEuler())


def total(report: ls.StepReport) -> float:
    energy = report.energy
    return energy.kinetic + energy.membrane + energy.bending + energy.gravity


def energy_at_rest(scene: ls.Scene) -> float:
    """Returns the energy [J] of the hanging cloth after long implicit steps bring it to rest."""
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-2, accuracy=None))
    while sim.time < 6.0:
        sim.step()
    return total(sim.report)


def ours(name: str, options: argparse.Namespace) -> Seen:
    scene, integrator = opened(name, options.triangles)
    if options.step is not None:
        integrator = ls.SemiImplicitEuler(step=options.step)
    sim = ls.Simulation(scene, integrator=integrator, threads=options.threads)
    stretch, pairs, energies = 1.0, 0, []
    seconds = 0.0
    start = time.perf_counter()
    for frame in sim.frames(duration=options.duration, rate=25):
        seconds += time.perf_counter() - start
        stretch = max(stretch, float(frame.stretch.max()))
        pairs = max(pairs, len(sim.intersecting_pairs()))
        energies.append(total(frame.report))
        start = time.perf_counter()
    kept = None
    if name == "swing":
        rest = energy_at_rest(scene)
        kept = (np.mean(energies[-10:]) - rest) / (energies[0] - rest)
    return Seen(seconds / (len(energies) - 1), stretch, pairs, kept)


def kept_in(run: Mapping[str, NDArray[np.float64]], gradients: list[NDArray[np.float64]]) -> float:
    """Returns the mean energy in the last 0.4 s of a swing, as a share of that at the start.

    The energy at rest is subtracted from both. It includes bending energy, which the other energies
    leave out. `run` is the result of another program. Velocities are centred differences of frames,
    and zero at the start. `gradients` are the deformation gradients of all frames, each
    (m x 3 x 2).
    """
    scene, _ = opened("swing", None)
    material, faces, positions = scene.cloths[0].material, run["faces"], run["X"]
    e, f = (run["uv"][faces[:, i]] - run["uv"][faces[:, 0]] for i in (1, 2))
    areas = 0.5 * np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0])
    masses = np.bincount(faces.ravel(), np.repeat(material.density * areas / 3.0, 3))
    modulus = np.array(
        [
            [material.weft_stiffness, 2.0 * material.shear_stiffness],
            [2.0 * material.shear_stiffness, material.warp_stiffness],
        ]
    )
    energies = []
    for i in (0, *range(len(positions) - 20, len(positions) - 1)):
        strain = 0.5 * (np.swapaxes(gradients[i], 1, 2) @ gradients[i] - np.eye(2))
        membrane = 0.5 * (areas[:, None, None] * modulus * strain**2).sum()
        gravity = 9.81 * (masses * positions[i][:, 2]).sum()
        step = run["t"][1] - run["t"][0]
        moved = positions[i + 1] - positions[i - 1] if i else np.zeros_like(positions[0])
        kinetic = 0.5 * (masses * ((moved / (2.0 * step)) ** 2).sum(axis=1)).sum()
        energies.append(membrane + gravity + kinetic)
    rest = energy_at_rest(scene)
    return float((np.mean(energies[1:]) - rest) / (energies[0] - rest))


def looked_at(path: Path, name: str) -> Seen:
    """Evaluates a file of another program. It contains uv (n x 2) [m], faces (m x 3), positions X
    (frames x n x 3) [m], times t of the frames [s] and the computing time per frame at 25 Hz [s].
    """
    run = np.load(path)
    uv, faces = run["uv"], run["faces"]
    rest = np.linalg.inv(
        np.stack([uv[faces[:, 1]] - uv[faces[:, 0]], uv[faces[:, 2]] - uv[faces[:, 0]]], axis=2)
    )
    pairs, gradients = 0, []
    for x in run["X"]:
        edges = np.stack([x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]]], axis=2)
        gradients.append(edges @ rest)
        if name != "swing":  # the scene "swing" has no collisions
            pairs = max(pairs, len(ls.collision.intersecting_pairs(x, faces)))
    stretch = max(float(np.linalg.norm(g, ord=2, axis=(1, 2)).max()) for g in gradients)
    kept = kept_in(dict(run), gradients) if name == "swing" else None
    return Seen(float(json.loads(str(run["meta"]))["wall_per_25hz_frame"]), stretch, pairs, kept)


def peer(python: str, script: Path, name: str, arguments: list[str], out: Path) -> Seen | str:
    """Runs another program. Returns its result, or the reason why there is none."""
    path = os.pathsep.join(map(str, (script.parent, HELPERS)))
    environment = {**os.environ, "PEERS_OUT": str(out), "PYTHONPATH": path}
    environment.pop("OMP_WAIT_POLICY", None)
    done = subprocess.run(
        [python, str(script), NAMES[name], *arguments],
        capture_output=True,
        text=True,
        env=environment,
    )
    written = sorted(out.glob("*.npz"))
    if done.returncode or not written:
        return (done.stderr.strip().splitlines() or ["no output"])[-1]
    return looked_at(written[-1], name)


def arguments_of(program: str, options: argparse.Namespace) -> list[str]:
    """Returns the arguments that follow the name of the scene in the call of a program's script."""
    duration = ["--T", str(options.duration)]
    if program == "blender":
        quality = options.blender_quality or QUALITY[options.scene]
        return ["--quality", str(quality), "--cq", "4", *duration]
    if program == "mujoco":  # takes minutes for a second of motion
        return ["--T", str(min(options.duration, 0.12))]
    return ["vbd", *duration] if program == "newton" else duration


def step_of(text: str) -> float | Literal["auto"]:
    return "auto" if text == "auto" else float(text)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--shared", type=Path, default=SHARED)
    parser.add_argument("--scene", choices=list(NAMES), default="drape")
    parser.add_argument("--peer-python", default="python3")
    parser.add_argument(
        "--blender-quality", type=int, help="steps a frame (default: 30 for twist, 10 for others)"
    )
    parser.add_argument("--duration", type=float, help="[s] (default: 4 for swing, 1 for others)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument(
        "--step",
        type=step_of,
        help="ours [s], or auto; Blender's own in drape is 4e-3 (default: the scene's)",
    )
    parser.add_argument(
        "--programs", nargs="+", choices=list(SCRIPTS), default=["blender"], help="default: blender"
    )
    parser.add_argument("--triangles", type=int, help="ours (default: the scene's)")
    options = parsed(parser, duration=0.08, threads=1, triangles=200)
    options.duration = options.duration or DURATION[options.scene]
    mine = ours(options.scene, options)
    print(f"loomstone  {mine}", flush=True)
    for name in options.programs:
        path = options.shared / "peers" / SCRIPTS[name]
        if not path.exists():
            print(f"{name}: left out, {SCRIPTS[name]} is not in the shared folder")
            continue
        with tempfile.TemporaryDirectory() as out:
            seen = peer(
                options.peer_python, path, options.scene, arguments_of(name, options), Path(out)
            )
        if isinstance(seen, str):
            print(f"{name}: left out, {seen}")
        else:
            print(
                f"{name:9s}  {seen}; loomstone takes {mine.seconds / seen.seconds:.2f} of the time",
                flush=True,
            )


if __name__ == "__main__":
    main()
