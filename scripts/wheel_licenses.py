"""Adds to a wheel the licences of all libraries that it contains, and a table of these libraries.

    python scripts/wheel_licenses.py WHEEL DIRECTORY TARGET

DIRECTORY contains the licences of the libraries that scripts/wheel_libraries builds. The licences
of other libraries come from Python packages or from system packages. The wheel is written to the
directory TARGET, and its path is printed. A library without an entry below, or without the text of
its licence, is an error.
"""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

SYSTEM = Path("/usr/share")


@dataclass(frozen=True)
class Library:
    """A library in the wheel. `files` is empty for a header-only library."""

    name: str
    license: str  # SPDX expression
    files: str  # common prefix of its file names
    packages: str  # names of licence files or packages, searched in this order
    change: str = ""  # how the library differs from its release


LIBRARIES = [
    Library("Bullet (double precision)", "Zlib", "libBullet", "bullet libbullet3.24"),
    Library("Bullet LinearMath", "Zlib", "libLinearMath", "bullet libbullet3.24"),
    Library(
        "CHOLMOD",
        "LGPL-2.1-or-later AND BSD-3-Clause",
        "libcholmod",
        "cholmod",
        "without supernodal, modify, matrixops; with AMD, CAMD, COLAMD, CCOLAMD",
    ),
    Library("Eigen", "MPL-2.0", "", "eigen3 libeigen3-dev"),
    Library("Embree", "Apache-2.0", "libembree", "embree libembree3-3"),
    Library("GCC OpenMP", "GPL-3.0-or-later WITH GCC-exception-3.1", "libgomp", "libgomp libgomp1"),
    Library("HDF5", "BSD-3-Clause", "libhdf5", "hdf5", "without network code"),
    Library("libpng", "libpng-2.0", "libpng", "libpng1.6 libpng16-16"),
    Library("METIS", "Apache-2.0", "libmetis", "metis libmetis5"),
    Library("OSMesa", "MIT", "libOSMesa", "osmesa", "without LLVM"),
    Library("pybind11", "BSD-3-Clause", "", "pybind11"),
    Library("TBB", "Apache-2.0", "libtbb", "onetbb libtbb12"),
    Library("{fmt}", "MIT", "libfmt", "fmtlib libfmt9"),
]


class Incomplete(Exception):
    """A library has no entry in LIBRARIES, or no text of its licence is found."""


def contained(wheel: Path) -> dict[Library, list[Path]]:
    """Returns the libraries in an unpacked wheel with their files.

    Raises Incomplete if a shared library has no entry in LIBRARIES.
    """
    found: dict[Library, list[Path]] = {each: [] for each in LIBRARIES if not each.files}
    shared = [path for path in wheel.rglob("*.so*") if not path.name.startswith("_core.")]
    for path in sorted(shared):
        fitting = [each for each in LIBRARIES if each.files and path.name.startswith(each.files)]
        if not fitting:
            raise Incomplete(f"{path.name} has no entry in scripts/wheel_licenses.py")
        found.setdefault(max(fitting, key=lambda each: len(each.files)), []).append(path)
    return dict(sorted(found.items(), key=lambda item: item[0].name.lower()))


def with_common_licenses(text: str) -> str:
    """Returns a licence text, followed by Debian's common licences to which the text refers."""
    names = sorted(set(re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", text)))
    parts = [(SYSTEM / "common-licenses" / name).read_text(encoding="utf-8") for name in names]
    return "\n\n".join([text, *parts])


def text_of(library: Library, own: Path) -> str:
    """Returns the text of a library's licence. Raises Incomplete if there is none."""
    for package in library.packages.split():
        places = [own / f"{package}.txt", SYSTEM / "doc" / package / "copyright"]
        places += sorted(SYSTEM.glob(f"licenses/{package}/*"))
        for path in places:
            if path.is_file():
                return with_common_licenses(path.read_text(encoding="utf-8", errors="replace"))
        try:
            for file in importlib.metadata.files(package) or ():
                if "LICENSE" in file.name:
                    return Path(str(file.locate())).read_text(encoding="utf-8")
        except importlib.metadata.PackageNotFoundError:
            pass
    raise Incomplete(f"no licence of {library.name} was found, as {library.packages}")


def add_licenses(wheel: Path, own: Path) -> None:
    """Writes the licences and the table of libraries into the metadata of an unpacked wheel."""
    metadata = next(wheel.glob("*.dist-info"))
    folder = metadata / "licenses" / "third_party"
    folder.mkdir(parents=True)
    rows = ["| library | licence | size [MB] | file | change |", "| - | - | - | - | - |"]
    names = []
    for library, files in contained(wheel).items():
        name = library.packages.split()[0] + ".txt"
        (folder / name).write_text(text_of(library, own), encoding="utf-8")
        size = sum(path.stat().st_size for path in files) / 1e6
        shown = ", ".join(path.name for path in files) or "compiled into the module"
        rows.append(
            f"| {library.name} | {library.license} | {size:.1f} | {shown} | {library.change} |"
        )
        names.append(name)
    head = (
        "# Libraries that this wheel contains\n\nThe texts of their licences are beside this file."
        " Sources: those of Debian 12, or the\ndirectory given to scripts/wheel_libraries, which"
        " makes the changes.\n\n"
    )
    (folder / "README.md").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    text = (metadata / "METADATA").read_text(encoding="utf-8")
    lines = "".join(f"License-File: third_party/{name}\n" for name in sorted({*names, "README.md"}))
    at = text.index("License-File: LICENSE\n")
    (metadata / "METADATA").write_text(text[:at] + lines + text[at:], encoding="utf-8")


def main() -> None:
    wheel, own, target = map(Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "wheel"]
        subprocess.run([*command, "unpack", "-d", folder, wheel], check=True, capture_output=True)
        unpacked = next(Path(folder).iterdir())
        try:
            add_licenses(unpacked, own)
        except Incomplete as error:
            sys.exit(f"wheel_licenses: {error}")
        subprocess.run([*command, "pack", "-d", target, unpacked], check=True, capture_output=True)
    print(target / wheel.name)


if __name__ == "__main__":
    main()
