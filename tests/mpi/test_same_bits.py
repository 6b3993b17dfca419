"""The state of a simulation has the same bits on any number of threads and ranks, and the ranks
share the work evenly.
"""

import subprocess
import sys
from pathlib import Path

import pytest
from launcher import ENVIRONMENT, needs_mpirun, ranks

HERE, SCENES = Path(__file__).parent, Path(__file__).parents[2] / "scenes"


def digests(done):
    assert done.returncode == 0, done.stdout + done.stderr
    return {
        line.split()[1]: line.split()[2]
        for line in done.stdout.splitlines()
        if line.startswith("digest")
    }


@needs_mpirun
def test_200_steps_of_the_drape_end_in_the_same_bits_on_any_number_of_threads_and_ranks():
    alone = [
        sys.executable,
        str(HERE / "drape_digest.py"),
        str(SCENES / "drape.py"),
        "1",
        "2",
        "3",
        "7",
    ]
    found = digests(
        subprocess.run(alone, capture_output=True, text=True, timeout=240, env=ENVIRONMENT)
    )
    for n, threads in [(2, "1 2"), (3, "1")]:
        found |= digests(ranks(n, HERE / "drape_digest.py", SCENES / "drape.py", *threads.split()))
    assert set(found) == {"1x1", "1x2", "1x3", "1x7", "2x1", "2x2", "3x1"}
    assert len(set(found.values())) == 1


LIMITS = """
import sys
import loomstone as ls
from loomstone import _core
ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
soft = ls.ClothMaterial(weft_stiffness=50.0, warp_stiffness=50.0, shear_stiffness=20.0)
cloth = ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), cells=(16, 16)), material=soft, pins=[0, 16],
                 strain_limit=ls.StrainLimit(0.02, 0.02, 0.05))
ball = ls.sphere(radius=0.1, centre=(0, 0, -0.11))
# The four edges are pinned. The ball rises into the cloth and stretches it beyond its limits.
edges = [i for i in range(17 * 17) if i % 17 in (0, 16) or i // 17 in (0, 16)]
forced = ls.Scene(
    cloths=[cloth.replace(pins=edges)],
    obstacles=[ls.sphere(radius=0.1, times=[0.0, 0.08], positions=[(0, 0, -0.11), (0, 0, 0.04)])],
)
for method in (
    "gauss-seidel", "gauss-seidel-random", "jacobi", "edges", "in-solve", "in-newton", "forced"
):
    swept = method not in ("in-solve", "in-newton", "forced")
    options = ls.LimitOptions(method=method, in_solve=False) if swept else ls.LimitOptions()
    scene = ls.Scene(cloths=[cloth], obstacles=[ball], limits=options)
    if method == "forced":
        scene = forced
    euler = ls.BackwardEuler if method == "in-newton" else ls.SemiImplicitEuler
    sim = ls.Simulation(scene, integrator=euler(step=2e-3), threads=1, communicator=ranks)
    sweeps = 0
    for _ in range(10 if method == "in-newton" else 40):
        sim.step()
        sweeps += sim.report.limits.sweeps
    assert not swept or sweeps > 80, "limits act"
    assert method != "forced" or len(sim.broken_limits) > 20, "the ball leaves limits no room"
    digest = sim.digest()
    number = int(digest[:15], 16)
    assert ranks.maximum(number) == number == -ranks.maximum(-number), "all ranks agree"
    if ranks.rank == 0:
        print(f"digest {method} {digest}", flush=True)
"""


@needs_mpirun
def test_strain_limits_end_in_the_same_bits_on_one_and_two_ranks(tmp_path):
    (tmp_path / "limits.py").write_text(LIMITS)
    alone = digests(
        subprocess.run(
            [sys.executable, str(tmp_path / "limits.py")],
            capture_output=True,
            text=True,
            timeout=120,
            env=ENVIRONMENT,
        )
    )
    assert len(alone) == 7 and digests(ranks(2, tmp_path / "limits.py")) == alone


