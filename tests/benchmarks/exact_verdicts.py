"""Compares verdicts and impact times of continuous collision detection with those of exact integer
arithmetic in Python. The queries are random, and most of them are degenerate.

    python tests/benchmarks/exact_verdicts.py --queries 1000000 [--seed 0]
"""

import argparse
import sys
import time
from fractions import Fraction

import numpy as np
from loomstone import collision
from smoke import ROOT, parsed

sys.path.insert(0, str(ROOT / "tests" / "python" / "collision"))
from exact_queries import FAMILIES, degenerate_queries, exact_verdict

SHARES = {
    "generic": 6,
    "at rest": 5,
    "together": 6,
    "start": 2,
    "end": 2,
    "parallel": 2,
}  # relative numbers of queries by family; 1 for the other families


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--queries", type=int, default=1000000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--chunk", type=int, default=50, help="queries of one draw of a family")
    options = parsed(parser, queries=500, chunk=1)
    random = np.random.default_rng(options.seed)
    count = {
        (family, kind): np.zeros(4, int)
        for family in FAMILIES
        for kind in ("vertex-face", "edge-edge")
    }
    done, said, start = 0, 0, time.perf_counter()
    while done < options.queries:
        for (family, kind), row in count.items():
            queries = degenerate_queries(
                random, kind, family, SHARES.get(family, 1) * options.chunk
            )
            hit, first = collision.continuous(kind, queries)
            for i, query in enumerate(queries):
                exact = exact_verdict(kind, query)
                late = bool(hit[i]) and exact is not None and Fraction(float(first[i])) > exact
                if (exact is not None) != hit[i] or late:
                    print(
                        "WRONG",
                        kind,
                        family,
                        hit[i],
                        first[i],
                        exact,
                        [[x.hex() for x in point] for point in query.tolist()],
                    )
                row += 1, exact is not None, (exact is not None) != hit[i], late
            done += len(queries)
        if done >= said + 20000:
            said = done
            wrong, late = (
                sum(row[2] for row in count.values()),
                sum(row[3] for row in count.values()),
            )
            print(
                f"{done} queries, wrong {wrong}, late {late}, {time.perf_counter() - start:.0f} s",
                flush=True,
            )
    print("family         kind         queries  meet  wrong  late")
    for (family, kind), row in count.items():
        print(f"{family:14s} {kind:12s} {row[0]:7d} {row[1]:7d} {row[2]} {row[3]}")
    total = sum(count.values())
    print(
        f"all {total[0]} queries, {total[1]} meet, {total[2]} wrong, {total[3]} late, "
        f"{time.perf_counter() - start:.0f} s"
    )
    raise SystemExit(1 if total[2] + total[3] else 0)


if __name__ == "__main__":
    main()
