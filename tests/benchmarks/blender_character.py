"""Compares a character in Blender with obstacles that are read from its glTF and USD files.

    python tests/benchmarks/blender_character.py [--blender-python PYTHON]

PYTHON is an interpreter that has the module bpy (Blender 5, Python 3.11). The character is a tube
with a shape key, skinned to a moving armature. For each file, the program prints the largest
distance between a vertex in Blender and the nearest vertex of the obstacle, over all frames.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import loomstone as ls
import numpy as np
from scipy.spatial import cKDTree
from smoke import missing, package, parsed

INSIDE = Path(__file__).parent / "inside_blender" / "character.py"


def largest_distance(obstacle: ls.Obstacle, wanted: np.ndarray) -> float:
    """Returns the largest distance [m] from a vertex in `wanted` (frames x n x 3) to the nearest
    vertex of the obstacle in the same frame.
    """
    frames = np.reshape(obstacle.vertex_positions, (len(wanted), -1, 3))
    pairs = zip(frames, wanted, strict=True)
    return max(cKDTree(found).query(points)[0].max() for found, points in pairs)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blender-python", default=sys.executable)
    settings = parsed(parser)
    found = [settings.blender_python, "-c", "import bpy"]
    if subprocess.run(found, capture_output=True).returncode:
        missing(f"{settings.blender_python} cannot import bpy")
    for name in ("pxr", "pygltflib"):
        package(name)
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch)
        done = subprocess.run(
            [settings.blender_python, str(INSIDE), scratch], capture_output=True, text=True
        )
        if done.returncode or not (out / "tube.npy").exists():
            raise SystemExit(f"Blender failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        wanted = np.load(out / "tube.npy")
        both = ["ArmatureAction", "CylinderAction"]  # Blender writes one animation per object
        for name, animation in (("tube.glb", both), ("tube.usdc", [])):
            tube = ls.obstacles.baked(out / name, rate=24.0, animation=animation)
            print(
                f"{name}: {len(tube.times)} samples of {tube.mesh.n_vertices} vertices, largest"
                f" distance {largest_distance(tube, wanted):.2g} m"
            )


if __name__ == "__main__":
    main()
