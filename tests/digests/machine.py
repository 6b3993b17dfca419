"""Properties of the machine that affect the bits of a result: compiler, libraries and processor."""

from __future__ import annotations

import ctypes
import hashlib
import math
import platform
import re
from pathlib import Path

import numpy as np
import scipy
from loomstone import _core

LIBRARIES = re.compile(r"lib(Bullet|LinearMath|embree|openblas|cholmod|metis|gomp|omp)[^/]*\.so")


def compiler() -> str:
    """Returns the name and version of the compiler of the module `_core`, or "unknown"."""
    found = re.search(
        rb"(GCC: \([^)]*\) [\d.]+|clang version [\d.]+)", Path(_core.__file__).read_bytes()
    )
    return found[1].decode() if found else "unknown"


def libraries() -> list[Path]:
    """Returns the resolved paths of the loaded libraries whose names match LIBRARIES."""
    mapped = Path("/proc/self/maps").read_text().split()
    return sorted({Path(word).resolve() for word in mapped if LIBRARIES.search(word)})


def blas_kernels() -> str:
    for library in libraries():
        if library.name.startswith("libopenblas"):
            core = ctypes.CDLL(str(library)).openblas_get_corename
            core.restype = ctypes.c_char_p
            return str(core().decode())
    return "none"


def functions() -> str:
    """Returns a hash of the results of elementary functions of the C library and of numpy.

    The bits of the results depend on the versions of both libraries and on the processor.
    """
    x = np.linspace(-3.0, 3.0, 1001)
    scalar = [f(v) for f in (math.sin, math.cos, math.exp, math.atan, math.sinh) for v in x]
    arrays = [np.sin(x), np.cos(x), np.exp(x), np.arctan(x), np.sqrt(abs(x)), abs(x) ** 0.3]
    return hashlib.sha256(np.array([*scalar, *np.concatenate(arrays)]).tobytes()).hexdigest()[:16]


def machine() -> dict[str, str]:
    return {
        "architecture": platform.machine(),
        "C library": " ".join(platform.libc_ver()),
        "compiler": compiler(),
        "libraries": " ".join(path.name for path in libraries()),
        "BLAS kernels": blas_kernels(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "elementary functions": functions(),
    }
