"""Simulations and magnetic fields have the same bits with every instruction set.

The environment variable LOOMSTONE_INSTRUCTIONS restricts the sets that may be chosen.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# Program that runs kernels of magnetics, cloth, linear solvers and collision detection, and prints
# the hash of each result. Fields are evaluated inside their sources, near them and far away.
WORK = """
import hashlib
import numpy as np
import loomstone as ls
M = ls.magnetics
rng = np.random.default_rng(1)

def tell(name, *arrays):
    assert all(np.isfinite(a).all() for a in arrays)
    content = b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)
    print(name, hashlib.sha256(content).hexdigest())

j, points = (0.3, -0.5, 0.8), rng.normal(size=(501, 3)) * np.array([[0.02]] * 400 + [[0.2]] * 101)
moments, places = rng.normal(size=(3000, 3)), 0.01 * rng.normal(size=(3000, 3))
ball, iron = ls.meshes.sphere(radius=0.01, subdivisions=1), {"susceptibility": 100.0}
magnet = M.cuboid(size=(0.02, 0.01, 0.015), polarization=j)
bodies = {
    "cuboid": magnet,
    "ring": M.cylinder(radius=0.01, height=0.013, inner_radius=0.004, polarization=j),
    "mesh": M.mesh(ball, polarization=j),
    "sphere": M.sphere(radius=0.01, polarization=j),
    "dipoles": M.dipoles(places[:50], moments[:50]),
}
currents = {
    "loop": M.loop(radius=0.01, current=3.0),
    "solenoid": M.solenoid(radius=0.01, length=0.02, turns=50, current=1.0),
    "polyline": M.polyline([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0, 0]], current=2.0),
}
for name, body in (bodies | currents).items():
    tell(name, M.field(body, points), M.gradient(body, points))
for name, body in bodies.items():
    tell(name + " potential", M.potential(body, points))
for turn in ((1, 0, 0, 0), (0.8, 0.1, 0.5, 0.3)):
    other = M.cuboid(size=(0.01, 0.01, 0.01), polarization=j).at((0.03, 0.002, 0.01), turn)
    found = M.force(on=other, by=magnet)
    tell("force", found.force, found.torque)
tell("pairs", *M.dipole_forces(places[:300], moments[:300]))
tell("tree", *M.dipole_forces(places, moments, tolerance=1e-4))
ones = np.ones(40)
balls = {"radii": 0.01 * ones, "susceptibilities": ones, "applied": moments[:40]}
tell("balls", M.induced_moments(0.2 * rng.normal(size=(40, 3)), **balls))
soft = {"cuboid": M.soft_cuboid(size=(0.01, 0.01, 0.01), cells=8, **iron),
        "ball": M.soft_sphere(radius=0.01, **iron),
        "mesh": M.soft_mesh(ball, panels=100, **iron),
        "cylinder": M.soft_cylinder(radius=0.005, height=0.01, **iron)}
for name, body in soft.items():
    (pulled,) = M.induce(body.at((0.0, 0.0, 0.03)), by=magnet).bodies
    tell("soft " + name, M.field(pulled, points), M.gradient(pulled, points))

for method in ("gauss-seidel", "jacobi", "in-solve"):
    apart = {} if method == "in-solve" else {"method": method, "in_solve": False}
    limits = ls.LimitOptions(**apart)
    mesh = ls.grid(size=(0.2, 0.2), cells=(12, 12)).moved((0, 0, 0.0525))
    cloth = ls.Cloth(mesh=mesh, pins=[0], strain_limit=ls.StrainLimit(0.005, 0.005, 0.01))
    scene = ls.Scene(cloths=[cloth], obstacles=[ls.sphere(radius=0.05)], limits=limits)
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3))
    for _ in range(40):
        sim.step()
    assert sim.report.contacts.near > 0
    print("cloth", method, sim.digest())

