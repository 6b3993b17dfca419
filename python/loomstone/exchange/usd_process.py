"""Reads USD files in a separate process.

usd-core prints warnings, and damaged files can crash the process that reads them. This module hides
these warnings, and reports a crash as a CacheError of one sentence.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import traceback
import warnings
from pathlib import Path

import numpy as np

from .._core import CacheError, Error, InvalidInput, Unsupported
from ..base.cautions import SceneWarning
from ..base.safe_path import python
from .parts import Part
from .surfaces import Floats

__all__ = ["read_usd_apart", "serve"]

_PROGRAM = "from loomstone.exchange.usd_process import serve; serve()"
_ARRAYS = ("triangles", "frames", "corner_uv")  # fields of a Part
_ERRORS: tuple[type[Error], ...] = (InvalidInput, Unsupported, CacheError)


def read_usd_apart(
    path: Path, rate: float | None, *, moving: bool, with_uv: bool
) -> tuple[list[Part], Floats]:
    """Reads a file as usd_reader.read_usd does, with the same errors and the same SceneWarnings.

    Also raises CacheError if the process fails or crashes. An unexpected error in read_usd raises a
    RuntimeError whose message is the traceback.
    """
    with tempfile.TemporaryDirectory() as scratch:
        result = Path(scratch) / "result.npz"
        order = json.dumps([str(path.absolute()), str(path), rate, moving, with_uv, str(result)])
        done = subprocess.run(
            [*python(), "-c", _PROGRAM, order],
            capture_output=True,
            text=True,
            errors="replace",
        )
        if done.returncode != 0 or not result.exists():
            lines = done.stderr.strip().splitlines()
            reason = lines[-1] if done.returncode > 0 and lines else "usd-core has crashed"
            raise CacheError(f"{path}: is damaged, and cannot be read as USD: {reason}")
        with np.load(result) as arrays:
            content = dict(arrays)
    if "error" in content:
        kind, text = content["error"].tolist()
        raise next((known for known in _ERRORS if known.__name__ == kind), RuntimeError)(text)
    for sentence in content["warnings"].tolist():
        warnings.warn(sentence, SceneWarning, stacklevel=2)
    parts = [
        Part(name, place, *(content[f"{kind}_{i}"] for kind in _ARRAYS))
        for i, (name, place) in enumerate(content["names"].tolist())
    ]
    return parts, content["times"]


def serve() -> None:
    """Reads a USD file in the separate process.

    The last argument of the process is a JSON list: the path of the USD file, the path to show in
    messages, the arguments `rate`, `moving` and `with_uv` of read_usd(), and the path of an .npz
    file. The function writes the result to this file: the parts, the times of their frames and the
    warnings or, if reading fails, the error.
    """
    path, shown, rate, moving, with_uv, result = json.loads(sys.argv[-1])
    try:
        from .usd_reader import read_usd

        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("always", SceneWarning)
            parts, times = read_usd(Path(path), rate, moving=moving, with_uv=with_uv)
    except _ERRORS as error:
        kind = next(known for known in _ERRORS if isinstance(error, known))
        np.savez(result, error=[kind.__name__, str(error).replace(path, shown)])
        return
    except Exception:
        np.savez(result, error=["RuntimeError", traceback.format_exc()])
        return
    names = [[part.name, part.path] for part in parts]
    told = [str(w.message).replace(path, shown) for w in issued if w.category is SceneWarning]
    arrays = {
        "warnings": np.array(told, str),
        "names": np.array(names, str).reshape(-1, 2),
        "times": times,
    }
    for i, part in enumerate(parts):
        arrays.update({f"{kind}_{i}": getattr(part, kind) for kind in _ARRAYS})
    np.savez(result, **arrays)  # type: ignore[arg-type]
