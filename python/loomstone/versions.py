"""Versions of loomstone, Python and selected packages."""

from __future__ import annotations

import os
import platform
import sys

from . import _core
from .base.waiting import WAITING

__all__ = ["show_versions"]


def show_versions() -> None:
    """Prints the versions of loomstone, Python and selected packages.

    Also prints the platform, the number of processors, whether the MPI plug-in is present, and how
    threads wait.
    """
    from importlib import metadata  # a late import, because it loads slowly

    print(f"loomstone {_core.__version__}")
    print(f"python {sys.version.split()[0]} on {platform.platform()}")
    packages = [
        "numpy",
        "scipy",
        "typer",
        "rich",
        "imageio-ffmpeg",
        "matplotlib",
        "meshio",
        "coacd",
        "mpi4py",
        "vtk",
        "h5py",
    ]
    for package in packages:
        try:
            print(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            print(f"{package} not installed")
    plugin = os.path.join(os.path.dirname(_core.__file__), "libloomstone_mpi.so")
    print(
        f"processors {_core.available_processors()}, MPI plug-in"
        f" {'present' if os.path.exists(plugin) else 'absent'}"
    )
    print(f"waiting threads: {WAITING}")
