"""Strain limits from Python: on arrays and within a step."""

import csv
from pathlib import Path

import loomstone as ls
import numpy as np
import pytest
from loomstone.runs import progress_lines
from loomstone.runs.scene_file import SceneFile

SCENES = Path(__file__).parents[3] / "scenes"

LIMIT = ls.StrainLimit(0.05, 0.05, 0.1)
METHODS = ["gauss-seidel", "gauss-seidel-random", "jacobi", "edges"]


def hanging(method="gauss-seidel", limit=LIMIT, in_solve=False, **options):
    """Soft cloth pinned at two corners. Without a limit, it would stretch far beyond LIMIT."""
    material = ls.ClothMaterial(weft_stiffness=50.0, warp_stiffness=50.0, shear_stiffness=20.0)
    cloth = ls.Cloth(
        mesh=ls.grid(size=(0.5, 0.5), cells=(12, 12)),
        material=material,
        pins=[0, 12],
        strain_limit=limit,
    )
    return ls.Scene(
        cloths=[cloth],
        collisions=False,
        limits=ls.LimitOptions(method=method, in_solve=in_solve, **options),
    )


def simulate(scene, steps=100, threads=1):
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3), threads=threads)
    reports = []
    for _ in range(steps):
        sim.step()
        reports.append(sim.report.numbers())
    return sim, reports


def test_strain_of_arrays_is_u_minus_i_and_limits_hold_within_the_tolerance():
    mesh = ls.grid(size=(1.0, 1.0), cells=(8, 8))
    pulled = np.asarray(mesh.vertices) * (1.3, 1.1, 1.0)
    np.testing.assert_allclose(
        ls.limits.strain(pulled, mesh), np.tile((0.3, 0.1, 0.0), (128, 1)), atol=1e-13
    )
    before = pulled.copy()
    for method in METHODS[:3]:
        points, report = ls.limits.limit(
            pulled, mesh, ls.StrainLimit(0.1, 0.05, 0.2), method=method, max_sweeps=5000
        )
        assert report.beyond == 0 and max(report.excess) <= 0.002 and report.evaluations >= 128
        strain = ls.limits.strain(points, mesh)
        assert (strain <= np.array((0.102, 0.052, 0.202))).all() and strain[:, 2].min() >= -0.202
        np.testing.assert_allclose(points.mean(axis=0), before.mean(axis=0), atol=0.02)
    assert (pulled == before).all(), "what was given is not changed"


def test_fixed_points_do_not_move_and_heavy_points_hardly_move():
    mesh = ls.grid(size=(1.0, 1.0), cells=(4, 4))
    pulled = np.asarray(mesh.vertices) * (1.2, 1.0, 1.0)
    fixed = [0, 5, 10, 15, 20]
    points, _ = ls.limits.limit(pulled, mesh, ls.StrainLimit(0.05, 0.05, 0.1), fixed=fixed)
    assert (points[fixed] == pulled[fixed]).all() and (points != pulled).any()
    masses = np.where(np.arange(25) % 5 == 0, 1e6, 1.0)
    heavy, _ = ls.limits.limit(pulled, mesh, ls.StrainLimit(0.05, 0.05, 0.1), masses=masses)
    np.testing.assert_allclose(heavy[fixed], pulled[fixed], atol=1e-4)


