"""Speed of fields and forces compared with magpylib in one run, for the same points and for the
same pairs of rotated cuboids.

    python -m pip install magpylib    # in a separate environment with this package on its path
    python tests/benchmarks/magnetics.py [--points 100000] [--repeats 20] [--threads 1]

Prints the processor time per point [ns] (the minimum of the repeats), the ratio of the times, and
the median relative difference of the two fields. Then prints the time [ms] and the relative error
of forces, compared with the table i_cuboid_general_FT.json in shared/data/magnets. magpylib divides
the magnet on which a force acts into 1,000 and into 10,000 cells.
"""

import argparse
import json
import time
from collections.abc import Callable
from functools import partial

import loomstone as ls
import numpy as np
from scipy.spatial.transform import Rotation
from smoke import SHARED, package, parsed, present

magpylib = package("magpylib")
M = ls.magnetics


def fastest(function: Callable[[], np.ndarray], repeats: int) -> tuple[float, np.ndarray]:
    best, result = np.inf, function()
    for _ in range(repeats):
        start = time.process_time()
        result = function()
        best = min(best, time.process_time() - start)
    return best, result


def bodies() -> dict[str, tuple[M.MagneticBody, object]]:
    """Returns each source by name, as a pair of this package's source and magpylib's source."""
    j = (0.3, -0.5, 0.8)
    mesh = ls.meshes.sphere(radius=0.01, subdivisions=2)
    square = [[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0], [0, 0, 0]]
    magnet, current = magpylib.magnet, magpylib.current
    triangles = magnet.TriangularMesh(
        vertices=mesh.vertices, faces=mesh.triangles, polarization=j, reorient_faces=False
    )
    return {
        "cuboid": (
            M.cuboid(size=(0.02, 0.01, 0.015), polarization=j),
            magnet.Cuboid(dimension=(0.02, 0.01, 0.015), polarization=j),
        ),
        "cylinder": (
            M.cylinder(radius=0.01, height=0.013, polarization=j),
            magnet.Cylinder(dimension=(0.02, 0.013), polarization=j),
        ),
        "ring": (
            M.cylinder(radius=0.01, height=0.013, inner_radius=0.004, polarization=j),
            magnet.CylinderSegment(dimension=(0.004, 0.01, 0.013, 0, 360), polarization=j),
        ),
        "sphere": (
            M.sphere(radius=0.01, polarization=j),
            magnet.Sphere(diameter=0.02, polarization=j),
        ),
        "mesh, 320 triangles": (M.mesh(mesh, polarization=j), triangles),
        "loop": (M.loop(radius=0.01, current=3.0), current.Circle(diameter=0.02, current=3.0)),
        "polyline, 4 segments": (
            M.polyline(square, current=2.0),
            current.Polyline(vertices=square, current=2.0),
        ),
        "dipole": (
            M.dipoles([[0, 0, 0]], [[1.0, 2.0, 3.0]]),
            magpylib.misc.Dipole(moment=(1.0, 2.0, 3.0)),
        ),
    }


def own_force(by: M.MagneticBody, on: M.MagneticBody, tolerance: float) -> np.ndarray:
    return M.force(on=on, by=by, tolerance=tolerance).force


def peer_force(by: object, on: object, cells: int) -> np.ndarray:
    return magpylib.getFT(by, on, meshing=cells)[0]


def compare_forces(repeats: int) -> None:
    table = present(SHARED / "data" / "magnets" / "i_cuboid_general_FT.json")
    print(
        f"\n{'turned cuboids':16}{'tolerance 1e-2':>24}{'1e-4':>20}{'1e-8':>20}"
        f"{'magpylib 1e3':>20}{'1e4':>20}  [ms, error]"
    )
    for case in json.loads(table.read_text())["cases"][:6]:
        a = M.cuboid(size=case["dim1"], polarization=case["J1"])
        b = M.cuboid(size=case["dim2"], polarization=case["J2_body"]).at(
            case["pos2"], case["quat2_wxyz"]
        )
        own = magpylib.magnet.Cuboid(dimension=case["dim1"], polarization=case["J1"])
        other = magpylib.magnet.Cuboid(
            dimension=case["dim2"], polarization=case["J2_body"], position=case["pos2"]
        )
        other.rotate(Rotation.from_quat(np.roll(case["quat2_wxyz"], -1)), anchor=None)
        found = [
            *(
                fastest(partial(own_force, a, b, tolerance), repeats)
                for tolerance in (1e-2, 1e-4, 1e-8)
            ),
            *(fastest(partial(peer_force, own, other, cells), 3) for cells in (1000, 10000)),
        ]
        expected = np.array(case["F2"])
        errors = [
            np.linalg.norm(np.squeeze(force) - expected) / np.linalg.norm(expected)
            for _, force in found
        ]
        print(
            f"{case['id']:20}"
            + "".join(f"{1e3 * t:12.3f}{e:8.0e}" for (t, _), e in zip(found, errors, strict=True))
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parsed(parser, points=100, repeats=1)
    rng = np.random.default_rng(1)
    points = rng.normal(size=(arguments.points, 3)) * 0.02
    print(
        f"magpylib {magpylib.__version__}, {arguments.points} points, {arguments.threads} threads"
    )
    print(f"{'source':22}{'ours':>10}{'magpylib':>12}  [ns/point] {'ratio':>8} {'difference':>12}")
    for name, (body, peer) in bodies().items():
        # Meshes get fewer points, because magpylib is slow for them.
        some = points[: max(2, arguments.points // 50)] if "mesh" in name else points
        ours, field = fastest(
            partial(M.field, body, some, threads=arguments.threads), arguments.repeats
        )
        theirs, reference = fastest(partial(peer.getB, some), max(3, arguments.repeats // 5))
        apart = np.linalg.norm(field - reference, axis=1) / np.linalg.norm(reference, axis=1)
        each = 1e9 / len(some)
        print(
            f"{name:22}{each * ours:10.1f}{each * theirs:12.1f}{'':11}{theirs / ours:9.1f} "
            f"{np.median(apart):12.1e}"
        )
    compare_forces(arguments.repeats)


if __name__ == "__main__":
    main()
