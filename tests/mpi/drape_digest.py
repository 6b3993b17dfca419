"""Prints the hash of the state after 200 steps of a scene, for each given number of threads.

All ranks must hold the same state; rank 0 prints. Arguments: scene file, numbers of threads.
"""

import sys
from pathlib import Path

import loomstone as ls
from loomstone import _core
from loomstone.runs.scene_file import SceneFile

ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
for threads in sys.argv[2:]:
    file = SceneFile.open(Path(sys.argv[1]), {"triangles": 800})
    sim = ls.Simulation(
        file.scene(), integrator=file.integrator, threads=int(threads), communicator=ranks
    )
    for _ in range(200):
        sim.step()
    assert sim.report.contacts.near > 50, "the cloth lies on the sphere"
    digest = sim.digest()
    number = int(digest[:15], 16)
    assert ranks.maximum(number) == number == -ranks.maximum(-number), (
        "all ranks hold the same state"
    )
    if ranks.rank == 0:
        print(f"digest {ranks.size}x{threads} {digest}", flush=True)