@pytest.mark.parametrize(
    "mistake, said",
    [
        (lambda: ls.StrainLimit(-0.1, 0.1, 0.1), "weft must be >= 0"),
        (lambda: ls.StrainLimit(0.1, float("nan"), 0.1), "warp must be >= 0 .* got nan"),
        (lambda: ls.StrainLimit(0.1, 0.1, 0.1, weft_min=0.2), r"weft_min must be in \[-1, 0\]"),
        (lambda: ls.StrainLimit(0.1, 0.1, 0.1, shear_min=0.2), "shear_min must be <= 0"),
        (lambda: ls.LimitOptions(strain_rate=-1), "strain_rate must be >= 0"),
        (lambda: ls.LimitOptions(tolerance=0), "tolerance must be > 0"),
        (lambda: simulate(hanging("newton")), "LimitOptions.method must be one of gauss-seidel"),
        (
            lambda: ls.limits.limit(
                np.zeros((3, 3)), ls.grid(cells=(2, 2)), ls.StrainLimit(0.1, 0.1, 0.1)
            ),
            "points must have shape",
        ),
        (
            lambda: ls.limits.limit(
                np.full((9, 3), np.nan), ls.grid(cells=(2, 2)), ls.StrainLimit(0.1)
            ),
            "points must be finite",
        ),
        (
            lambda: ls.limits.limit(
                np.zeros((9, 3)), ls.grid(cells=(2, 2)), ls.StrainLimit(0.1), fixed=[9]
            ),
            "fixed must be vertex",
        ),
        (
            lambda: ls.limits.limit(
                np.zeros((9, 3)), ls.grid(cells=(2, 2)), ls.StrainLimit(0.1), masses=[0] * 9
            ),
            "masses must be",
        ),
        (
            lambda: ls.limits.strain(np.zeros((9, 3)), ls.grid(cells=(2, 2)), rest="pattern"),
            "rest must be one of uv | mesh",
        ),
    ],
)
def test_a_mistake_is_one_clear_error(mistake, said):
    with pytest.raises(ls.InvalidInput, match=said):
        mistake()


def test_limits_inside_the_solve_leave_no_work_to_sweeps():
    _, reports = simulate(hanging(in_solve=True))
    _, swept = simulate(hanging(max_sweeps=20000))
    assert (
        sum(r["limits.sweeps"] for r in reports)
        < 1.2 * len(reports)
        < sum(r["limits.sweeps"] for r in swept) / 4
    )
    assert max(r["limits.excess"] for r in reports) <= 0.002


@pytest.mark.parametrize("method", METHODS)
def test_a_step_keeps_limits_that_it_breaks_without_them(method):
    free, _ = simulate(hanging(limit=None))
    scene = hanging(method, max_sweeps=20000)
    mesh = scene.cloths[0].mesh
    most = ls.limits.strain(free.positions, mesh).max()
    sim, reports = simulate(scene)
    strain = ls.limits.strain(sim.positions, mesh)
    assert most > 0.2, "without limits it strains four times as far"
    assert (
        sum(r["limits.sweeps"] for r in reports) > 100
        and sum(r["seconds.limit"] for r in reports) > 0
    )
    last = reports[-1]
    if method != "edges":
        assert max(r["limits.excess"] for r in reports) <= 0.002
        assert last["limits.beyond"] == 0 and strain.max() <= 0.102 and strain[:, :2].max() <= 0.052
    np.testing.assert_allclose(
        max(last["limits.weft_excess"], 0), max(strain[:, 0].max() - 0.05, 0), atol=1e-12
    )
    pins = np.asarray(mesh.vertices)[[0, 12]]
    assert (sim.positions[[0, 12]] == pins).all(), "pins do not move by one bit"


def test_limits_that_pins_make_impossible_are_reported_with_the_element():
    mesh = ls.grid(size=(0.5, 0.5), cells=(6, 6))
    x = np.asarray(mesh.vertices)
    sides = [int(i) for i in np.flatnonzero(abs(x[:, 0]) > 0.2499)]
    ends = [x[sides], x[sides] * (1.3, 1, 1)]
    cloth = ls.Cloth(
        mesh=mesh,
        pins=sides,
        script_times=[0.0, 0.1],
        script_positions=np.concatenate(ends),
        strain_limit=ls.StrainLimit(0.1, 0.1, 0.1),
    )
    _, reports = simulate(ls.Scene(cloths=[cloth], collisions=False), steps=60)
    assert reports[5]["limits.beyond"] == 0 and reports[5]["limits.worst_element"] == -1
    assert (
        reports[-1]["limits.beyond"] > 36
        and reports[-1]["limits.weft_excess"] > 0.19
        and 0 <= reports[-1]["limits.worst_element"] < 72
    )


