"""Trials of faults, for faults.py and the tests: kills, full disks, damaged files and threads.

A trial of the first three kinds depends on a seed. It returns its outcome in words, and raises an
AssertionError if a guarantee is broken.
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import loomstone as ls
import numpy as np

SCENE = """
import loomstone as ls
duration, rate = 2.0, 25.0  # 51 frames: files grow by blocks of 16
integrator = ls.SemiImplicitEuler(step=4e-3)
def scene():
    mesh = ls.grid(size=(0.3, 0.3), cells=(12, 12)).moved((0, 0, 0.105))
    obstacles = [ls.sphere(radius=0.1, subdivisions=2), ls.floor(height=-0.2)]
    return ls.Scene(cloths=[ls.Cloth(mesh=mesh)], obstacles=obstacles)
"""


def command(*arguments: Any, **options: Any) -> subprocess.CompletedProcess[str]:
    """Runs the command loomstone to its end, and returns its exit status and output."""
    return subprocess.run(
        [sys.executable, "-m", "loomstone", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=600,
        **options,
    )


class Whole:
    """A run without faults, stored in `place`/whole; runs with faults are compared with it."""

    def __init__(self, place: Path) -> None:
        self.scene, self.out = place / "scene.py", place / "whole"
        self.scene.write_text(SCENE)
        began = time.perf_counter()
        done = command("run", self.scene, "--out", self.out, "--threads", 1, "--overwrite")
        assert done.returncode == 0, done.stderr
        self.seconds = time.perf_counter() - began
        self.digest = digest(self.out)
        self.length = (self.out / "run.vtkhdf").stat().st_size

    def resumed(self, out: Path) -> str:
        """Resumes an interrupted run, or repeats it if it left no run file. Compares the completed
        run with this one.

        Returns a phrase for what the interruption left: all frames, some, none, or no run file.
        """
        begun = (out / "run.vtkhdf").exists()
        frames = len(ls.Run(out)) if begun else 0
        if begun:
            done = command("resume", out, "--threads", 1)
        else:
            done = command("run", self.scene, "--out", out, "--threads", 1)
        assert done.returncode == 0, done.stderr
        assert digest(out) == self.digest, "the resumed run ends in other bits"
        for a, b in zip(ls.Run(out), ls.Run(self.out), strict=True):
            assert np.array_equal(a.positions, b.positions)
        if not begun:
            return "nothing was written"
        return "all frames kept" if frames == 51 else "some kept" if frames else "no frame kept"


def digest(out: Path) -> str:
    return str(json.loads((out / "report.json").read_text())["digest"])


def killed(whole: Whole, out: Path, seed: int, kills: int = 0) -> str:
    """Kills a run at random moments, each time after starting or resuming it, then completes it.

    kills : number of kills; 0: one for even seeds, two for odd ones
    """
    chance = random.Random(seed)
    words: list[Any] = ["run", whole.scene, "--out", out, "--threads", 1]
    for _ in range(kills or 1 + seed % 2):
        process = subprocess.Popen(
            [sys.executable, "-m", "loomstone", *map(str, words)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        time.sleep(chance.uniform(0.0, whole.seconds))
        process.kill()
        process.wait()
        if (out / "run.vtkhdf").exists():
            words = ["resume", out, "--threads", 1]
    return whole.resumed(out)


def full_disk(whole: Whole, out: Path, seed: int) -> str:
    """Runs as on a full disk: no file can grow beyond a random size. Then completes the run."""
    largest = int(random.Random(seed).uniform(0.01, 1.0) * whole.length)

    def limit() -> None:
        # Makes writing fail as on a full disk instead of ending the process.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    done = command("run", whole.scene, "--out", out, "--threads", 1, preexec_fn=limit)
    fitted = done.returncode == 0
    if not fitted:
        assert done.returncode == 1 and "Traceback" not in done.stderr, done.stderr
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    return "it has fitted" if fitted else whole.resumed(out)


FULL_FILE_SYSTEM = """
mount -t tmpfs -o size="$1" loomstone-test "$2" && cd "$2" || exit 77
python=$3 scene=$4
"$python" -m loomstone run "$scene" --out out --threads 1 2> error
[ $? -eq 1 ] || [ -s out/report.json ] || exit 3
! grep -q Traceback error || exit 4
[ ! -s out/report.json ] || echo "the run has fitted"
mount -o remount,size=64m loomstone-test "$2"
if [ -e out/run.vtkhdf ]; then
  "$python" -m loomstone resume out --threads 1
else
  "$python" -m loomstone run "$scene" --out out --threads 1
