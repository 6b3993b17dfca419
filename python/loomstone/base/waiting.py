"""How threads wait for the next parallel loop: they spin for a moment and then sleep.

A thread that only spins takes processor time from other programs. A thread that sleeps at once
takes tens of microseconds to wake. OpenMP's run-time library (libgomp) reads its settings from the
environment once, when it is loaded. This module therefore sets GOMP_SPINCOUNT while it loads
`_core`, which loads libgomp. The package must import this module first. If the user sets
OMP_WAIT_POLICY or GOMP_SPINCOUNT, the user's setting is kept.
"""

from __future__ import annotations

import os
import re

__all__ = ["WAITING"]

# Number of times a thread polls for the next loop before it sleeps. libgomp's default is 300000.
# `tests/benchmarks/waiting.py --triangles 14450` compares counts on two processors. On an otherwise
# idle machine, a count of 2000 takes 1.15 times the wall time of the default, and a count of 30000
# takes 1.02 times. If two other processes are busy, a count of 30000 takes 0.74 times the processor
# time of the default, and 0.82 times the wall time.
_SPIN_COUNT = 30000


def _libgomp_is_loaded() -> bool:
    """Returns whether this process has already loaded the system's libgomp.

    Copies of libgomp inside other packages have other file names and do not matter.
    """
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
            return any(re.search(r"/libgomp\.so\.1", line) for line in maps)
    except OSError:
        return False


def _load_core() -> str:
    """Returns how threads wait, as text. Loads `_core` with our spin count if it has an effect."""
    for name in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT"):
        if name in os.environ:
            return f"{name}={os.environ[name]} (environment)"
    if _libgomp_is_loaded():
        return (
            "default of OpenMP, since another package loaded libgomp first; import loomstone before"
            f" it, or set GOMP_SPINCOUNT={_SPIN_COUNT}"
        )
    os.environ["GOMP_SPINCOUNT"] = str(_SPIN_COUNT)
    try:
        from .. import _core  # noqa: F401
    finally:
        del os.environ["GOMP_SPINCOUNT"]
    return f"GOMP_SPINCOUNT={_SPIN_COUNT} (loomstone's)"


# How threads wait in this process, as show_versions() prints it.
WAITING = _load_core()
