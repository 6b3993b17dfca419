"""Provokes faults and counts the trials that go wrong. The trials are kills, full disks, damaged
files, mutated scenes, sizes of cloth, lengths of steps, long runs and threads.

    python tests/benchmarks/faults.py --out out/faults.jsonl
    python tests/benchmarks/faults.py kill disk --out out/faults.jsonl

Results are appended to a file, one line of JSON for each trial. Trials that the file contains are
not repeated, so an interrupted benchmark continues. docs/reliability.md lists the results.
"""

from __future__ import annotations

import argparse
import functools
import json
import resource
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import fault_trials
import loomstone as ls
from fault_scenes import COUNT, try_scene
from fault_trials import READERS, Whole, in_child
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed

Trials = Iterator[tuple[str, Callable[[], str]]]  # name and function of each trial

SIZES = (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)
STEPS = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
LONG = {"hanging": {"triangles": 200}, "drape": {"triangles": 450}, "bin": {"triangles": 100}}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("experiments", nargs="*", help=f"of {', '.join(EXPERIMENTS)}; default: all")
    parser.add_argument("--out", type=Path, default=Path("out/faults.jsonl"))
    parser.add_argument("--scale", type=float, default=1.0, help="number of trials, of the full")
    options = parsed(parser, scale=0.002, out=Path("faults.jsonl"))
    options.out.parent.mkdir(parents=True, exist_ok=True)
    known = read(options.out)
    with tempfile.TemporaryDirectory() as name:
        for experiment in options.experiments or EXPERIMENTS:
            trials = EXPERIMENTS[experiment](Path(name), options.scale)
            try_all(experiment, trials, known, options.out)
            report(experiment, known)


def try_all(experiment: str, trials: Trials, known: dict[tuple[str, str], str], out: Path) -> None:
    """Performs the trials without a known result, and appends their results to the file `out`."""
    for trial, act in trials:
        if (experiment, trial) in known:
            continue
        known[experiment, trial] = outcome(act)
        with out.open("a") as file:
            file.write(json.dumps([experiment, trial, known[experiment, trial]]) + "\n")


def read(path: Path) -> dict[tuple[str, str], str]:
    """Returns the results in a file. An incomplete line, left by a killed benchmark, is skipped."""
    known = {}
    for line in path.read_text().splitlines() if path.exists() else []:
        try:
            experiment, trial, result = json.loads(line)
        except ValueError:
            continue
        known[experiment, trial] = result
    return known


def outcome(act: Callable[[], str]) -> str:
    try:
        return act()
    except Exception as problem:
        return f"wrong: {type(problem).__name__}: {problem}"


def report(experiment: str, known: dict[tuple[str, str], str]) -> None:
    results = {trial: text for (kind, trial), text in known.items() if kind == experiment}
    wrong = {trial: text for trial, text in results.items() if text.startswith("wrong")}
    kinds = Counter("wrong" if text.startswith("wrong") else text for text in results.values())
    told = ", ".join(f"{count} {text}" for text, count in kinds.most_common(6))
    print(f"{experiment}: {len(results)} trials, {len(wrong)} wrong ({told})", flush=True)
    for trial, text in wrong.items():
        print(f"  {trial}: {text}", flush=True)


def fewer(count: int, scale: float) -> int:
    return max(1, round(count * scale))


@functools.cache
def reference_run(place: Path) -> Whole:
    return Whole(place)


def on_runs(count: int, trial: Callable[[Whole, Path, int], str], place: Path) -> Trials:
    whole = reference_run(place)
    for seed in range(count):
        out = place / f"run-{seed}"

        def act(out: Path = out, seed: int = seed) -> str:
            try:
                return trial(whole, out, seed)
            finally:
                shutil.rmtree(out, ignore_errors=True)

        yield str(seed), act


def kills(place: Path, scale: float) -> Trials:
    yield from on_runs(fewer(200, scale), fault_trials.killed, place)


def disks(place: Path, scale: float) -> Trials:
    yield from on_runs(fewer(50, scale), fault_trials.full_disk, place)


def file_systems(place: Path, scale: float) -> Trials:
    yield from on_runs(fewer(50, scale), fault_trials.full_file_system, place)