fi || exit 5
cat out/report.json > "$5"
"""


def full_file_system(whole: Whole, out: Path, seed: int) -> str:
    """Runs in a tmpfs of random size, then completes the run with more space. Needs root."""
    out.mkdir(parents=True)
    size = int(random.Random(seed).uniform(0.05, 1.2) * whole.length)
    report = out.parent / f"report-{seed}.json"
    done = subprocess.run(
        ["unshare", "-m", "bash", "-c", FULL_FILE_SYSTEM, "full"]
        + [str(size), str(out), sys.executable, str(whole.scene), str(report)],
        capture_output=True,
        text=True,
        timeout=600,
    )
    if done.returncode in (1, 77) and not report.exists():
        return f"left out: {done.stderr.strip().splitlines()[-1]}"
    assert done.returncode == 0, f"status {done.returncode}: {done.stdout + done.stderr}"
    assert json.loads(report.read_text())["digest"] == whole.digest
    report.unlink()
    return "it has fitted" if "has fitted" in done.stdout else "resumed"


READERS = ("run", "bodies", "checkpoint", "obj", "ply")
FOREIGN = (
    b"",
    b"# vtk DataFile Version 3.0\n",
    b"\x89HDF\r\n\x1a\n",
    b"\x7fELF\x02\x01\x01",
    b"ply\n",
)


def originals(whole: Whole) -> dict[str, bytes]:
    """Returns the content of a valid file for each reader."""
    files = {
        "run": whole.out / "run.vtkhdf",
        "bodies": whole.out / "bodies.vtkhdf",
        "checkpoint": max(whole.out.glob("checkpoint-*")),
    }
    mesh = ls.grid(size=(0.1, 0.1), cells=(6, 6))
    for name in ("obj", "ply"):
        files[name] = whole.out.parent / f"mesh.{name}"
        ls.meshes.write(files[name], mesh)
    return {name: path.read_bytes() for name, path in files.items()}


def damaged(content: bytes, seed: int) -> bytes:
    """Returns the truncated content, random bytes after a header that may be empty, or the content
    with some bits flipped and perhaps a part overwritten.
    """
    chance = random.Random(seed)
    if seed % 10 == 0:
        return content[: chance.randrange(len(content))]
    if seed % 10 == 1:
        return FOREIGN[seed // 10 % len(FOREIGN)] + chance.randbytes(chance.randrange(2000))
    changed = bytearray(content)
    # Even seeds change only the first 20000 bytes.
    end = len(content) if seed % 2 else min(len(content), 20000)
    for _ in range(1 + seed % 5):
        changed[chance.randrange(end)] ^= 1 << chance.randrange(8)
    if seed % 10 == 3:
        at = chance.randrange(end)
        changed[at : at + 64] = chance.randbytes(len(changed[at : at + 64]))
    return bytes(changed)


def read_damaged(place: Path, reader: str, seed: int) -> str:
    """Reads a damaged copy of a file in `place`. Returns "read", or "refused" after an ls.Error.
    Its message must be one line. Other errors are raised. Damage to a checkpoint must be noticed.
    """
    content = damaged((place / reader).read_bytes(), seed)
    path = place / f"damaged-{reader}"
    path.mkdir(exist_ok=True)
    try:
        if reader in ("run", "bodies"):
            other = "bodies" if reader == "run" else "run"
            (path / f"{reader}.vtkhdf").write_bytes(content)
            (path / f"{other}.vtkhdf").write_bytes((place / other).read_bytes())
            run = ls.Run(path)
            for frame in run:
                assert frame.positions.shape[1] == 3
            assert isinstance(run.metadata, dict)
        elif reader == "checkpoint":
            (path / "c.h5").write_bytes(content)
            ls._core.read_checkpoint(str(path / "c.h5"))
            assert content == (place / reader).read_bytes(), "damage was not noticed"
        else:
            (path / f"m.{reader}").write_bytes(content)
            ls.meshes.read(path / f"m.{reader}")
    except ls.Error as error:
        assert "\n" not in str(error), str(error)
        return "refused"
    return "read"


def in_child(arguments: list[str], seeds: list[int], seconds: float) -> Iterator[tuple[int, str]]:
    """Runs trials in child processes with an address space of at most 4 GiB. A crash, or a trial
    that takes longer than `seconds` [s], ends only the child.

    Yields each seed with "read", "refused" or what went wrong. A child runs this file with
    `arguments`, followed by seeds, and prints a line for each seed.
    """

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    while seeds:
        with subprocess.Popen(
            [sys.executable, __file__, *arguments, *map(str, seeds)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=limit,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        ) as child:
            assert child.stdout and child.stderr
            timer = threading.Timer(seconds, child.kill)
            timer.start()
            for line in child.stdout:
                timer.cancel()
                timer = threading.Timer(seconds, child.kill)
                timer.start()
                yield seeds.pop(0), line.strip()
            timer.cancel()
            status, said = child.wait(), child.stderr.read()
        if seeds:  # the child died in the trial of seeds[0]
            cause = signal.Signals(-status).name if status < 0 else said.strip().splitlines()[-1:]
            yield seeds.pop(0), f"ended by {cause}"


def together(make: Callable[[int], ls.Simulation], steps: int) -> tuple[list[str], list[str]]:
    """Runs two simulations one after the other, then the same two concurrently in two threads.
    Returns two lists: the digests of the first two runs, and those of the concurrent ones.
    """

    def advanced(which: int) -> str:
        sim = make(which)
        for _ in range(steps):
            sim.step()
        return sim.digest()

    alone = [advanced(0), advanced(1)]
    found: list[str] = ["", ""]
    start = threading.Barrier(2)

    def work(which: int) -> None:
        start.wait()
        found[which] = advanced(which)

    threads = [threading.Thread(target=work, args=(which,)) for which in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return alone, found


if __name__ == "__main__":
    for number in sys.argv[3:]:
        try:
            print(read_damaged(Path(sys.argv[1]), sys.argv[2], int(number)), flush=True)
        except Exception as problem:
            text = f"{type(problem).__name__}: {problem}".replace("\n", " / ")
            print(f"wrong: {text}", flush=True)