ASYNCHRONOUS = """
import loomstone as ls
from loomstone import _core
ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
cloth = ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), cells=(16, 16)), pins=[0, 16])
ball = ls.sphere(radius=0.1, centre=(0, 0, -0.11))
scene = ls.Scene(cloths=[cloth], obstacles=[ball], air=ls.Air(normal_drag=1.0))
for schedule in ("nested", "queue"):
    steps = ls.Asynchronous(schedule=schedule)
    sim = ls.Simulation(scene, integrator=steps, threads=1, communicator=ranks)
    for _ in range(60):
        sim.step()
    digest = sim.digest()
    number = int(digest[:15], 16)
    assert ranks.maximum(number) == number == -ranks.maximum(-number), "all ranks agree"
    if ranks.rank == 0:
        print(f"digest {schedule} {digest}", flush=True)
"""


@needs_mpirun
def test_asynchronous_steps_end_in_the_same_bits_on_one_and_two_ranks(tmp_path):
    program = tmp_path / "asynchronous.py"
    program.write_text(ASYNCHRONOUS)
    alone = digests(
        subprocess.run(
            [sys.executable, str(program)],
            capture_output=True,
            text=True,
            timeout=120,
            env=ENVIRONMENT,
        )
    )
    assert len(alone) == 2 and digests(ranks(2, program)) == alone


COLLISIONS = """
import sys
import loomstone as ls
import numpy as np
from loomstone import _core
ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
sheets = []
for i in range(2):
    mesh = ls.grid(size=(0.2, 0.2), cells=(9 + i, 9 + i)).moved((0.0, 0.0, 0.102 + 0.004 * i))
    fall = np.tile((0.3, 0.0, -3.0), (len(mesh.vertices), 1))
    sheets.append(ls.Cloth(name=f"sheet {i}", mesh=mesh, velocities=fall))
box = ls.RigidBody(mesh=ls.meshes.box(size=(0.03, 0.03, 0.03)), density=300, position=(0, 0, 0.13))
for response, steps in (("implicit", ls.SemiImplicitEuler(step=8e-3)),
                        ("impulse", ls.SemiImplicitEuler(step=8e-3)),
                        ("implicit", ls.Asynchronous(step=2e-3))):
    scene = ls.Scene(cloths=sheets, obstacles=[ls.sphere(radius=0.1)], bodies=[box],
                     response=response)
    for threads in map(int, sys.argv[1:]):
        sim = ls.Simulation(scene, integrator=steps, threads=threads, communicator=ranks)
        impacts = 0
        for _ in range(8):
            sim.step()
            impacts += sim.report.contacts.impacts
        assert impacts > 0, "certification acts"
        digest = sim.digest()
        number = int(digest[:15], 16)
        assert ranks.maximum(number) == number == -ranks.maximum(-number), "all ranks agree"
        if ranks.rank == 0:
            name = f"{response}-{type(steps).__name__}-{ranks.size}x{threads}"
            print(f"digest {name} {digest}", flush=True)
"""


@needs_mpirun
def test_collisions_end_in_the_same_bits_if_every_step_gives_them_to_other_ranks(
    tmp_path, monkeypatch
):
    program = tmp_path / "collisions.py"
    program.write_text(COLLISIONS)
    alone = [sys.executable, str(program), "1", "2"]
    found = digests(
        subprocess.run(alone, capture_output=True, text=True, timeout=240, env=ENVIRONMENT)
    )
    monkeypatch.setitem(ENVIRONMENT, "LOOMSTONE_ROTATE_OWNERS", "1")
    for n, threads in [(2, "1 2"), (3, "1"), (4, "1"), (7, "1")]:
        found |= digests(ranks(n, program, *threads.split()))
    assert len(found) == 3 * 7
    for scene in {name.rsplit("-", 1)[0] for name in found}:
        same = {digest for name, digest in found.items() if name.startswith(scene)}
        assert len(same) == 1, scene


