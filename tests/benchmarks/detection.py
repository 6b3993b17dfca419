"""Compares the collision detection of this package with that of ipctk (from PyPI), by ratios of
minimum times that are measured alternately in one run on one machine. The parts narrow and growth
run without ipctk.

    python tests/benchmarks/detection.py [SHARED/data/ccd]
            [--parts candidates detection narrow threads growth]

SHARED/data/ccd contains scenes.py, meshes and queries. By default SHARED is next to the project
directory. With one thread, times are processor times, which other programs hardly affect. With
several threads, they are wall times; set OMP_WAIT_POLICY=passive so that waiting threads do not
spin. The part threads lists processor and wall times for one thread and for two.

Candidates of this package are pairs of features that share no vertex and whose 18-DOPs overlap.
ipctk tests boxes and therefore lists more candidates.
"""

import argparse
import importlib.util
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
from loomstone.collision import Detector, continuous
from smoke import SHARED, package, parsed, present

SHEETS = ["fold8", "tight8", "stack4", "roll", "drape"]
MESHES = ["cloth-ball", "cloth-funnel", "rod-twist"]


def milliseconds(threads: int) -> float:
    return 1e3 * (time.process_time() if threads == 1 else time.perf_counter())


def least(threads: int, seconds: float, *functions: Callable[[], object]) -> list[float]:
    """Minimum time of each function [ms]. Calls alternate, so that all run under similar load.

    The first call of each is not counted.
    """
    times: list[list[float]] = [[] for _ in functions]
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or len(times[0]) < 4:
        for function, own in zip(functions, times, strict=True):
            start = milliseconds(threads)
            function()
            own.append(milliseconds(threads) - start)
    return [min(own[1:]) for own in times]


class Scene:
    def __init__(self, scenes: ModuleType, name: str, threads: int):
        ipctk = package("ipctk")
        self.x0, self.x1, triangles = scenes.load(name)
        ipctk.set_num_threads(threads)
        self.fortran = [np.asfortranarray(a) for a in (self.x0, self.x1)]
        self.mesh = ipctk.CollisionMesh(
            self.fortran[0],
            np.asfortranarray(scenes.edges(triangles)),
            np.asfortranarray(triangles),
        )
        self.ipctk, self.broad_phase, self.theirs = ipctk, ipctk.LBVH(), ipctk.Candidates()
        self.detector = Detector(triangles, threads=threads)
        self.n_triangles = len(triangles)

    def their_candidates(self) -> None:
        self.theirs.build(self.mesh, *self.fortran, 0.0, self.broad_phase)

    def their_detection(self) -> None:
        self.their_candidates()
        self.theirs.compute_collision_free_stepsize(
            self.mesh, *self.fortran, 0.0, self.ipctk.AdditiveCCD()
        )

    def candidates(self) -> tuple[np.ndarray, np.ndarray]:
        return self.detector.candidates(self.x0, self.x1, ordered=False)

    def collisions(self) -> int:
        return len(self.detector.collisions(self.x0, self.x1))


def candidates(scenes: ModuleType, threads: list[int], seconds: float) -> None:
    print("candidates              threads  LBVH ms  ours ms  ratio  ours  LBVH  bytes a triangle")
    for name in SHEETS + MESHES:
        for n in threads:
            scene = Scene(scenes, name, n)
            theirs, ours = least(n, seconds, scene.their_candidates, scene.candidates)
            found = sum(map(len, scene.candidates()))
            each = scene.detector.tree_bytes / scene.n_triangles
            print(
                f"{name:24s} {n:6d} {theirs:8.1f} {ours:8.1f} {theirs / ours:6.2f}  "
                f"{found} {len(scene.theirs)}  {each:.0f}",
                flush=True,
            )


def detection(scenes: ModuleType, threads: list[int], seconds: float) -> None:
    print(
        "whole detection         threads  LBVH + ACCD (earliest) ms  ours (every pair) ms  "
        "ratio  colliding pairs"
    )
    for name in [*SHEETS, "rod-twist"]:
        for n in threads:
            scene = Scene(scenes, name, n)
            theirs, ours = least(n, seconds, scene.their_detection, scene.collisions)
            print(
                f"{name:24s} {n:6d} {theirs:8.1f} {ours:8.1f} {theirs / ours:6.2f}  "
                f"{scene.collisions()}",
                flush=True,
            )


