"""Plug-in for the shared collision benchmarks (SHARED/data/ccd/broad.py and pipeline.py).

python SHARED/data/ccd/broad.py --plugin ccd_plugin --path tests/benchmarks
python SHARED/data/ccd/pipeline.py --plugin ccd_plugin --path tests/benchmarks --no-ti
python SHARED/data/ccd/broad.py --plugin ccd_plugin --path tests/benchmarks
        --scenes fold8_h1.5mm --check REQUIRED.npz

SHARED is the folder `shared` next to the project directory. REQUIRED.npz contains pairs that must
be among the candidates.
"""

import argparse

import loomstone as ls
import numpy as np
from loomstone.collision import Detector
from smoke import parsed


def setup(V0, F, E, threads):
    detector = Detector(F, threads=threads)
    assert np.array_equal(detector.edges, E), "edge ids must mean the same"
    detector.candidates(V0, V0)  # builds the tree before the queries are timed
    return detector


def candidates(detector, V0, V1, inflation):
    return detector.candidates(V0, V1, inflation, ordered=False)


def collisions(detector, V0, V1):
    return len(detector.collisions(V0, V1))


def earliest_toi(detector, V0, V1, min_distance):
    if min_distance:
        raise ValueError("only for a distance of 0")
    return min(1.0, detector.collisions(V0, V1).time)


def smoke() -> None:
    """Calls every function on two sheets, one of which falls through the other."""
    sheet = ls.grid(size=(1, 1), cells=(4, 4))
    n, x = len(sheet.vertices), np.asarray(sheet.vertices)
    start, faces = np.vstack([x, x + (0.1, 0.05, 0.1)]), np.asarray(sheet.triangles)
    end = start - np.repeat([[0, 0, 0], [0, 0, 0.2]], n, axis=0)
    faces = np.vstack([faces, faces + n])
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    detector = setup(start, faces, edges, 1)
    found = sum(map(len, candidates(detector, start, end, 0.0)))
    colliding, first = collisions(detector, start, end), earliest_toi(detector, start, end, 0.0)
    assert 0 < colliding <= found and abs(first - 0.5) < 1e-6
    print(f"{found} candidates, {colliding} colliding, first at {first:.3f}")


if __name__ == "__main__":
    if parsed(argparse.ArgumentParser(description=__doc__)).smoke:
        smoke()
