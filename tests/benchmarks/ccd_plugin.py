"""loomstone as the plug-in of the shared collision benchmarks (SHARED/data/ccd/broad.py and
pipeline.py):

python SHARED/data/ccd/broad.py --plugin ccd_plugin --path tests/benchmarks
python SHARED/data/ccd/pipeline.py --plugin ccd_plugin --path tests/benchmarks --no-ti
python SHARED/data/ccd/broad.py --plugin ccd_plugin --path tests/benchmarks --scenes fold8_h1.5mm
--check REQUIRED.npz
"""

import numpy as np
from loomstone.collision import Detector


def setup(V0, F, E, threads):
    detector = Detector(F, threads=threads)
    assert np.array_equal(detector.edges, E), "edge ids must mean the same"
    detector.candidates(V0, V0)  # forms the tree
    return detector


def candidates(detector, V0, V1, inflation):
    return detector.candidates(V0, V1, inflation, ordered=False)


def collisions(detector, V0, V1):
    return len(detector.collisions(V0, V1))


def earliest_toi(detector, V0, V1, min_distance):
    if min_distance:
        raise ValueError("only for a distance of 0")
    return min(1.0, detector.collisions(V0, V1).time)
