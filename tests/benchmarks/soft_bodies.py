"""Time to compute the force between a soft iron cube and a cubic magnet to an error of 0.5 %, with
loomstone and with magpylib-material-response.

    python -m pip install magpylib-material-response    # in a separate environment
    python tests/benchmarks/soft_bodies.py [--repeats 10]

Errors are relative to the force that loomstone computes with 20 cells per edge of the cube. The
times are those of loomstone with 8 cells per edge, and of magpylib-material-response with 4 to 16
cells per edge (--edges), increased until the error is below 0.5 %. Both programs set up the cube,
solve for its magnetisation and compute the force. For loomstone, the time without the set-up is
also listed; a further position of the same cube takes only this time. Prints processor times [ms]
(for loomstone, the smallest of --repeats), errors and ratios of the times.
"""

import argparse
import time
from collections.abc import Callable

import loomstone as ls
import numpy as np
from smoke import package, parsed

magpylib = package("magpylib")
apply_demag = package("magpylib_material_response.demag").apply_demag
mesh_cuboid = package("magpylib_material_response.meshing").mesh_Cuboid
M = ls.magnetics
EDGE, GAP, CHI = 0.01, 0.002, 1000.0
MAGNET = M.cuboid(size=(EDGE,) * 3, polarization=(0, 0, 1.0))


def fastest(function: Callable[[], float], repeats: int) -> tuple[float, float]:
    best, result = np.inf, 0.0
    for _ in range(repeats):
        start = time.process_time()
        result = function()
        best = min(best, time.process_time() - start)
    return 1e3 * best, result


def iron(cells: int) -> M.SoftBody:
    return M.soft_cuboid(size=(EDGE,) * 3, susceptibility=CHI, cells=cells, threads=1)


def force(soft: M.SoftBody) -> float:
    (induced,) = M.induce(soft.at((0, 0, EDGE + GAP)), by=MAGNET, threads=1).bodies
    return float(M.force(on=induced, by=MAGNET).force[2])


def other(cells: int) -> float:
    magnet = magpylib.magnet.Cuboid(dimension=(EDGE,) * 3, polarization=(0, 0, 1.0))
    soft = magpylib.magnet.Cuboid(
        dimension=(EDGE,) * 3, polarization=(0, 0, 1e-9), position=(0, 0, EDGE + GAP)
    )
    soft.susceptibility = CHI
    magnet.susceptibility = 0
    mesh = mesh_cuboid(soft, target_elems=cells, style_label="iron")
    everything = magpylib.Collection(magnet, mesh)
    apply_demag(everything, inplace=True)
    forces, _ = magpylib.getFT(magnet, mesh.sources_all, meshing=1)
    return float(np.asarray(forces)[..., 2].sum())


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--edges", type=int, nargs="+", default=[4, 6, 8, 10, 12, 14, 16])
    arguments = parsed(parser, repeats=1, edges=[2])
    wanted = force(iron(20))
    ours, found = fastest(lambda: force(iron(8)), arguments.repeats)
    soft = iron(8)
    again, _ = fastest(lambda: force(soft), arguments.repeats)
    print(
        f"loomstone, 8 cells: {ours:.1f} ms, again {again:.2f} ms, error {found / wanted - 1:+.2e}"
    )
    for edge in arguments.edges:
        theirs, found = fastest(lambda edge=edge: other(edge**3), 1)
        print(
            f"magpylib-material-response, {edge}^3 cells: {theirs:.0f} ms, "
            f"error {found / wanted - 1:+.2e}"
        )
        if abs(found / wanted - 1) < 5e-3:
            break
    print(f"ratio {theirs / ours:.0f}, of another place {theirs / again:.0f}")


if __name__ == "__main__":
    main()
