"""A rank that waits for others polls at first and then sleeps."""

import subprocess

import pytest
from launcher import ENVIRONMENT, command, needs_mpirun

pytestmark = needs_mpirun

# Rank 0 waits for 0.3 s and prints the number of its voluntary context switches in this time.
WAIT = """
import resource, time
from loomstone import _core
ranks = _core.mpi_communicator()
ranks.barrier()
if ranks.rank == 1:
    time.sleep(0.3)
before = resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
ranks.barrier()
if ranks.rank == 0:
    print("sleeps", resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw - before)
"""


def run(program, spin):
    environment = {k: v for k, v in ENVIRONMENT.items() if k != "LOOMSTONE_MPI_SPIN"}
    if spin is not None:
        environment["LOOMSTONE_MPI_SPIN"] = spin
    return subprocess.run(
        command(2, "-c", program), capture_output=True, text=True, timeout=60, env=environment
    )


@pytest.mark.parametrize(("spin", "sleeps"), [(None, True), ("0", True), ("1e9", False)])
def test_a_rank_that_waits_longer_than_it_polls_sleeps(spin, sleeps):
    done = run(WAIT, spin)
    assert done.returncode == 0, done.stderr
    # A sleep lasts at most 200 us, so there are over a thousand sleeps on an idle machine. On a
    # busy machine, waking up takes some milliseconds.
    count = int(done.stdout.split()[1])
    assert count >= 20 if sleeps else count < 20


@pytest.mark.parametrize("spin", ["soon", "-1", "nan"])
def test_a_polling_time_that_is_no_time_is_refused(spin):
    done = run(WAIT, spin)
    assert done.returncode != 0
    assert "LOOMSTONE_MPI_SPIN must be a number of microseconds >= 0" in done.stderr
