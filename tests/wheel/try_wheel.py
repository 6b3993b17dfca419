"""Tries an installed loomstone as a user would, in an environment without optional packages.

    python tests/wheel/try_wheel.py

Runs the commands of `loomstone` in a temporary directory. If the system has an OSMesa library,
compares its pictures with those of the wheel's OSMesa. scripts/wheel --test calls this program.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import loomstone as ls
from softpipe import ROUNDED, differences

SHEET = """
import loomstone as ls
duration = 0.08
def scene(solver: str = "pcg"):
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(cells=(6, 6)), pins=[0])])
def integrator(solver: str = "pcg"):
    return ls.SemiImplicitEuler(step=4e-3, linear_solver=solver)
"""
# Commands that need an optional package, and the package that their error message must name.
OPTIONAL = [
    (["export", "sheet", "--to", "usd"], "usd-core"),
    (["export", "sheet", "--to", "gltf"], "pygltflib"),
    (["view", "sheet", "--html", "page.html"], "viser"),
    (["plot", "sheet"], "matplotlib"),
]


def command(*arguments: object, **environment: str) -> tuple[int, str]:
    """Runs the command `loomstone`. Returns its exit code and what it printed."""
    done = subprocess.run(
        [Path(sys.executable).with_name("loomstone"), *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | environment,
    )
    return done.returncode, done.stdout


def works(*arguments: object, **environment: str) -> str:
    code, said = command(*arguments, **environment)
    assert code == 0, f"loomstone {' '.join(map(str, arguments))}: {said}"
    return said


def refused(sentence: str, *arguments: object, **environment: str) -> None:
    code, said = command(*arguments, **environment)
    lines = said.strip().splitlines()
    assert code == 1 and len(lines) <= 3 and sentence in lines[-1], f"{arguments}: {code}, {said}"


def try_commands() -> None:
    began = time.perf_counter()
    works("demo", "--out", "demo", LOOMSTONE_GL="softpipe")
    print(f"demo: {time.perf_counter() - began:.0f} s")
    assert len(list(Path("demo/frames").glob("*.png"))) == 26
    assert Path("demo/video.mp4").stat().st_size > 1e4
    for arguments in (
        ["--help"],
        ["scenes"],
        ["versions"],
        ["new", "mine.py"],
        ["check", "mine.py"],
    ):
        works(*arguments)
    Path("sheet.py").write_text(SHEET)
    works("run", "sheet.py", "--out", "sheet")
    works("run", "sheet.py", "--out", "direct", "-p", "solver=direct")
    works("info", "sheet")
    works("export", "sheet", "--to", "obj", "--out", "objects")
    for arguments, package in OPTIONAL:
        refused(package, *arguments)
    refused("supernodal module", "run", "sheet.py", "--out", "never", "-p", "solver=supernodal")
    ranks = {"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "0"}
    refused("MPI is a plug-in of builds from the sources", "run", "sheet.py", **ranks)
    refused("must be osmesa, egl or softpipe", "render", "sheet", LOOMSTONE_GL="vulkan")


def try_pictures() -> None:
    """Compares pictures of the wheel's OSMesa with those of the system's OSMesa, if installed."""
    drawn = []
    for library in ("softpipe", "osmesa"):
        done = subprocess.run(
            [sys.executable, Path(__file__).with_name("softpipe.py"), f"{library}.npz"],
            env=os.environ | {"LOOMSTONE_GL": library},
            stderr=subprocess.PIPE,
            text=True,
        )
        if library == "osmesa" and "could not be loaded" in done.stderr:
            print("pictures: not compared, because the system has no OSMesa")
            return
        assert done.returncode == 0, done.stderr
        drawn.append(Path(f"{library}.npz"))
    differing = differences(*drawn)
    print(f"pixels that differ from the system's OSMesa: {max(differing.values()):.1e}")
    assert max(differing.values()) <= ROUNDED, differing


def main() -> None:
    print(f"loomstone {ls.__version__} in {Path(ls.__file__).parent}")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try_commands()
        try_pictures()
        os.chdir("/")
    print("the wheel works")


if __name__ == "__main__":
    main()
