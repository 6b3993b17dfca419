"""The command `loomstone new`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from .._core import CacheError
from .application import app, session

__all__ = ["write_new_file"]

EXAMPLE = '''"""A cotton cloth falls onto a sphere."""

import loomstone as ls

duration = 1.0  # simulated time [s]
rate = 25.0  # frames per second of simulated time
render = ls.RenderOptions(width=960, height=540)


def scene(triangles: int = 1800) -> ls.Scene:
    """Returns what is simulated. Parameters can be set by -p triangles=5000."""
    # To read a mesh from a file in the same directory: ls.meshes.read("cloth.obj").
    mesh = ls.grid(size=(0.5, 0.5), triangles=triangles).moved((0.0, 0.0, 0.13))
    # `loomstone fabrics` lists fabrics. For your own values: ls.ClothMaterial(density=0.15, ...).
    cloth = ls.Cloth(name="cloth", mesh=mesh, material=ls.fabrics["cotton"])
    obstacles = [ls.sphere(radius=0.12), ls.floor(height=-0.2)]
    return ls.Scene(cloths=[cloth], obstacles=obstacles)


def check(run: ls.Run) -> None:
    """Asserts what should hold in every run. `loomstone check` calls it."""
    assert run[-1].positions[:, 2].min() > -0.21, "the cloth does not fall through the floor"
    assert run[-1].stretch.max() < 1.2, "the cloth is not stretched by more than 20 %"
'''


@app.command()
def new(
    path: Annotated[Path, typer.Argument(help="file to write")] = Path("scene.py"),
) -> None:
    """Writes a scene file to start from.

    \b
        loomstone new mine.py
        loomstone run mine.py --render
    """
    with session(parallel=False):
        write_new_file(path, EXAMPLE)
        print(f"scene: {path}\nrun it: loomstone run {shlex.quote(str(path))} --render")


def write_new_file(path: Path, text: str) -> None:
    """Writes a new text file. Raises CacheError if the file exists or cannot be written."""
    try:
        with path.open("x") as file:
            file.write(text)
    except FileExistsError:
        raise CacheError(f"{path} must not exist yet; give another name") from None
    except OSError as error:
        raise CacheError(f"{path}: cannot be written: {error.strerror}") from error
