"""Checks what a wheel contains, and prints its libraries with their sizes.

    python tests/wheel/contents.py dist/loomstone-*.whl

Needs pyelftools, which auditwheel installs. scripts/wheel calls this program.
"""

from __future__ import annotations

import io
import re
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

LARGEST = 60e6  # largest size of a wheel [bytes]
# Libraries that a wheel must not contain: BLAS, LAPACK, LLVM, MPI, the GNU Fortran runtime, and the
# network libraries that HDF5 may use.
UNWANTED = re.compile(
    r"lib(curl|krb5|gssapi|ssl|crypto|ldap|openblas|blas|lapack|gfortran|LLVM|.*mpi)"
)
# Functions of the modules of CHOLMOD that are under the GPL: supernodal, modify and matrixops.
GPL = re.compile(
    r"cholmod_(l_)?(super_\w+|updown\w*|row(add|del)\w*|drop|horzcat|norm_\w+|scale|sdmult|ssmult"
    r"|submatrix|symmetry|vertcat)$"
)


def faults(names: list[str], functions: dict[str, list[str]], size: float) -> Iterator[str]:
    """Yields what is wrong with a wheel.

    names : paths of its files
    functions : for each file of CHOLMOD, the names of the functions that it defines
    size : size of the wheel [bytes]
    """
    if size > LARGEST:
        yield f"it must have at most {LARGEST / 1e6:.0f} MB, got {size / 1e6:.1f} MB"
    if not functions:
        yield "it must contain CHOLMOD as a shared library"
    for name in names:
        if UNWANTED.match(Path(name).name):
            yield f"it must not contain {name}"
    for library, defined in functions.items():
        if found := [each for each in defined if GPL.match(each)]:
            yield f"{library} has functions under the GPL: {', '.join(found)}"
    for wanted in (
        r"loomstone/_core\.[^/]+\.so",
        r"loomstone/libOSMesa\.so\.8",
        r"loomstone/scenes/drape\.py",
        r"[^/]+\.dist-info/licenses/LICENSE",
        r"[^/]+\.dist-info/licenses/third_party/README\.md",
        r"[^/]+\.dist-info/licenses/third_party/cholmod\.txt",
    ):
        if not any(re.fullmatch(wanted, name) for name in names):
            yield f"it has no file {wanted}"


def defined_functions(library: bytes) -> list[str]:
    """Returns the names of the dynamic symbols that a shared library defines."""
    from elftools.elf.elffile import ELFFile

    symbols = ELFFile(io.BytesIO(library)).get_section_by_name(".dynsym").iter_symbols()
    return [each.name for each in symbols if each["st_shndx"] != "SHN_UNDEF"]


def main() -> None:
    path = Path(sys.argv[1])
    with zipfile.ZipFile(path) as wheel:
        names = wheel.namelist()
        functions = {
            name: defined_functions(wheel.read(name)) for name in names if "/libcholmod" in name
        }
        table = [name for name in names if name.endswith("third_party/README.md")]
        print("".join(wheel.read(name).decode() for name in table))
    size = path.stat().st_size
    print(f"{path.name}: {size / 1e6:.1f} MB")
    if wrong := list(faults(names, functions, size)):
        sys.exit("\n".join(f"{path.name}: {each}" for each in wrong))


if __name__ == "__main__":
    main()
