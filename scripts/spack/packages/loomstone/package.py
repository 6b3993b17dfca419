"""Recipe of loomstone for Spack, from a checkout or an sdist of the sources.

    spack repo add scripts/spack
    spack dev-build loomstone@0.1.0

The recipe has not been tried with Spack, and the repository of your Spack may lack some of the
Python packages, such as py-cmap. tests/python/architecture/test_packages.py compares the recipe's
dependencies and variants with pyproject.toml and CMake.
"""

from spack.package import *
from spack_repo.builtin.build_systems.python import PythonPackage


class Loomstone(PythonPackage):
    """Simulates cloth, collisions, rigid bodies and magnetic forces."""

    license("Apache-2.0")

    version("0.1.0")

    variant("mpi", default=True, description="several ranks, by a plug-in")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("python@3.10:", type=("build", "link", "run"))
    depends_on("py-scikit-build-core@1:", type="build")
    depends_on("py-pybind11@3:", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")

    depends_on("bullet3+double")
    depends_on("eigen@3.4:3")
    depends_on("embree@3.13:3")
    depends_on("fmt@9:")
    depends_on("hdf5~mpi@1.10:")
    depends_on("libpng@1.6:")
    depends_on("metis@5.1:")
    depends_on("suite-sparse@5.12:")
    depends_on("tbb")
    depends_on("mpi", when="+mpi")
    depends_on("mesa@:25.0+osmesa", type=("build", "run"))  # later versions have no OSMesa
    depends_on("egl", type="build")

    depends_on("py-numpy@1.23:", type=("build", "run"))
    depends_on("py-scipy@1.9:", type="run")
    depends_on("py-typer@0.12:", type="run")
    depends_on("py-rich@13:", type="run")
    depends_on("py-imageio-ffmpeg@0.5:", type="run")
    depends_on("py-pillow@10.1:", type="run")
    depends_on("py-cmap@0.5:", type="run")
    depends_on("py-pint@0.24:", type="run")

    conflicts("%gcc@:11", msg="loomstone needs C++20")

    def config_settings(self, spec, prefix):
        without_mpi = "OFF" if spec.satisfies("+mpi") else "ON"
        return {"cmake.define.CMAKE_DISABLE_FIND_PACKAGE_MPI": without_mpi}
