"""Speed of sums over many dipoles: direct pairs, treecode and fmm3dpy, in one run.

    python -m pip install fmm3dpy    # in a separate environment with this package on its path
    OMP_NUM_THREADS=1 python tests/benchmarks/many_dipoles.py [--most 1000000]
            [--tolerance 1e-4] [--threads 1]

Computes the field at each dipole of a lattice and the force on each dipole. Positions are jittered
by up to half the lattice spacing, and moments are random. Prints the processor time of each method;
for the treecode and fmm3dpy, this is the minimum of the repeats. Their error is the
root-mean-square error of the force on 200 dipoles against direct sums, relative to the root mean
square of the force. Above 50,000 dipoles, the time of direct sums is extrapolated. The columns of
fmm3dpy are left out if it is not installed.
"""

import argparse
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from loomstone import magnetics as M
from smoke import parsed

try:
    import fmm3dpy
except ImportError:
    fmm3dpy = None


def dipoles(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    side = int(np.ceil(n ** (1 / 3)))
    cells = np.stack(np.unravel_index(np.arange(n), (side, side, side)), axis=1)
    return 0.01 * (cells + 0.5 * rng.random((n, 3))) / side, 1e-3 * rng.normal(size=(n, 3))


def fastest(function: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    best, result = np.inf, None
    for _ in range(repeats):
        start = time.process_time()
        result = function()
        best = min(best, time.process_time() - start)
    return best, result


def forces_of_fmm(points: np.ndarray, moments: np.ndarray, eps: float) -> np.ndarray:
    """Force [N] from the second derivatives of the potential m.r / (4 pi r^3), by fmm3dpy."""
    out = fmm3dpy.lfmm3d(eps=eps, sources=points.T.copy(), dipvec=moments.T.copy(), pg=3)
    xx, yy, zz, xy, xz, yz = out.hess
    x, y, z = moments.T
    return -M.MU0 * np.stack(
        [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z], axis=1
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=1_000_000)
    parser.add_argument("--tolerance", type=float, default=1e-4)
    parser.add_argument("--eps", type=float, nargs="*", default=[1e-3])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--least", type=int, default=10_000)
    parser.add_argument("--direct", type=int, default=100_000, help="dipoles of the first line")
    arguments = parsed(parser, most=1000, least=1000, direct=2000)
    points, moments = dipoles(arguments.direct)
    some = slice(0, arguments.direct // 25)
    seconds, _ = fastest(
        lambda: M.dipole_forces(points[some], moments[some], points, moments, threads=1), 3
    )
    each = seconds * 25 / arguments.direct**2
    print(f"direct pairs, field and force, one thread: {1e-9 / each:.3f} G/s")
    print(f"{'dipoles':>9}{'tree [s]':>10}{'error':>9}{'us each':>9}{'direct [s]':>12}", end="")
    print(
        "".join(
            f"{f'fmm3d {eps:g} [s]':>18}{'error':>9}{'ratio':>7}"
            for eps in arguments.eps
            if fmm3dpy
        )
    )
    n = arguments.least
    while n <= arguments.most:
        points, moments = dipoles(n)
        repeats = 3 if n <= 100_000 else 1
        some = np.linspace(0, n - 1, 200).astype(int)
        exact, _ = M.dipole_forces(points[some], moments[some], points, moments)

        def error(found: np.ndarray) -> float:
            return float(np.linalg.norm(found[some] - exact) / np.linalg.norm(exact))  # noqa: B023

        ours, (found, _) = fastest(
            partial(
                M.dipole_forces,
                points,
                moments,
                tolerance=arguments.tolerance,
                threads=arguments.threads,
            ),
            repeats,
        )
        line = f"{n:9}{ours:10.3f}{error(found):9.1e}{1e6 * ours / n:9.2f}"
        if n <= 50_000:
            direct, _ = fastest(
                partial(M.dipole_forces, points, moments, threads=arguments.threads), 1
            )
            line += f"{direct:12.2f}"
        else:
            line += f"{n * n * each:11.0f}*"
        for eps in arguments.eps if fmm3dpy else []:
            theirs, found = fastest(partial(forces_of_fmm, points, moments, eps), repeats)
            line += f"{theirs:18.2f}{error(found):9.1e}{theirs / ours:7.2f}"
        print(line, flush=True)
        n = {1: 2, 2: 5, 5: 10}[int(str(n)[0])] * 10 ** (len(str(n)) - 1)
    print("* from the rate of the first line")


if __name__ == "__main__":
    main()