WORK = """
import sys
import loomstone as ls
from loomstone import _core
ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
limit = ls.StrainLimit(0.05, 0.05, 0.05) if LIMITED else None
cloth = ls.Cloth(mesh=ls.grid(triangles=14450), pins=[0], strain_limit=limit)
scene, euler = ls.Scene(cloths=[cloth], collisions=False), ls.SemiImplicitEuler(step=4e-3)
sim = ls.Simulation(scene, integrator=euler, threads=1, communicator=ranks)
for _ in range(STEPS):
    sim.step()
first, end = sim.owned_rows
with open(sys.argv[1] + str(sim.rank), "w") as file:
    print(first, end, sim.loop_iterations, sim.report.solver.linear_iterations, file=file)
"""


@needs_mpirun
@pytest.mark.parametrize("limited", [False, True])
def test_a_rank_computes_only_the_rows_it_owns(tmp_path, limited):
    steps = 5
    (tmp_path / "work.py").write_text(
        WORK.replace("STEPS", str(steps)).replace("LIMITED", str(limited))
    )

    def work(n):
        done = ranks(n, tmp_path / "work.py", tmp_path / f"{n}-")
        assert done.returncode == 0, done.stdout + done.stderr
        return [
            tuple(map(int, (tmp_path / f"{n}-{rank}").read_text().split())) for rank in range(n)
        ]

    ((first, n_rows, whole, iterations),) = work(1)
    assert first == 0 and iterations > 20
    # Every rank copies one vector and moves all vertices in each step, in two loops over all rows.
    by_all = 2 * steps * n_rows
    if limited:  # sums of moved distances, in blocks of 128 rows
        by_all += steps * ((n_rows + 127) // 128)
    for n in (2, 3):
        shares = work(n)
        # Each row has one owner.
        assert [share[0] for share in shares] + [n_rows] == [0] + [share[1] for share in shares]
        assert {share[3] for share in shares} == {iterations}
        for start, end, done, _ in shares:
            assert end - start <= 1.2 * n_rows / n
            # Triangles at the boundary between two ranks are computed by both. The factor 1.2
            # allows for this.
            assert done - by_all <= 1.2 * (whole - by_all) / n


DECOMPOSED = """
import loomstone as ls
from loomstone import _core
ranks = _core.mpi_communicator() if _core.launched_by_mpi() else _core.single_communicator()
threads = int(THREADS)
sheet = ls.grid(size=(0.3, 0.3), cells=(20, 20))
crumpled = ls.Cloth(mesh=sheet.moved((0.02, 0.01, 0.012)), pins=[])
cloth = ls.Cloth(mesh=sheet, pins=[0])
cube = ls.RigidBody(mesh=ls.meshes.box(size=(0.05, 0.05, 0.05)), position=(0.0, 0.0, 0.05),
                    density=500.0, velocity=(0.0, 0.0, -4.0))
scene = ls.Scene(cloths=[cloth, crumpled], bodies=[cube],
                 obstacles=[ls.sphere(radius=0.06, centre=(0.0, 0.0, -0.062))])
for name in ("static", "dynamic", "predicted"):
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=threads,
                        communicator=ranks, decomposition=name)
    assert sim.decomposition == name
    impacts = 0
    for i in range(30):
        sim.step()
        impacts += sim.report.contacts.impacts
        # Only rank 0 calls frame_at(), which must not wait for the other ranks.
        if ranks.rank == 0 and i % 10 == 0:
            sim.frame_at(sim.time - 1e-3)
    assert impacts > 0 and sim.report.contacts.near > 50
    digest = sim.digest()
    number = int(digest[:15], 16)
    assert ranks.maximum(number) == number == -ranks.maximum(-number), "all ranks agree"
    if ranks.rank == 0:
        print(f"digest {name} {digest}", flush=True)
"""


@needs_mpirun
def test_all_decompositions_end_in_the_same_bits_on_any_number_of_threads_and_ranks(tmp_path):
    found = []
    for n, threads in [(1, 1), (1, 2), (2, 1), (4, 1), (2, 2)]:
        program = tmp_path / f"decomposed{threads}.py"
        program.write_text(DECOMPOSED.replace("THREADS", str(threads)))
        found.append(digests(ranks(n, program)))
    assert set(found[0]) == {"static", "dynamic", "predicted"}
    assert {digest for each in found for digest in each.values()} == {found[0]["predicted"]}
