"""Figure 6.7 of [Thomaszewski2010]: force between two cubes of 1 cm and 1 T, computed with
increasing numbers of cells and with the accurate engine (core/magnetics/forces/interaction.h).

    python tests/benchmarks/cube_convergence.py [--most 100] [--tree 100] [--out cubes.png]

Both cubes are aligned lattices of N x N x N dipoles. The force of a pair depends only on its
offset, so the sum runs over offsets instead of pairs. Up to N = --tree, the treecode sums over the
dipoles themselves at a gap of 5 mm. The result must differ from the sum over offsets by less than
twice the tolerance of the treecode.

Errors are relative to the closed form for parallel cuboids. For the accurate engine, one cube is
turned by 1e-9 rad relative to the other, so that the engine integrates numerically instead of using
this closed form. The processor time of the accurate engine is printed too.
"""

import argparse
import time

import numpy as np
from loomstone import magnetics as M
from smoke import parsed

EDGE = 0.01
GAPS = (0.0, 0.0005, 0.001, 0.005, 0.01, 0.02)  # [m]


def force_by_offsets(n: int, distance: float) -> float:
    """Force [N] between two lattices of n^3 dipoles whose centres are `distance` [m] apart.

    The line of centres is the direction of magnetisation.
    """
    h, moment = EDGE / n, EDGE**3 / M.MU0 / n**3
    k = np.arange(n)
    weight = np.where(k == 0, 1.0, 2.0) * (n - k)  # number of pairs at offset +-k
    square = (h * k) ** 2
    across = square[:, None] + square[None, :]
    weights = weight[:, None] * weight[None, :]
    total = 0.0
    for along in range(1 - n, n):
        z = distance + h * along
        r2 = across + z * z
        # Equation (6.10) of [Thomaszewski2010] with both moments along z.
        total += (n - abs(along)) * float((weights * z * (9 * r2 - 15 * z * z) / r2**3.5).sum())
    return M.MU0 / (4 * np.pi) * moment**2 * total


def force_by_tree(n: int, distance: float, tolerance: float) -> float:
    line = ((np.arange(n) + 0.5) / n - 0.5) * EDGE
    points = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    moments = np.tile((0.0, 0.0, EDGE**3 / M.MU0 / n**3), (n**3, 1))
    forces, _ = M.dipole_forces(
        points + (0, 0, distance), moments, points, moments, tolerance=tolerance
    )
    return float(forces[:, 2].sum())


def exact_force(gap: float) -> float:
    cube = M.cuboid(size=(EDGE, EDGE, EDGE), polarization=(0, 0, 1))
    return float(M.force(on=cube.moved((0, 0, EDGE + gap)), by=cube, tolerance=1e-9).force[2])


def accurate_error(gap: float, tolerance: float) -> tuple[float, float]:
    """Returns the relative error of the force and the least processor time of five calls [ms]."""
    cube = M.cuboid(size=(EDGE, EDGE, EDGE), polarization=(0, 0, 1))
    other = cube.moved((0, 0, EDGE + gap)).rotated((0, 0, 1e-9))
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        found = M.force(on=other, by=cube, tolerance=tolerance)
        best = min(best, time.process_time() - start)
    return abs(found.force[2] / exact_force(gap) - 1), 1e3 * best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=100)
    parser.add_argument("--tree", type=int, default=100)
    parser.add_argument("--tolerance", type=float, default=1e-4)
    parser.add_argument("--out")
    arguments = parsed(parser, most=4, tree=4)
    numbers = [
        n for n in (1, 2, 3, 4, 6, 8, 10, 15, 20, 30, 46, 60, 80, 100) if n <= arguments.most
    ]
    errors = {}
    print(
        "relative error of the force by N^3 cells a cube; "
        "tree: its difference from the sum over offsets"
    )
    print(
        f"{'N':>4}" + "".join(f"{f'{1e3 * gap:g} mm':>12}" for gap in GAPS) + f"{'tree, 5 mm':>14}"
    )
    exact = {gap: exact_force(gap) for gap in GAPS}
    for n in numbers:
        found = {gap: force_by_offsets(n, EDGE + gap) for gap in GAPS}
        errors[n] = [found[gap] / exact[gap] - 1 for gap in GAPS]
        line = f"{n:4}" + "".join(f"{e:12.2e}" for e in errors[n])
        if n <= arguments.tree:
            apart = abs(force_by_tree(n, EDGE + 0.005, arguments.tolerance) / found[0.005] - 1)
            assert apart < 2 * arguments.tolerance, "tree and lattice agree"
            line += f"{apart:14.1e}"
        print(line, flush=True)
    print("accurate engine: relative error (milliseconds)")
    tolerances = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8)
    accurate = {t: [accurate_error(gap, t) for gap in GAPS] for t in tolerances}
    for t in tolerances:
        print(f"{t:8.0e}" + "".join(f"{e:9.0e} ({ms:6.3f})" for e, ms in accurate[t]))
    if arguments.out:
        plot(numbers, errors, accurate, arguments.out)


def plot(numbers: list[int], errors: dict, accurate: dict, out: str) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), sharey=True)
    for i, gap in enumerate(GAPS):
        left.loglog(
            numbers,
            [abs(errors[n][i]) for n in numbers],
            "o-",
            label=f"{1e3 * gap:g} mm",
            markersize=3,
        )
        right.loglog(
            list(accurate), [max(accurate[t][i][0], 1e-12) for t in accurate], "o-", markersize=3
        )
    right.loglog(list(accurate), list(accurate), "k:", label="tolerance")
    left.set_xlabel("cells along an edge [1]")
    left.set_ylabel("relative error of the force [1]")
    left.set_title("dipole cells")
    left.legend(title="gap")
    right.invert_xaxis()
    right.set_xlabel("tolerance [1]")
    right.set_title("accurate engine")
    right.legend()
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main()
