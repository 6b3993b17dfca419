"""Compares digests of scenes on several numbers of ranks and threads, with the decompositions
`predicted`, `static` and `dynamic`.

    python tests/benchmarks/ranks/layouts.py [--scenes twist stack] [--layouts 1x1 2x2 7x1]

Starts itself once for each layout (ranks x threads), with mpirun if there are several ranks. Each
layout with several ranks runs a second time with LOOMSTONE_ROTATE_OWNERS, which gives the neighbour
lists to other ranks in every search. These second runs, and all runs of asynchronous scenes,
use only the decomposition `predicted`. Ends with exit status 1 if two digests of a scene differ.
"""

import argparse
import importlib
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Literal

import loomstone as ls
from loomstone import _core

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from smoke import AS_ROOT, SCENES, mpirun, parsed

# Parameters of each scene, and the duration of its run [s], which --share multiplies.
CASES = {
    "table_cloth": ({"triangles": 1800}, 0.3),
    "wave_bar": ({"triangles": 1800}, 0.25),
    "twist": ({"triangles": 1800}, 0.6),
    "stack": ({"triangles": 128}, 0.25),
    "dress": ({"triangles": 1500}, 0.08),
    "card": ({"triangles": 1500}, 0.3),
    "ribbon": ({}, 0.03),
}
LAYOUTS = ["1x1", "1x2", "2x1", "2x2", "3x1", "4x1", "7x1"]
ROTATE = "LOOMSTONE_ROTATE_OWNERS"


def simulate(given: argparse.Namespace) -> None:
    """Runs each scene in each decomposition that it uses. Rank 0 prints a line for each: names of
    scene and decomposition, digest, number of steps and largest number of contacts.
    """
    ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
    sys.path.insert(0, str(SCENES))
    for name in given.scenes:
        module = importlib.import_module(name)
        parameters, end = CASES[name]
        asynchronous = isinstance(getattr(module, "integrator", None), ls.Asynchronous)
        names: tuple[Literal["predicted", "static", "dynamic"], ...] = ("predicted",)
        if not asynchronous and ROTATE not in os.environ:
            names += ("static", "dynamic")
        for decomposition in names:
            sim = ls.Simulation(
                module.scene(**parameters),
                integrator=getattr(module, "integrator", None),
                threads=given.threads,
                communicator=ranks,
                decomposition=decomposition,
            )
            contacts = 0
            while sim.time < given.share * end:
                sim.step()
                contacts = max(contacts, sim.report.contacts.near)
            digest = sim.digest()
            if ranks.rank == 0:
                print(name, decomposition, digest, sim.step_index, contacts, flush=True)


def launch(layout: str, rotate: bool, given: argparse.Namespace) -> list[list[str]]:
    """Starts this file in a layout, and returns the words of each line that simulate() prints."""
    ranks, threads = layout.split("x")
    command = [sys.executable, __file__, "--threads", threads, "--share", str(given.share)]
    command += ["--scenes", *given.scenes]
    if int(ranks) > 1:
        command = [*mpirun(int(ranks)), *command]
    environment = {**os.environ, **AS_ROOT, "OMPI_MCA_mpi_yield_when_idle": "1"}
    if rotate:
        environment[ROTATE] = "1"
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{layout}: {done.stdout}{done.stderr}")
    return [line.split() for line in done.stdout.splitlines()]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--layouts", nargs="+", default=LAYOUTS, help="ranks x threads")
    parser.add_argument("--share", type=float, default=1.0, help="part of the time of each scene")
    parser.add_argument("--threads", type=int, help="simulates on this number of threads")
    given = parsed(parser, layouts=["1x1", "2x1"], scenes=["twist"], share=0.1)
    if given.threads is not None:
        return simulate(given)
    found: defaultdict[str, set[str]] = defaultdict(set)
    for layout in given.layouts:
        several = not layout.startswith("1x")
        for rotate in (False, True) if several else (False,):
            runs = launch(layout, rotate, given)
            for name, decomposition, digest, steps, contacts in runs:
                found[name].add(digest)
                how = f"{decomposition}, rotated" if rotate else decomposition
                print(f"{layout} {name}, {how}: {steps} steps, {contacts} contacts, {digest[:12]}")
    different = [name for name, digests in found.items() if len(digests) > 1]
    print("different digests:", ", ".join(different) or "none", flush=True)
    raise SystemExit(1 if different else 0)


if __name__ == "__main__":
    main()