def narrow(data: Path, seconds: float) -> None:
    print("narrow phase            queries  us a query  missed  false  late")
    for path in sorted((data / "queries").glob("*.npz")):
        archive = np.load(path)
        for code, kind in enumerate(("vertex-face", "edge-edge")):
            chosen = archive["kind"] == code
            queries, truth = (
                np.ascontiguousarray(archive["Q"][chosen]),
                archive["gt"][chosen].astype(bool),
            )
            [each] = least(
                1, seconds / 4, lambda kind=kind, queries=queries: continuous(kind, queries)
            )
            hit, first = continuous(kind, queries)
            wrong = (
                (truth & ~hit).sum(),
                (hit & ~truth).sum(),
                (first[truth] > archive["toi_hi"][chosen][truth]).sum(),
            )
            microseconds = 1e3 * each / len(queries)
            print(
                f"{path.stem:16s} {kind:12s} {len(queries):6d} {microseconds:8.3f}  "
                f"{wrong[0]} {wrong[1]} {wrong[2]}",
                flush=True,
            )


def two_threads(scenes: ModuleType, seconds: float) -> None:
    """Compares one thread with two.

    Wall times require two idle processors. The processor time of the busier thread shows how well
    the work is divided.
    """
    print(
        "two threads, whole detection   wall: one ms  two ms  ratio   "
        "processor: one ms  longer of two ms  ratio"
    )
    for name in [*SHEETS, "rod-twist"]:
        one, two = Scene(scenes, name, 1), Scene(scenes, name, 2)
        wall: tuple[list[float], list[float]] = [], []
        worked: tuple[list[float], list[float]] = [], []
        end = time.perf_counter() + seconds
        while time.perf_counter() < end or len(wall[0]) < 4:
            for i, scene in enumerate((one, two)):
                start, all_start, own_start = (
                    time.perf_counter(),
                    time.process_time(),
                    time.thread_time(),
                )
                scene.collisions()
                everything, own = time.process_time() - all_start, time.thread_time() - own_start
                wall[i].append(1e3 * (time.perf_counter() - start))
                worked[i].append(1e3 * max(own, everything - own))
        a, b, c, d = (min(times[1:]) for times in (*wall, *worked))
        print(
            f"{name:30s} {a:10.1f} {b:8.1f} {a / b:6.2f} {c:14.1f} {d:12.1f} {c / d:10.2f}",
            flush=True,
        )


def growth(scenes: ModuleType, sizes: list[int], seconds: float) -> None:
    print(
        "growth of fold8       triangles  forming ms  candidates ms  detection ms  "
        "us a triangle  bytes a triangle"
    )
    for cells in sizes:
        # The gap, the speed of compression and the random speed are proportional to the cell size.
        x0, x1, triangles = scenes.folded(cells, 0.12 / cells, 8, 120 / cells, 12 / cells, 1)
        detector = Detector(triangles, threads=1)
        start = milliseconds(1)
        detector.candidates(x0, x1, ordered=False)
        forming = milliseconds(1) - start
        list_ms, all_ms = least(
            1,
            seconds,
            lambda d=detector, a=x0, b=x1: d.candidates(a, b, ordered=False),
            lambda d=detector, a=x0, b=x1: d.collisions(a, b),
        )
        n = len(triangles)
        print(
            f"{'':20s} {n:9d} {forming:8.0f} {list_ms:10.1f} {all_ms:10.1f} "
            f"{1e3 * all_ms / n:10.2f} {detector.tree_bytes / n:8.0f}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path, nargs="?", default=SHARED / "data" / "ccd")
    parser.add_argument(
        "--parts", nargs="+", default=["candidates", "detection", "narrow", "threads", "growth"]
    )
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--seconds", type=float, default=4.0, help="for each line")
    parser.add_argument("--cells", nargs="+", type=int, default=[120, 240, 480, 960])
    options = parsed(parser, parts=["narrow", "growth"], threads=[1], seconds=0.01, cells=[30])
    spec = importlib.util.spec_from_file_location("scenes", present(options.data / "scenes.py"))
    scenes = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scenes)
    for part in options.parts:
        if part == "candidates":
            candidates(scenes, options.threads, options.seconds)
        elif part == "detection":
            detection(scenes, options.threads, options.seconds)
        elif part == "narrow":
            narrow(options.data, options.seconds)
        elif part == "threads":
            two_threads(scenes, options.seconds)
        elif part == "growth":
            growth(scenes, options.cells, options.seconds)
        else:
            sys.exit(f"there is no part {part}")


if __name__ == "__main__":
    main()