def test_pins_that_shear_cloth_beyond_its_limits_stretch_it_only_as_far_as_they_must():
    mesh = ls.grid(size=(0.3, 0.3), cells=(16, 16))
    x = np.asarray(mesh.vertices)
    sides = np.flatnonzero(abs(x[:, 0]) > 0.15 - 1e-6)
    ends = [x[sides], x[sides] + np.where(x[sides, :1] > 0, (0, 0.04, 0), 0)]
    cloth = ls.Cloth(
        mesh=mesh,
        material=ls.ClothMaterial(density=0.15, shear_stiffness=75.0),
        pins=list(sides),
        script_times=[0.0, 0.1],
        script_positions=np.concatenate(ends),
        strain_limit=ls.StrainLimit(0.01, 0.01, 0.02),
    )
    sim = ls.Simulation(ls.Scene(cloths=[cloth]), threads=1)
    stretch = 1.0
    while sim.time < 0.1:
        sim.step()
        stretch = max(stretch, float(sim.frame().stretch.max()))
    # Simple shear of the whole cloth by 0.04 / 0.3 stretches it by a factor of 1.069. The sweeps
    # must not concentrate strain in single triangles.
    assert stretch < 1.15
    # The pins of one side move at 0.4 m/s. At this speed, the kinetic energy of the cloth (13.5 g)
    # would be 1 mJ.
    assert sim.report.account.largest_kinetic < 0.02
    assert sim.step_index < 60


@pytest.mark.parametrize("method", METHODS)
def test_threads_rebuilt_stages_and_checkpoints_change_no_bit(method):
    scene = hanging(method, max_sweeps=20)
    one, _ = simulate(scene, 40)
    assert simulate(scene, 40, threads=3)[0].digest() == one.digest()
    again, _ = simulate(scene, 20)
    saved = again.checkpoint()
    other = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3), threads=1)
    other.restore(saved)
    for _ in range(20):
        other.step()
    assert other.digest() == one.digest()


def test_edge_limits_apply_to_the_cloth_that_has_them_and_to_no_other():
    edges = hanging(limit=ls.StrainLimit(edge=0.05)).cloths[0].replace(name="edges")
    other = hanging().cloths[0]
    other = other.replace(mesh=other.mesh.moved((2.0, 0.0, 0.0)), name="elements")
    options = ls.LimitOptions(max_sweeps=5000)
    both, _ = simulate(ls.Scene(cloths=[edges, other], collisions=False, limits=options))
    x, mesh = both.positions, edges.mesh
    n = len(x) // 2
    pairs = np.asarray(mesh.triangles)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    rest = np.asarray(mesh.vertices)
    length = [np.linalg.norm(p[pairs[:, 0]] - p[pairs[:, 1]], axis=1) for p in (rest, x[:n])]
    assert (length[1] <= 1.052001 * length[0]).all()
    assert (length[1] > 1.04 * length[0]).any(), "the bound is reached"
    assert (ls.limits.strain(x[n:], other.mesh) <= (0.052, 0.052, 0.102)).all()


def test_the_columns_of_the_swing_differ_as_their_limits_do():
    file = SceneFile.open(SCENES / "swing_limits.py", {"triangles": 200})
    sim = ls.Simulation(file.scene(), integrator=file.integrator, threads=1)
    last, column = list(sim.frames(duration=0.6, rate=25))[-1], sim.topology.cloth_of_triangle
    mean = [abs(last.strain[column == i]).mean(axis=0) for i in range(7)]
    assert mean[6].max() > 2 * mean[0].max(), (
        "without limits it strains further than with tight ones"
    )
    assert mean[1][2] > 2 * mean[0][2], "loose shear is used"
    assert mean[2][1] > mean[3][1] and mean[3][0] > mean[2][0], "swapped limits swap weft and warp"


