"""Tests of runs that end early: exit code, the sentence that tells how to continue, and resumption.
A rank that does not answer is named, and the job ends. Also tests the check of
LOOMSTONE_MPI_TIMEOUT, the refusal of other launchers and the default number of threads.
"""

import os
import signal
import subprocess
import sys
import textwrap

import pytest
from launcher import ENVIRONMENT, command, needs_mpirun, ranks
from mortal_run import SCENE, arguments, resumes


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE)
    return tmp_path / "scene.py"


def run(scene, out, fault, by=0, n=2, timeout="60"):
    return subprocess.run(
        command(n, *arguments(scene, out, fault, by)),
        capture_output=True,
        text=True,
        timeout=60,
        env=ENVIRONMENT | {"LOOMSTONE_MPI_TIMEOUT": timeout},
    )


@needs_mpirun
@pytest.mark.parametrize("by", [0, 1])
def test_a_stopped_rank_is_named_with_its_host_and_ends_the_job(scene, tmp_path, by):
    # On a busy machine, mpirun may end before it has forwarded the last sentence of a rank that it
    # has killed.
    for attempt in range(3):
        out = tmp_path / f"out{attempt}"
        done = run(scene, out, "SIGSTOP", by, timeout="1")
        assert done.returncode == 75, done.stderr
        if "continue with" in done.stderr:
            break
    assert f"loomstone: rank {by} on {os.uname().nodename} does not answer" in done.stderr
    assert f"rank {1 - by} on " in done.stderr and "LOOMSTONE_MPI_TIMEOUT=1" in done.stderr
    assert f"continue with: loomstone resume {out}" in done.stderr


@needs_mpirun
def test_a_rank_that_computes_for_ever_is_named(scene, tmp_path):
    done = run(scene, tmp_path / "out", "slow", 1, timeout="1")
    assert done.returncode == 75, done.stderr
    assert "loomstone: rank 1 on " in done.stderr and "has not communicated for " in done.stderr


INTERRUPTED = """
import os
import signal
import time
import loomstone as ls
duration = 400.0
rank = int(os.environ["OMPI_COMM_WORLD_RANK"])
def interrupt():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.1)
def scene(when: str = ""):
    global chosen
    chosen = when
    if chosen == "early" and rank == 1:
        interrupt()
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.3, 0.3), cells=(16, 16)), pins=[0])])
def control(sim):
    if chosen == "twice" and rank == 1 and sim.step_index == 5:
        interrupt()
        interrupt()
"""


@needs_mpirun
@pytest.mark.parametrize(("when", "code"), [("early", 130), ("twice", 1)])
def test_an_interrupt_of_one_rank_ends_all(tmp_path, when, code):
    (tmp_path / "scene.py").write_text(INTERRUPTED)
    arguments = ("-m", "loomstone", "run", tmp_path / "scene.py", "--out", tmp_path / "out")
    done = subprocess.run(
        command(2, *arguments, "--threads", "1", "-p", f"when={when}"),
        capture_output=True,
        text=True,
        timeout=60,
        env=ENVIRONMENT,
    )
    assert done.returncode == code, done.stdout + done.stderr
    assert done.stderr.count("loomstone: interrupted") == 1


@needs_mpirun
@pytest.mark.parametrize("by", [0, 1])
def test_after_the_death_of_any_rank_the_command_that_resumes_is_printed(scene, tmp_path, by):
    out = tmp_path / "out"
    done = run(scene, out, "SIGKILL", by)
    assert done.returncode == 128 + signal.SIGKILL
    assert done.stderr.count(f"continue with: loomstone resume {out}") == 1, done.stderr
    assert resumes(out)


