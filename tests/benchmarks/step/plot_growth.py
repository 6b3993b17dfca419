"""Plots the output of `benchmark_step growth` over the number of triangles: the time of a step in
units of the time of a matrix-vector product, and the iterations of the solver.

    build/tests/benchmarks/step/benchmark_step growth > growth.txt
    python tests/benchmarks/step/plot_growth.py growth.txt docs/images/step_growth.png
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from smoke import package, parsed

NAMES = {"pcg": "coarse levels", "block-jacobi": "block-Jacobi", "supernodal": "CHOLMOD"}
LINES = {"pcg": "o-", "block-jacobi": "^:", "supernodal": "s--"}


def read(path: Path) -> dict[tuple[str, float], list[tuple[int, int, float]]]:
    """Returns the rows (triangles, iterations, step time / product time) of each solver and step.

    The keys are (solver, step [ms]).
    """
    series: dict[tuple[str, float], list[tuple[int, int, float]]] = {}
    for line in path.read_text().splitlines():
        word = line.split()
        if word and word[0] == "step":
            series.setdefault((word[3], float(word[2])), []).append(
                (int(word[1]), int(word[7]), float(word[10]))
            )
    return series


def draw(source: Path, target: Path) -> None:
    package("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    figure, (times, counts) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    for (solver, h), rows in sorted(read(source).items(), reverse=True):
        triangles, iterations, products = zip(*sorted(rows), strict=True)
        line = LINES[solver]
        colour = "tab:blue" if h < 2 else "tab:orange"
        times.loglog(triangles, products, line, color=colour, label=f"{NAMES[solver]}, {h:g} ms")
        if solver != "supernodal":
            counts.loglog(
                triangles, iterations, line, color=colour, label=f"{NAMES[solver]}, {h:g} ms"
            )
    times.set(xlabel="triangles", ylabel="time of a step / block product of 7,396 rows")
    counts.set(xlabel="triangles", ylabel="iterations to 1e-4")
    for axes in (times, counts):
        axes.grid(which="both", alpha=0.3)
        axes.legend(fontsize=7)
    figure.savefig(target, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", type=Path, nargs="?", default=Path("growth.txt"))
    parser.add_argument("target", type=Path, nargs="?", default=Path("growth.png"))
    given = parsed(parser)
    if given.smoke:
        columns = "explicit mid-edge 1 20 4.0 0.05"
        lines = [f"step {n} 1.00 {s} {columns} {n / 50}" for n in (800, 5000) for s in NAMES]
        given.source.write_text("\n".join(lines) + "\n")
    draw(given.source, given.target)


if __name__ == "__main__":
    main()
