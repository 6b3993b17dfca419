"""How threads wait for the next parallel loop: they spin for a moment, then sleep.

A thread that only spins keeps a processor from other programs; one that sleeps at once takes tens
of microseconds to wake. OpenMP's run-time library (libgomp) reads its settings from the environment
once, while it is loaded. This module therefore loads `_core`, which brings libgomp, and must be the
first of the package. A user's OMP_WAIT_POLICY or GOMP_SPINCOUNT decides where one is set.
"""

from __future__ import annotations

import os
import re

__all__ = ["WAITING"]

# Number of looks at the flag of the next loop before a thread sleeps. Measured by
# tests/benchmarks/waiting.py on a drape of 14,450 triangles and two processors: idle, 2000 takes
# 1.15 times and 30000 1.02 times the wall time of libgomp's 300000; beside two busy processes 30000
# takes 0.74 of its processor time and 0.82 of its wall time.
_SPIN_COUNT = 30000


def _libgomp_is_loaded() -> bool:
    """Whether this process has the system's libgomp already; copies inside other packages have
    other names and do not matter.
    """
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
            return any(re.search(r"/libgomp\.so\.1", line) for line in maps)
    except OSError:
        return False


def _load_core() -> str:
    """Loads `_core` with our setting, leaves the environment as it was, and says what holds."""
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


# For show_versions(): the setting that holds in this process.
WAITING = _load_core()
