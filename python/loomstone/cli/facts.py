"""The content of a file as named values, which `loomstone info --json` prints."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

from .. import _core, meshes
from .._core import CacheError, InvalidInput, TriangleMesh
from ..integrators import to_record
from ..runs.cache import Run
from ..runs.checkpoints import checkpoint_files
from ..runs.scene_file import SceneFile
from ..runs.steps import summary_of_steps

__all__ = ["facts", "mesh_of"]


def mesh_of(path: Path) -> TriangleMesh:
    """Reads a mesh, without its texture coordinates if they are not usable."""
    try:
        return meshes.read(path)
    except InvalidInput:
        return meshes.read(path, with_uv=False)


def facts(path: Path) -> dict[str, Any]:
    """Returns the content of a run, cache file, checkpoint, mesh or scene file as named values."""
    if not path.exists():
        raise CacheError(f"{path}: no such file or directory")
    if path.is_dir() or path.suffix == ".vtkhdf":
        return {"kind": "run", "path": str(path), **_of_run(Run(path))}
    if path.suffix == ".py":
        return {"kind": "scene", "path": str(path), **_of_scene(SceneFile.open(path, {}))}
    if path.suffix == ".h5":
        stored = _core.read_checkpoint(str(path))
        arrays = {name: list(array.shape) for name, array in sorted(stored.arrays.items())}
        kept = {"arrays": arrays, "integers": stored.integers, "texts": stored.texts}
        return {"kind": "checkpoint", "path": str(path), **kept}
    mesh = mesh_of(path)
    return {
        "kind": "mesh",
        "path": str(path),
        "vertices": mesh.n_vertices,
        "triangles": mesh.n_triangles,
        "closed": mesh.closed,
        "mean_edge": mesh.mean_edge,
        "low": mesh.vertices.min(0).tolist(),
        "high": mesh.vertices.max(0).tolist(),
        **{name: float(value) for name, value in meshes.quality(mesh).items()},
    }


def _of_scene(file: SceneFile) -> dict[str, Any]:
    absent = inspect.Parameter.empty
    return {
        "duration": file.duration,
        "rate": file.rate,
        "integrator": to_record(file.integrator),
        "parameters": {name: None if v is absent else v for name, v in file.known.items()},
    }


def _of_run(run: Run) -> dict[str, Any]:
    kept, topology = run.metadata, run.topology
    table = run.directory / "steps.csv"
    return {
        "frames": len(run),
        "end": float(run.times[-1]) if len(run) else 0.0,
        "rate": run.rate,
        "vertices": len(topology.cloth_of_vertex),
        "triangles": len(topology.triangles),
        "cloths": list(topology.cloth_names),
        "bodies": list(topology.body_names),
        "loomstone": kept.get("loomstone"),
        "duration": kept.get("duration"),
        "integrator": kept.get("integrator"),
        "scene_file": kept.get("scene_file", {}).get("path"),
        "parameters": kept.get("scene_file", {}).get("parameters"),
        "checkpoints": [path.name for path in checkpoint_files(run.directory)],
        "steps": summary_of_steps(table) if table.exists() else {},
    }