for limiting, schedule in (("potential", "nested"), ("impulses", "nested"), ("none", "nested"),
                           ("potential", "queue"), ("impulses", "refill")):
    mesh = ls.grid(size=(0.2, 0.2), cells=(12, 12)).moved((0, 0, 0.0525))
    viscous = ls.ClothMaterial(viscosity_shear=1e-4, bending_damping=1e-3)
    limit = ls.StrainLimit(0.005, 0.005, 0.01)
    cloth = ls.Cloth(name="cloth", mesh=mesh, pins=[0], strain_limit=limit, material=viscous)
    box = ls.RigidBody(name="box", mesh=ls.meshes.box(size=(0.02, 0.02, 0.02)), shape="box",
                       position=(0.1, 0.1, 0.0415))
    tied = ls.Attachment(cloth="cloth", body="box", vertices=[168])
    scene = ls.Scene(cloths=[cloth], bodies=[box], attachments=[tied],
                     obstacles=[ls.sphere(radius=0.05)])
    sim = ls.Simulation(scene, integrator=ls.Asynchronous(limiting=limiting, schedule=schedule))
    for _ in range(20):
        sim.step()
    assert sim.report.contacts.near > 0
    print("asynchronous", limiting, schedule, sim.digest())

def layers(solver, tolerance, bending):
    meshes = [ls.grid(size=(0.2, 0.2), cells=(11 + i, 12)).moved((0, 0, 0.0515 + 0.002 * i))
              for i in range(2)]
    cloths = [ls.Cloth(mesh=mesh) for mesh in meshes]
    integrator = ls.SemiImplicitEuler(
        step=4e-3, linear_solver=solver, tolerance=tolerance, bending=bending)
    sim = ls.Simulation(ls.Scene(cloths=cloths, obstacles=[ls.sphere(radius=0.05)]),
                        integrator=integrator)
    for _ in range(20):
        sim.step()
    assert sim.report.contacts.near > 0
    return sim.digest()

# A tolerance below the accuracy of single precision requires double precision.
for solver in ("pcg", "block-jacobi", "gauss-seidel"):
    for tolerance in (1e-4, 1e-11):
        print("layers", solver, layers(solver, tolerance, "implicit"))
print("layers, explicit bending", layers("pcg", 1e-4, "explicit"))

mesh = ls.grid(size=(1, 1), cells=(20, 20))
crumpled = [mesh.vertices + 0.04 * rng.normal(size=mesh.vertices.shape) for _ in range(2)]
detector = ls.collision.Detector(mesh.triangles, threads=1)
candidates = detector.candidates(*crumpled)
assert min(map(len, candidates)) > 1000
tell("candidates", *candidates)
found = detector.collisions(*crumpled)
assert len(found) > 100
tell("collisions", found.vertex_face, found.vertex_face_time, found.edge_edge, found.edge_edge_time)
"""


def lines_with(instructions: str) -> list[str]:
    environment = {**os.environ, "LOOMSTONE_INSTRUCTIONS": instructions}
    done = subprocess.run(
        [sys.executable, "-c", WORK],
        capture_output=True,
        text=True,
        timeout=120,
        env=environment,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def of_the_oldest() -> list[str]:
    return lines_with("x86-64")


@pytest.mark.parametrize("instructions", ["x86-64-v3", "x86-64-v4"])
def test_wider_instructions_give_the_same_bits(of_the_oldest, instructions):
    assert len(of_the_oldest) == 39
    assert lines_with(instructions) == of_the_oldest


def test_an_empty_variable_restricts_nothing():
    environment = {**os.environ, "LOOMSTONE_INSTRUCTIONS": ""}
    subprocess.run(
        [sys.executable, "-c", "import loomstone"], check=True, timeout=60, env=environment
    )


def test_unknown_instructions_are_refused():
    environment = {**os.environ, "LOOMSTONE_INSTRUCTIONS": "avx2"}
    done = subprocess.run(
        [sys.executable, "-c", "import loomstone"],
        capture_output=True,
        text=True,
        timeout=60,
        env=environment,
    )
    assert done.returncode != 0
    assert (
        "LOOMSTONE_INSTRUCTIONS must be x86-64, x86-64-v3 or x86-64-v4, got 'avx2'" in done.stderr
    )


def test_kernels_are_compiled_for_instruction_sets_only_by_the_dispatch_that_is_restricted():
    """For a function compiled with target_clones or ifunc, the loader would choose the instruction
    set, and it would ignore LOOMSTONE_INSTRUCTIONS.
    """
    sources = [p for kind in ("h", "cpp") for p in (ROOT / "core").rglob(f"*.{kind}")]
    text = {path.relative_to(ROOT).as_posix(): path.read_text() for path in sources}
    chosen_by_loader = [
        name for name, code in text.items() if re.search(r"target_clones|ifunc", code)
    ]
    assert not chosen_by_loader
    targets = {name for name, code in text.items() if re.search(r"\btarget\(|cpu_supports", code)}
    assert targets == {"core/base/simd.h", "core/base/simd.cpp"}
