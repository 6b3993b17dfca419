"""Two soft cuboids with edges 3 : 2 : 0.4 that magnetise each other in a uniform field.

    python tests/benchmarks/soft_pairs.py [--cells 8 12 16] [--finest 24] [--gaps 0.1 0.3 1 2]

For each number of cells along the shortest edge, prints the processor time [s] for the
factorisation, for the induced magnetisation and for the force, the number of iterations and the
largest memory so far [MB]. Here chi = 100, and the second cuboid is a tenth of its height above the
first and offset along both long edges. Then prints true and estimated relative errors of the force
and torque on the first cuboid, with the second one above, offset, beside and turned, at each gap
(in heights). These pairs have chi = 1, 100 and 1e5 in turn. True errors are differences from the
result with `--finest` cells.
"""

import argparse
import resource
import time

import loomstone as ls
import numpy as np
from smoke import parsed

M = ls.magnetics
SIZE = 0.01 * np.array([3.0, 2.0, 0.4])
RADIUS = 0.5 * float(np.linalg.norm(SIZE))
CHI = (1.0, 100.0, 1e5)


def placed(soft: M.SoftBody, kind: str, gap: float) -> M.SoftBody:
    height = float(SIZE[2])
    # A turned cuboid is rotated by 30 degrees about x. Its lowest edge is `gap` heights above the
    # top of the first cuboid.
    if kind == "turned":
        rise = 0.5 * (0.5 * SIZE[1] + np.cos(np.pi / 6) * height)
        turn = (np.cos(np.pi / 12), np.sin(np.pi / 12), 0.0, 0.0)
        return soft.at((0.002, 0.003, 0.5 * height + gap * height + rise), turn)
    places = {
        "above": (0.0, 0.0, height * (1.0 + gap)),
        "offset": (0.003, 0.002, height * (1.0 + gap)),
        "beside": (float(SIZE[0]) + gap * height, 0.001, 0.0005),
    }
    return soft.moved(places[kind])


def print_costs(cells: int) -> None:
    start = time.process_time()
    soft = M.soft_cuboid(size=SIZE, susceptibility=100.0, cells=cells, threads=1)
    made = time.process_time()
    pair = [soft, placed(soft, "offset", 0.1)]
    induced = M.induce(pair, field=(0.01, 0.02, 0.1), threads=1)
    solved = time.process_time()
    M.force(on=induced.bodies[0], by=induced.bodies[1])
    end = time.process_time()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print(
        f"{cells} cells: {made - start:.2f} s, {solved - made:.2f} s, {end - solved:.2f} s, "
        f"{induced.iterations} iterations, {memory:.0f} MB",
        flush=True,
    )


def wrench(soft: M.SoftBody, kind: str, gap: float, field: np.ndarray) -> tuple[np.ndarray, float]:
    """Returns the force and torque / RADIUS on the first cuboid and the estimated error, in [N]."""
    induced = M.induce([soft, placed(soft, kind, gap)], field=field)
    found = M.force(on=induced.bodies[0], by=induced.bodies[1])
    return np.array([found.force, found.torque / RADIUS]), found.error


def print_errors(cells: list[int], finest: int, gaps: list[float]) -> None:
    shapes = {n: M.soft_cuboid(size=SIZE, susceptibility=1.0, cells=n) for n in [*cells, finest]}
    rng = np.random.default_rng(5)
    cases = [(gap, kind) for gap in gaps for kind in ("above", "offset", "beside", "turned")]
    for k, (gap, kind) in enumerate(cases):
        chi, field = CHI[k % len(CHI)], 0.1 * rng.normal(size=3)
        found = {
            n: wrench(shape.with_susceptibility(chi), kind, gap, field)
            for n, shape in shapes.items()
        }
        wanted = found[finest][0]
        size = np.linalg.norm(wanted, axis=1).max()
        texts = [
            f"{n}: {np.linalg.norm(found[n][0] - wanted, axis=1).max() / size:.1e} "
            f"(estimated {found[n][1] / size:.1e})"
            for n in cells
        ]
        print(f"gap {gap}, {kind}, chi = {chi:g}: {', '.join(texts)}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cells", type=int, nargs="+", default=[8, 12, 16])
    parser.add_argument("--finest", type=int, default=24)
    parser.add_argument("--gaps", type=float, nargs="+", default=[0.1, 0.3, 1.0, 2.0])
    arguments = parsed(parser, cells=[8], finest=8, gaps=[1.0])
    for cells in arguments.cells:
        print_costs(cells)
    print_errors(arguments.cells, arguments.finest, arguments.gaps)


if __name__ == "__main__":
    main()
