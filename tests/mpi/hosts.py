"""Several hosts on one machine: network namespaces with addresses and host names of their own."""

import itertools
import os
import shutil
import subprocess
import sys

from launcher import ENVIRONMENT

# After 4 s, mpirun notices that a host does not answer, unless a time-out ends the job earlier.
KEEPALIVE = ("oob_tcp_keepalive_time 2", "oob_tcp_keepalive_intvl 1", "oob_tcp_keepalive_probes 2")
_numbers = itertools.count(1)


def call(*words):
    subprocess.run(list(words), check=True, capture_output=True, text=True)


class Hosts:
    """Hosts node1, node2, ... that are connected by a bridge and share the file system.

    Raises CalledProcessError or FileNotFoundError if the machine does not permit such hosts.
    """

    def __init__(self, directory, n=3):
        self.n, self._directory = n, directory
        self._prefix = f"ls{os.getpid()}x{next(_numbers)}"
        self._switch = f"{self._prefix}s"
        try:
            call("ip", "netns", "add", self._switch)
            call("ip", "-n", self._switch, "link", "add", "bridge", "type", "bridge")
            call("ip", "-n", self._switch, "link", "set", "bridge", "up")
            for node in range(1, n + 1):
                self._add(node)
            call(*self.inside(1), "true")
        except BaseException:
            self.remove()
            raise
        agent = directory / "agent"
        agent.write_text(
            "#!/bin/sh\n# Starts a command on a host, as ssh does. Arguments: address, command\n"
            "node=${1##*.}; shift\nexec nsenter --net=/run/netns/" + self._prefix + "n$node "
            'unshare --uts /bin/sh -c "hostname node$node; $*"\n'
        )
        agent.chmod(0o755)
        self._agent = agent

    def _add(self, node):
        name, port = self.name(node), f"port{node}"
        call("ip", "netns", "add", name)
        call("ip", "-n", name, "link", "set", "lo", "up")
        pair = ("peer", "name", port, "netns", self._switch)
        call("ip", "link", "add", "eth0", "netns", name, "type", "veth", *pair)
        call("ip", "-n", self._switch, "link", "set", port, "master", "bridge", "up")
        call("ip", "-n", name, "addr", "add", f"10.78.0.{node}/24", "dev", "eth0")
        call("ip", "-n", name, "link", "set", "eth0", "up")

    def name(self, node):
        return f"{self._prefix}n{node}"

    def inside(self, node):
        """Returns words to prepend to a command, to run it on a host without an extra process."""
        enter = ["nsenter", f"--net=/run/netns/{self.name(node)}", "unshare", "--uts"]
        return [*enter, "/bin/sh", "-c", f'hostname node{node}; exec "$0" "$@"']

    def cut(self, node):
        """Cuts the link of a host to the others."""
        call("ip", "-n", self._switch, "link", "set", f"port{node}", "down")

    def command(self, n):
        """Writes a host file. Returns the command that runs Python on n hosts, one rank on each."""
        (self._directory / f"hosts{n}").write_text(
            "".join(f"10.78.0.{node} slots=1\n" for node in range(1, n + 1))
        )
        options = (
            *KEEPALIVE,
            "plm rsh",
            f"plm_rsh_agent {self._agent}",
            "btl tcp,self",
            "btl_tcp_if_include 10.78.0.0/24",
            "oob_tcp_if_include 10.78.0.0/24",
        )
        settings = [word for option in options for word in ("--mca", *option.split())]
        forwarded = ["OMP_WAIT_POLICY", "LOOMSTONE_MPI_TIMEOUT", "PATH", "RESUMED"]
        settings += [word for name in forwarded if name in ENVIRONMENT for word in ("-x", name)]
        hostfile = ["--hostfile", str(self._directory / f"hosts{n}")]
        launcher = ["mpirun", "-n", str(n), *hostfile, "--bind-to", "none", *settings]
        return [*self.inside(1), *launcher, sys.executable]

    def remove(self):
        if shutil.which("ip"):
            for name in (*map(self.name, range(1, self.n + 1)), self._switch):
                subprocess.run(["ip", "netns", "del", name], capture_output=True)
