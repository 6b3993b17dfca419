"""Drapes a knit at several mesh sizes, to test whether conforming triangles lock when weft, warp
and shear are all limited to 1 %.

    python tests/benchmarks/locking.py --triangles 900 1800 3600 7200 --seeds 1 2 3

A limp knit hangs over the pedestal of the drape test. The table lists the drape coefficient and the
number of folds as means over specimens (one for each seed), and the largest strains. Limits:
- none: strain is not limited
- tight: 1 % of stretch and shear; compression is free, as by default
- both ways: also 1 % of compression
- 0.1 %, 0.1 % both: a tenth of the limits "tight" and "both ways", to show what locking looks like
"""

from __future__ import annotations

import argparse
import time

import loomstone as ls
import numpy as np
from loomstone.fabrics.measurements.drape_test import cusick
from smoke import parsed

LIMITS = {
    "none": None,
    "tight": ls.StrainLimit(0.01, 0.01, 0.01),
    "both ways": ls.StrainLimit(0.01, 0.01, 0.01, weft_min=-0.01, warp_min=-0.01),
    "0.1 %": ls.StrainLimit(0.001, 0.001, 0.001),
    "0.1 % both": ls.StrainLimit(0.001, 0.001, 0.001, weft_min=-0.001, warp_min=-0.001),
}
KNIT = ls.ClothMaterial(
    weft_stiffness=33,
    warp_stiffness=60,
    shear_stiffness=37,
    density=0.2,
    bending_weft=3.6e-6,
    bending_warp=3.6e-6,
)


def drapes(triangles: int, name: str, seeds: list[int]) -> None:
    began = time.process_time()
    results = [
        cusick(KNIT, strain_limit=LIMITS[name], triangles=triangles, seed=seed, threads=1)
        for seed in seeds
    ]
    strain = np.array([np.abs(ls.limits.strain(r.positions, r.mesh)).max(0) for r in results]).max(
        0
    )
    coefficients, folds = [r.drape_coefficient for r in results], [r.folds for r in results]
    print(
        f"{triangles:>6} {name:<10} {np.mean(coefficients):6.1f} % "
        f"(+-{np.std(coefficients):4.1f}) folds {np.mean(folds):5.1f} {folds} "
        f"strain {np.round(strain, 4)} rest {[r.rest.at_rest for r in results]} "
        f"{time.process_time() - began:.0f} s",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, nargs="+", default=[900, 1800, 3600])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--limits", nargs="+", default=list(LIMITS), choices=list(LIMITS))
    options = parsed(parser, triangles=[400], seeds=[1], limits=["tight"])
    for triangles in options.triangles:
        for name in options.limits:
            drapes(triangles, name, options.seeds)


if __name__ == "__main__":
    main()
