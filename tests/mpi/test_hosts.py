"""A run on three hosts loses one of them and continues on two. The hosts are network namespaces of
this machine with addresses of their own.
"""

import subprocess
import time

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
    # With a cut link, the last rank stops in step 25, so that the run does not end before the cut.
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