def files(place: Path, scale: float) -> Trials:
    """At full scale, yields 20 trials of 100 damaged files for each reader."""
    kept = place / "originals"
    kept.mkdir(exist_ok=True)
    for name, content in fault_trials.originals(reference_run(place)).items():
        (kept / name).write_bytes(content)
    size = 100 if scale > 0.05 else 10
    for reader in READERS:
        for batch in range(fewer(20, scale)):

            def act(reader: str = reader, batch: int = batch) -> str:
                seeds = list(range(size * batch, size * (batch + 1)))
                found = dict(in_child([str(kept), reader], seeds, 60.0))
                bad = {
                    seed: text for seed, text in found.items() if text not in ("read", "refused")
                }
                assert len(found) == size and not bad, bad
                return f"{size} of {reader}"

            yield f"{reader} {batch}", act


def scenes(place: Path, scale: float) -> Trials:
    for seed in range(fewer(COUNT, scale)):
        yield str(seed), lambda seed=seed: try_scene(seed)  # type: ignore[misc]


def draped(size: float, step: float | str, steps: int) -> str:
    """Drapes a cloth with edges of `size` [m] over a sphere, and returns its stretch in words."""
    flat = ls.grid(size=(size, size), cells=(12, 12)).moved((0, 0, 0.35 * size))
    obstacles = [ls.sphere(radius=0.33 * size, subdivisions=2)]
    scene = ls.Scene(cloths=[ls.Cloth(mesh=flat)], obstacles=obstacles)
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=step), threads=1)
    for _ in range(steps):
        sim.step()
    pairs = [p for p in sim.intersecting_pairs() if min(p) < len(sim.topology.triangles)]
    assert not pairs and sim.report.contacts.unresolved == 0, f"{len(pairs)} intersections"
    return f"stretch {sim.report.strain.stretch:.2f}"


def sizes(place: Path, scale: float) -> Trials:
    for size in SIZES:
        yield f"{size:g} m", partial(draped, size, "auto", fewer(200, scale))


def steps(place: Path, scale: float) -> Trials:
    for step in STEPS:
        count = fewer(min(0.5 / step, 5000), scale)
        yield f"{step:g} s", partial(draped, 0.3, step, count)


def long(place: Path, scale: float) -> Trials:
    for name in LONG:
        yield name, lambda name=name: sixty_seconds(name, 60.0 * scale)  # type: ignore[misc]


def sixty_seconds(name: str, duration: float) -> str:
    """Simulates the scene `name` for `duration` [s]. Returns a sentence with the memory after the
    first and the last third, and the mean time per step in them.
    """
    file = SceneFile.open(SCENES / f"{name}.py", LONG[name])
    sim = ls.Simulation(file.scene(), integrator=file.integrator, threads=1)
    memory, seconds = [], []
    for third in (1, 2, 3):
        began, first = time.process_time(), sim.step_index
        while sim.time < third * duration / 3:
            sim.step()
        seconds.append((time.process_time() - began) / max(sim.step_index - first, 1))
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        memory.append(pages * resource.getpagesize() / 1e6)
    told = (
        f"memory {memory[0]:.1f} and {memory[2]:.1f} MB, a step takes {1e3 * seconds[0]:.2f} and"
        f" {1e3 * seconds[2]:.2f} ms, in the first and the last third"
    )
    # The last third is compared with the second, because cloth has fewer contacts in the first.
    # Runs shorter than 60 s are not checked, because cloth may still fall in their last third.
    flat = memory[2] < memory[1] + 5.0 and seconds[2] < 1.5 * seconds[1] + 1e-3
    assert flat or duration < 60.0, told
    return told


def threads(place: Path, scale: float) -> Trials:
    names = [("drape", {"triangles": 450}), ("figures", {"figures": 1, "balls": 2})]

    def make(which: int) -> ls.Simulation:
        file = SceneFile.open(SCENES / f"{names[which][0]}.py", names[which][1])
        return ls.Simulation(file.scene(), integrator=file.integrator, threads=2)

    def act() -> str:
        alone, found = fault_trials.together(make, 40)
        assert alone == found, f"{alone} and {found}"
        return "same bits"

    for number in range(fewer(20, scale)):
        yield str(number), act


EXPERIMENTS: dict[str, Callable[[Path, float], Trials]] = {
    "kill": kills,
    "disk": disks,
    "file_system": file_systems,
    "files": files,
    "scenes": scenes,
    "sizes": sizes,
    "steps": steps,
    "threads": threads,
    "long": long,
}


if __name__ == "__main__":
    main()