def test_broken_limits_are_named_the_worst_first_and_in_a_table(tmp_path, capsys):
    mesh = ls.grid(size=(0.5, 0.5), cells=(6, 6))
    x = np.asarray(mesh.vertices)
    sides = [int(i) for i in np.flatnonzero(abs(x[:, 0]) > 0.2499)]
    cloth = ls.Cloth(
        mesh=mesh,
        pins=sides,
        script_times=[0.0, 0.1],
        script_positions=np.concatenate([x[sides], x[sides] * (1.3, 1, 1)]),
        strain_limit=ls.StrainLimit(0.1, 0.1, 0.1),
    )
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], collisions=False),
        integrator=ls.SemiImplicitEuler(step=2e-3),
        threads=1,
    )
    report = sim.run(out=tmp_path / "r", duration=0.12)
    broken, last = sim.broken_limits, sim.report
    excess = [entry[2] for entry in broken]
    assert (
        excess == sorted(excess, reverse=True)
        and len({entry[0] for entry in broken}) == last.limits.broken > 36
    )
    assert broken[0] == (last.limits.worst_element, "weft", last.limits.weft_excess)
    assert last.strain.weft == pytest.approx(0.1 + last.limits.weft_excess, abs=1e-12)
    with (tmp_path / "r" / "limits.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if int(row["step"]) == last.step]
    assert [(int(r["triangle"]), r["direction"], float(r["excess"])) for r in rows] == broken[:20]
    assert report["steps_with_broken_limits"] > 5 and report["largest_excess"] == pytest.approx(
        last.limits.weft_excess, rel=0.1
    )
    strained = progress_lines.overstrained(last)
    assert (
        f"{last.limits.broken} triangles exceed their strain limits" in strained
        and f"triangle {last.limits.worst_element}" in strained
    )


def raster(mesh: ls.TriangleMesh, x: np.ndarray, cells: int = 5) -> np.ndarray:
    """Area-weighted mean strain on a raster of the rest square (cells x cells x 3)."""
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)][:, :, :2]
    e, f = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0])
    place = np.clip(((corners.mean(1) / 0.5 + 0.5) * cells).astype(int), 0, cells - 1) @ (cells, 1)
    weighted = [np.bincount(place, area * strain) for strain in ls.limits.strain(x, mesh).T]
    return (np.array(weighted) / np.bincount(place, area)).T.reshape(cells, cells, 3)


@pytest.mark.parametrize("limit", [(0.02, 0.02, 0.04), (0.02, 0.02, 0.2)])
def test_irregular_meshes_strain_as_regular_ones(limit):
    """Compares strain on regular and irregular meshes of a cloth that hangs in its own plane.

    Pins at two corners and air drag avoid chaotic motion, which would hide the influence of
    the mesh.
    """

    def hung(mesh: ls.TriangleMesh) -> np.ndarray:
        cloth = ls.Cloth(
            mesh=mesh,
            material=ls.ClothMaterial(
                weft_stiffness=100, warp_stiffness=100, shear_stiffness=30, density=1.0
            ),
            pins=ls.meshes.nearest_vertices(mesh, [(-0.25, 0.25, 0.0), (0.25, 0.25, 0.0)]),
            strain_limit=ls.StrainLimit(*limit),
        )
        air = ls.Air(normal_drag=5.0, tangential_drag=5.0)
        scene = ls.Scene(cloths=[cloth], collisions=False, gravity=(0.0, -9.81, 0.0), air=air)
        sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3), threads=1)
        for _ in range(100):
            sim.step()
        frames = []
        for _ in range(4):
            for _ in range(5):
                sim.step()
            frames.append(raster(mesh, np.array(sim.positions)))
            assert sim.report.limits.broken == 0
        return np.mean(frames, axis=0)

    regular = hung(ls.grid(size=(0.5, 0.5), cells=(16, 16)))
    irregular = np.mean(
        [hung(ls.meshes.irregular(triangles=512, seed=seed)) for seed in (1, 2, 3)], axis=0
    )
    assert np.abs(regular).max() > 0.03, "strained up to its limits"
    assert np.abs(irregular - regular).max() < 0.05 * np.abs(regular).max()


