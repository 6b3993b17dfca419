"""Starts programs on several ranks, even with fewer processors than ranks."""

import os
import shutil
import subprocess
import sys

import pytest

needs_mpirun = pytest.mark.skipif(shutil.which("mpirun") is None, reason="mpirun is not installed")

ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "OMP_WAIT_POLICY": "passive",
    "LOOMSTONE_MPI_TIMEOUT": "60",  # a rank that hangs fails its test instead of blocking all tests
}


def command(n, *arguments):
    """Returns the mpirun command for Python on n ranks that are not bound to processors."""
    launcher = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(n)]
    return [*launcher, sys.executable, *map(str, arguments)]


def ranks(n, *arguments, timeout=240):
    return subprocess.run(
        command(n, *arguments), capture_output=True, text=True, timeout=timeout, env=ENVIRONMENT
    )