def test_a_killed_process_leaves_the_command_that_resumes(scene, tmp_path):
    out = tmp_path / "out and more"
    done = subprocess.run(
        [sys.executable, *map(str, arguments(scene, out, "SIGKILL"))],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == -signal.SIGKILL
    assert done.stderr == f"continue with: loomstone resume '{out}'\n"
    assert resumes(out)


def test_a_refused_run_names_no_command_that_would_be_refused_again(scene, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "run.vtkhdf").touch()
    done = subprocess.run(
        [sys.executable, *map(str, arguments(scene, tmp_path / "out", ""))],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1 and "continue with" not in done.stderr


@needs_mpirun
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1])
def test_a_signal_to_mpirun_saves_the_step_at_which_the_run_ends(scene, tmp_path, number):
    out = tmp_path / "out"
    process = subprocess.Popen(
        command(2, *arguments(scene, out, ""), "--duration", "400"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
    )
    for line in process.stdout:
        if line.startswith("frame 3/"):
            break
    process.send_signal(number)
    rest, _ = process.communicate(timeout=60)
    # mpirun returns 1 after SIGTERM, whatever the ranks return.
    assert process.returncode == (1 if number == signal.SIGTERM else 128 + number)
    assert f"stopped by {number.name}" in rest and f"loomstone resume {out}" in rest
    last = int((out / "steps.csv").read_text().splitlines()[-1].split(",")[0])
    assert (out / f"checkpoint-{last:010d}.h5").exists()


def test_sigcont_which_mpirun_sends_first_saves_the_current_step(scene, tmp_path):
    out = tmp_path / "out"
    done = subprocess.run(
        [sys.executable, *map(str, arguments(scene, out, "SIGCONT")), "--duration", "0.124"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    # The signal causes a checkpoint of step 26, and frames cause checkpoints of steps 10, 20 and
    # 30. The two newest checkpoints remain.
    steps = {int(path.stem.split("-")[1]) for path in out.glob("checkpoint-*.h5")}
    assert steps == {26, 30}


@needs_mpirun
def test_a_time_out_must_be_a_number_of_seconds_and_the_same_on_all_ranks(tmp_path):
    (tmp_path / "program.py").write_text(
        textwrap.dedent("""
        import os
        import sys
        rank = os.environ.get("OMPI_COMM_WORLD_RANK", "0")
        os.environ["LOOMSTONE_MPI_TIMEOUT"] = sys.argv[1 + int(rank)]
        import loomstone as ls
        try:
            ls.ranks.mpi_communicator()
        except ls.InvalidInput as error:
            print(error)
        """)
    )
    for given, said in [
        (("soon", "soon"), "must be a number of seconds"),
        (("20", ""), "must be the same on all ranks"),
    ]:
        done = ranks(2, tmp_path / "program.py", *given)
        assert done.stdout.count(f"LOOMSTONE_MPI_TIMEOUT {said}") == 2, done.stdout + done.stderr


def test_processes_of_another_launcher_are_refused_before_they_overwrite_one_another(scene):
    for rank, said in [(0, "loomstone: the launcher must belong to the MPI library"), (2, "")]:
        done = subprocess.run(
            [sys.executable, "-m", "loomstone", "run", str(scene)],
            capture_output=True,
            text=True,
            timeout=60,
            env=ENVIRONMENT | {"PMI_SIZE": "3", "PMI_RANK": str(rank)},
        )
        assert done.returncode == 1
        assert done.stderr.startswith(said) and done.stderr.count("\n") == bool(said)


@pytest.mark.parametrize(
    ("environment", "wanted"),
    [
        ({}, 8),
        # The process may use 8 of 16 processors. Unbound ranks divide these 8 among themselves.
        # Bound ranks divide all 16, but none uses more than 8.
        ({"OMPI_COMM_WORLD_SIZE": "4", "OMPI_COMM_WORLD_LOCAL_SIZE": "4", "NONE": "1"}, 2),
        ({"OMPI_COMM_WORLD_SIZE": "4", "OMPI_COMM_WORLD_LOCAL_SIZE": "4"}, 4),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_LOCAL_SIZE": "2"}, 8),
        ({"MPI_LOCALNRANKS": "3"}, 2),
        ({"SLURM_STEP_ID": "0", "SLURM_CPUS_PER_TASK": "4", "SLURM_NTASKS": "8"}, 4),
        ({"SLURM_STEP_ID": "0"}, 8),
        ({"OMPI_COMM_WORLD_LOCAL_SIZE": "many"}, 8),
        ({"OMP_NUM_THREADS": "3", "MPI_LOCALNRANKS": "4"}, 3),
        ({"OMP_NUM_THREADS": "3,2"}, 3),
        ({"OMP_NUM_THREADS": "many", "MPI_LOCALNRANKS": "4"}, 2),
    ],
)
def test_ranks_of_a_node_share_its_processors(environment, wanted, monkeypatch):
    for name in list(os.environ):
        if name.startswith(("OMP_", "OMPI_", "MPI_", "SLURM_")):
            monkeypatch.delenv(name)
    given = dict(environment)
    if given.pop("NONE", None):
        given["OMPI_MCA_hwloc_base_binding_policy"] = "none"
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    from loomstone import ranks as module

    monkeypatch.setattr(module, "available_processors", lambda: 8)
    monkeypatch.setattr(os, "cpu_count", lambda: 16)
    assert module.default_threads() == wanted