@pytest.mark.parametrize(
    ("integrator", "gain"),
    [(ls.SemiImplicitEuler(), 0.05), (ls.BackwardEuler(), 0.05), (ls.SymplecticEuler(), 0.3)],
)
def test_sweeps_after_the_solve_do_not_throw_cloth(integrator: ls.Integrator, gain: float) -> None:
    # A soft sheet falls until its strain limits act. If all corrections by sweeps changed
    # velocities, its energy would grow by 0.29, 0.30 and 0.92 of its largest kinetic energy with
    # the three integrators.
    material = ls.ClothMaterial(weft_stiffness=10.0, warp_stiffness=10.0, shear_stiffness=4.0)
    cloth = ls.Cloth(
        mesh=ls.grid(size=(0.4, 0.4), cells=(12, 12)),
        material=material,
        pins=[0, 12],
        strain_limit=ls.StrainLimit(0.02, 0.02, 0.04),
    )
    limits = ls.LimitOptions(in_solve=False)
    scene = ls.Scene(cloths=[cloth], collisions=False, limits=limits)
    sim = ls.Simulation(scene, integrator=integrator)
    largest = 0.0
    while sim.time < 0.6:
        sim.step()
        largest = max(largest, sim.report.account.balance)
    assert largest <= gain


def test_sweeps_after_the_solve_conserve_momentum_in_contacts() -> None:
    # A sheet with strain limits, stretched by a tenth, hits a sheet without limits. Both are free.
    def sheet(name, size, cells, z, limit, speed):
        mesh = ls.grid(size=(size, size), cells=(cells, cells)).moved((0.003, 0.002, z))
        material = ls.ClothMaterial(
            weft_stiffness=10.0, warp_stiffness=10.0, shear_stiffness=4.0, density=0.2
        )
        return ls.Cloth(
            name=name,
            mesh=mesh,
            material=material,
            strain_limit=limit,
            velocities=np.tile((0.0, 0.0, -speed), (len(mesh.vertices), 1)),
        )

    limit = ls.StrainLimit(0.02, 0.02, 0.04)
    cloths = [sheet("upper", 0.2, 8, 0.006, limit, 2.0), sheet("lower", 0.1, 5, 0.0, None, 0.0)]
    scene = ls.Scene(
        cloths=cloths,
        gravity=(0.0, 0.0, 0.0),
        limits=ls.LimitOptions(in_solve=False),
        response="impulse",
    )
    sim = ls.Simulation(scene, integrator=ls.SymplecticEuler(step=1e-4))
    n = len(cloths[0].mesh.vertices)
    positions = sim.positions.copy()
    positions[:n, :2] *= 1.1
    sim.positions = positions
    masses = []
    for cloth in cloths:
        corners = np.asarray(cloth.mesh.vertices)[np.asarray(cloth.mesh.triangles)]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        mass = np.zeros(len(cloth.mesh.vertices))
        for k in range(3):
            np.add.at(mass, cloth.mesh.triangles[:, k], 0.2 * np.linalg.norm(normals, axis=1) / 6)
        masses.append(mass)
    mass = np.concatenate(masses)
    start = mass @ sim.velocities
    impacts = sweeps = 0
    while sim.time < 0.05:
        sim.step()
        impacts += sim.report.contacts.impacts + sim.report.contacts.near
        sweeps += sim.report.limits.sweeps
    assert impacts > 0 and sweeps > 0
    assert np.linalg.norm(mass @ sim.velocities - start) < 1e-11 * np.linalg.norm(start)


def test_limits_of_edges_do_not_depend_on_limits_in_the_solve() -> None:
    mesh = ls.grid(size=(0.3, 0.3), cells=(10, 10))
    cloth = ls.Cloth(mesh=mesh, strain_limit=ls.StrainLimit(edge=0.02))
    stretch = []
    for in_solve in (False, True):
        scene = ls.Scene(
            cloths=[cloth],
            collisions=False,
            gravity=(0.0, 0.0, 0.0),
            limits=ls.LimitOptions(in_solve=in_solve),
        )
        sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=2e-3))
        sim.positions = sim.positions * (1.2, 1.2, 1.0)
        sim.step()
        stretch.append(np.ptp(sim.positions[:, 0]) / 0.3)
    assert stretch[0] == stretch[1] < 1.03
