"""Reports about contact, withheld motion and energy, for a step and for a run."""

import csv
import json

import loomstone as ls
import numpy as np
import pytest
from loomstone.cli import inspection
from loomstone.runs.steps import read_steps


def test_forced_intersections_are_recorded_with_their_triangles_and_reported(
    pressed, tmp_path, capsys
):
    # From 0.02 s on, the plates are tilted against each other, so they cut the cloth between them.
    tilted = [
        plate.replace(axis_angles=[(0, 0, 0), (angle, 0, 0)])
        for plate, angle in zip(pressed.obstacles, (0.15, -0.15), strict=True)
    ]
    sim = ls.Simulation(
        pressed.replace(obstacles=tilted),
        integrator=ls.SemiImplicitEuler(step=0.01),
        threads=1,
    )
    report = sim.run(out=tmp_path / "r", duration=0.08, rate=100.0)
    steps = read_steps(tmp_path / "r")
    with (tmp_path / "r" / "forced.csv").open() as file:
        rows = [
            (int(row["step"]), int(row["triangle"]), int(row["other_triangle"]))
            for row in csv.DictReader(file)
        ]
    assert report["forced_steps"] == (steps["contacts.forced"] > 0).sum() > 0
    assert [sum(row[0] == step for row in rows) for step in steps["step"]] == list(
        steps["contacts.forced"]
    )
    # The cloth intersects the plates, but never itself.
    assert all(first < 128 <= second for _, first, second in rows)
    run = ls.Run(tmp_path / "r")
    for frame in run:
        marked = {
            int(t) for t in np.flatnonzero((frame.contact[run.topology.triangles] == 2).all(axis=1))
        }
        assert {first for step, first, _ in rows if step == frame.step} <= marked
    inspection.describe(tmp_path / "r")
    assert (
        f"{report['forced_steps']} steps ended with triangles forced to intersect"
        in capsys.readouterr().out
    )


def test_a_run_sums_the_withheld_motion(falling, euler, tmp_path):
    report = ls.Simulation(falling, integrator=euler, threads=1).run(
        out=tmp_path / "r", duration=0.2
    )
    steps = read_steps(tmp_path / "r")
    assert (steps["withheld.requested"] > 0).all()
    assert report["withheld"] == pytest.approx(
        steps["withheld.motion"].sum() / steps["withheld.requested"].sum()
    )
    assert json.loads((tmp_path / "r" / "report.json").read_text())["withheld"] <= 1e-3
    assert "certification withheld" in inspection.report_text(report)


def test_requested_motion_and_acceleration_are_those_of_the_vertices():
    # One sheet falls, and one lies on the floor. The reported acceleration in contact includes only
    # vertices that touch something.
    mesh = ls.grid(size=(0.1, 0.1), cells=(4, 4))
    cloths = [
        ls.Cloth(name="high", mesh=mesh.moved((0, 0, 0.5))),
        ls.Cloth(name="low", mesh=mesh.moved((0.003, 0.002, 0.0024))),
    ]
    sim = ls.Simulation(
        ls.Scene(cloths=cloths, obstacles=[ls.floor()]),
        integrator=ls.SemiImplicitEuler(step=1e-3),
        threads=1,
    )
    before, was = sim.positions, sim.velocities
    sim.step()
    assert sim.report.withheld.requested == pytest.approx(
        np.linalg.norm(sim.positions - before, axis=1).sum(), rel=1e-12
    )
    touching = sim.frame().contact > 0
    change = np.linalg.norm(sim.velocities - was, axis=1)[touching] / 1e-3
    assert 0 < touching.sum() <= 25 and not touching[:25].any()
    assert sim.report.contacts.acceleration == pytest.approx(np.sqrt((change**2).mean()), rel=1e-12)


def test_a_run_describes_its_account_of_energy(falling, euler, tmp_path, capsys):
    report = ls.Simulation(falling, integrator=euler, threads=1).run(
        out=tmp_path / "r", duration=0.2
    )
    steps = read_steps(tmp_path / "r")
    kinetic = steps["account.largest_kinetic"]
    assert report["largest_kinetic_energy"] == kinetic.max() >= steps["energy.kinetic"].max()
    for name, column in (
        ("largest_energy_balance", "account.balance"),
        ("largest_contact_balance", "account.contact_balance"),
    ):
        assert report[name] == pytest.approx((steps[column] * kinetic).max() / kinetic.max())
    # The change of energy since the start, without the energy of contacts, is the work minus the
    # losses.
    account = report["account_at_end"]
    work = account["scripts"] + account["loads"]
    losses = sum(account[name] for name in ("friction", "damping", "limits", "withheld", "lost"))
    assert report["energy_balance_at_end"] * kinetic.max() == pytest.approx(-losses)
    start = ls.Simulation(falling, integrator=euler, threads=1).report.energy
    first = start.kinetic + start.membrane + start.bending + start.gravity
    last = sum(v for name, v in report["energy_at_end"].items() if name != "contact")
    assert last - first == pytest.approx(work - losses, abs=1e-9 * abs(first))
    inspection.describe(tmp_path / "r")
    text = capsys.readouterr().out
    assert "rise of energy minus work: at most" in text and "losses: " in text
    gained = {**report, "largest_contact_balance": 0.06}
    assert "(including that of contacts) minus work rose by 6 %" in inspection.report_text(gained)
    calm = inspection.energy_lines({**report, "energy_balance_at_end": -1323.6})
    assert "-1,324 times at the end" in calm[-1]
    # A script that presses cloth at rest does work, but gives the cloth no kinetic energy. The text
    # then compares the balance with this work.
    still = {**gained, "account_at_end": {**account, "scripts": 1e4 * kinetic.max()}}
    assert "relative to the work of scripts" in inspection.energy_lines(still)[-1]
    assert "minus work rose" not in inspection.report_text(still)
    rounding = {**report, "account_at_end": {**account, "limits": 1e-17 * kinetic.max()}}
    assert "limits" not in "".join(inspection.energy_lines(rounding))


def test_energy_lost_to_impacts_is_not_called_withheld_motion(tmp_path):
    """Impulses of impacts change the motion after the solve. The account adds the energy that they
    dissipate to `withheld`, although no motion is withheld here.
    """
    mesh = ls.grid(size=(0.2, 0.2), cells=(6, 6)).moved((0, 0, 0.02))
    scene = ls.Scene(
        cloths=[ls.Cloth(mesh=mesh, velocities=np.tile((0.0, 0.0, -3.0), (mesh.n_vertices, 1)))],
        obstacles=[ls.floor()],
        response="impulse",
    )
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=0.01), threads=1)
    report = sim.run(out=tmp_path / "r", duration=0.08)
    assert report["withheld"] == 0.0 and abs(report["account_at_end"]["withheld"]) > 1e-3
    assert "certification withheld 0 % of the motion" in inspection.report_text(report)
    (losses,) = (each for each in inspection.energy_lines(report) if each.startswith("losses"))
    lost = report["account_at_end"]["withheld"]
    assert f"impacts and withheld motion {lost:.3g} J" in losses and ", withheld" not in losses
