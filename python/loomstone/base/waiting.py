"""How threads wait for the next parallel loop: they spin for a moment and then sleep.

A thread that only spins takes processor time from other programs. A thread that sleeps at once
takes tens of microseconds to wake. OpenMP's run-time library (libgomp) reads its settings from the
environment once, when it is loaded. This module therefore sets GOMP_SPINCOUNT while it loads
`_core`, which loads libgomp. The package must import this module before others that load `_core`.
If the user sets OMP_WAIT_POLICY or GOMP_SPINCOUNT, the user's setting is kept.

OpenBLAS, which `_core` and numpy load, starts threads of its own, which also spin before they
sleep. This module sets OPENBLAS_THREAD_TIMEOUT in the same way.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator

__all__ = ["WAITING"]

# Number of times a thread polls for the next loop before it sleeps. libgomp's default is 300000.
# `tests/benchmarks/waiting.py --triangles 14450` compares counts on two processors. On an otherwise
# idle machine, a count of 2000 takes 1.15 times the wall time of the default, and a count of 30000
# takes 1.02 times. If two other processes are busy, a count of 30000 takes 0.74 times the processor
# time of the default, and 0.82 times the wall time.
_SPIN_COUNT = 30000

# An idle thread of OpenBLAS spins for 2^_BLAS_TIMEOUT processor cycles before it sleeps. OpenBLAS
# has a default of 26, about 25 ms. Direct solvers of loomstone restrict OpenBLAS to one thread. On
# two processors, `import loomstone` takes 0.87 times the processor time with 16 instead of 26.
_BLAS_TIMEOUT = 16


def _libgomp_is_loaded() -> bool:
    """Returns whether this process has already loaded the system's libgomp.

    Copies of libgomp inside other packages have other file names and do not matter.
    """
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
            return any(re.search(r"/libgomp\.so\.1", line) for line in maps)
    except OSError:
        return False


@contextlib.contextmanager
def _environment(defaults: dict[str, str]) -> Iterator[None]:
    """Sets the variables of `defaults` that the user has not set, during the `with` block only."""
    added = {name: value for name, value in defaults.items() if name not in os.environ}
    os.environ.update(added)
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]


def _load_core() -> str:
    """Loads `_core`, and returns how threads wait, as text.

    Meanwhile, OPENBLAS_THREAD_TIMEOUT is _BLAS_TIMEOUT, unless the user has set it. GOMP_SPINCOUNT
    is _SPIN_COUNT, unless the user has chosen how threads wait or libgomp is already loaded.
    """
    given = [name for name in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT") if name in os.environ]
    too_late = _libgomp_is_loaded()
    defaults = {"OPENBLAS_THREAD_TIMEOUT": str(_BLAS_TIMEOUT)}
    if not given and not too_late:
        defaults["GOMP_SPINCOUNT"] = str(_SPIN_COUNT)
    with _environment(defaults):
        from .. import _core  # noqa: F401
    if given:
        return f"{given[0]}={os.environ[given[0]]} (environment)"
    if too_late:
        return (
            "default of OpenMP, since another package loaded libgomp first; import loomstone before"
            f" it, or set GOMP_SPINCOUNT={_SPIN_COUNT}"
        )
    return f"GOMP_SPINCOUNT={_SPIN_COUNT} (loomstone's)"


# How threads wait in this process, as show_versions() prints it.
WAITING = _load_core()
