"""A run on three hosts ends when it loses one of them, and is resumed on the other two. A parameter
sweep goes on after it loses a worker: another worker takes over the runs. The hosts are network
namespaces of this machine with addresses of their own.
"""

import csv
import os
import signal
import subprocess
import sys
import time

import loomstone as ls
import pytest
from hosts import Hosts
from launcher import ENVIRONMENT, needs_mpirun
from mortal_run import SCENE, arguments, resumes

pytestmark = needs_mpirun


@pytest.fixture
def hosts(tmp_path):
    try:
        made = Hosts(tmp_path)
    except (subprocess.CalledProcessError, FileNotFoundError) as error:
        pytest.skip(f"network namespaces are not permitted: {getattr(error, 'stderr', error)}")
    yield made
    made.remove()


@pytest.mark.parametrize("death", ["SIGKILL", "cut link"])
def test_a_run_on_three_hosts_loses_one_and_continues_on_two(hosts, tmp_path, death):
    scene, out = tmp_path / "scene.py", tmp_path / "out"
    seen = "    open(os.path.join(os.path.dirname(__file__), os.uname().nodename), 'w').close()\n"
    scene.write_text(SCENE.replace("    global death\n", "    global death\n" + seen))
    # If the link is cut, rank 2 sleeps after step 25, so that the run does not end before the cut.
    fault = "SIGKILL" if death == "SIGKILL" else "slow"
    with open(tmp_path / "said", "w+") as said:
        process = subprocess.Popen(
            [*hosts.command(3), *map(str, arguments(scene, out, fault, 2))],
            stdout=said,
            stderr=subprocess.STDOUT,
            env=ENVIRONMENT | {"LOOMSTONE_MPI_TIMEOUT": "20"},
        )
        if death == "cut link":
            while process.poll() is None and not list(out.glob("checkpoint-0000000020.h5")):
                time.sleep(0.05)
            hosts.cut(3)
        code = process.wait(timeout=60)
        said.seek(0)
        text = said.read()
    assert {path.name for path in tmp_path.glob("node?")} == {"node1", "node2", "node3"}, text
    assert code == 137 if death == "SIGKILL" else code not in (0, 1), text
    # mpirun names the host by its name or by its address.
    assert "node3" in text or "10.78.0.3" in text, text
    assert f"continue with: loomstone resume {out}" in text, text
    print(text)
    assert resumes(out, hosts.command(2))
    assert '"ranks": 2' in (out / "report.json").read_text()


SLOW_SCENE = """
import os
import time
import loomstone as ls
duration = 0.2
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene(cells: int = 6):
    global here
    here = os.path.join(os.environ["SEEN"], f"{cells}-{os.uname().nodename}")
    return ls.Scene(cloths=[ls.Cloth(mesh=ls.grid(size=(0.2, 0.2), cells=(cells, cells)))])
def control(sim):
    open(here, "a").close()
    time.sleep(0.03)
"""


def digest_of(cells):
    mesh = ls.grid(size=(0.2, 0.2), cells=(cells, cells))
    euler = ls.SemiImplicitEuler(step=4e-3)
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh)]), integrator=euler, threads=1)
    for _ in range(50):
        sim.step()
    return sim.digest()


def test_a_sweep_on_two_hosts_survives_the_loss_of_a_worker(hosts, tmp_path):
    pytest.importorskip("distributed")
    scene, out, address = tmp_path / "scene.py", tmp_path / "out", "tcp://10.78.0.1:8786"
    scene.write_text(SLOW_SCENE)
    environment = {**ENVIRONMENT, "SEEN": str(tmp_path), "DASK_TEMPORARY_DIRECTORY": str(tmp_path)}
    started = []

    def start(node, *words):
        log = (tmp_path / f"log{len(started)}").open("w")
        command = [*hosts.inside(node), sys.executable, "-m", *words]
        started.append(
            subprocess.Popen(
                command, stdout=log, stderr=log, env=environment, start_new_session=True
            )
        )
        return started[-1]

    def wait_for(pattern, process):
        while not list(tmp_path.glob(pattern)):
            assert process.poll() is None, [p.read_text() for p in tmp_path.glob("log*")]
            time.sleep(0.02)

    try:
        start(1, "dask", "scheduler", "--host", "10.78.0.1", "--port", "8786", "--no-dashboard")
        workers = [
            start(node, "dask", "worker", address, "--nthreads", "1", "--no-dashboard")
            for node in (2, 3)
        ]
        words = ["-p", "cells=3:8:6", "--out", str(out), "--scheduler", address]
        sweep = start(1, "loomstone", "sweep", str(scene), *words)
        wait_for("*-node3", sweep)  # a run has begun on node3
        (lost,) = (path.name.split("-")[0] for path in tmp_path.glob("*-node3"))
        wait_for(f"out/cells-{lost}/checkpoint-0000000010.h5", sweep)
        os.killpg(workers[1].pid, signal.SIGKILL)
        assert sweep.wait(timeout=90) == 0, (tmp_path / "log3").read_text()
    finally:
        for process in reversed(started):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    print((tmp_path / "log3").read_text())
    with (out / "table.csv").open(newline="") as file:
        found = {int(row["cells"]): row["digest"] for row in csv.DictReader(file)}
    assert found == {cells: digest_of(cells) for cells in range(3, 9)}
    assert (tmp_path / f"{lost}-node2").exists(), "the other host has completed the lost run"
    log = (out / f"cells-{lost}" / "log.txt").read_text()
    assert log.count("frame 2/") == 1, "it has resumed it"
