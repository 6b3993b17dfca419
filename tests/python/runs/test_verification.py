"""Runs whose frames are checked for intersections (--verify)."""

import loomstone as ls
import pytest
from loomstone.cli import inspection


def test_a_verified_run_records_the_count_of_every_frame_also_where_it_was_resumed(
    hanging, euler, tmp_path
):
    def verified(duration, **options):
        sim = ls.Simulation(hanging, integrator=euler, threads=1)
        return sim.run(out=tmp_path / "v", duration=duration, verify=True, **options)

    report = verified(0.08)
    assert (report["verified_frames"], report["intersecting_frames"]) == (3, 0)
    assert verified(0.16, resume=True)["verified_frames"] == 5
    rows = (tmp_path / "v" / "frames.csv").read_text().splitlines()
    assert rows[0] == "frame,time,intersecting_pairs,pairs_among_bodies"
    assert [row.split(",")[0] for row in rows[1:]] == ["0", "1", "2", "3", "4"]
    assert all(row.endswith(",0,0") for row in rows[1:])
    assert "5 frames verified: 0 with intersecting triangles" in inspection.report_text(
        report | {"verified_frames": 5}
    )


CUT = "the last row is cut"


@pytest.mark.parametrize("left", [None, CUT, "frame,time,intersecting_pairs,pairs_among_bodies"])
def test_frames_that_were_not_counted_are_counted_when_a_run_is_continued(
    hanging, euler, tmp_path, left
):
    def run(duration, **options):
        sim = ls.Simulation(hanging, integrator=euler, threads=1)
        return sim.run(out=tmp_path / "v", duration=duration, resume=duration > 0.1, **options)

    run(0.08, verify=True)
    table = tmp_path / "v" / "frames.csv"
    whole = table.read_text()
    if left is None:
        table.unlink()  # as if the run had begun without `verify`
    else:
        table.write_text(whole[:-12] if left == CUT else left)
    report = run(0.12, verify=True)
    assert report["verified_frames"] == 4 and table.read_text().startswith(whole)
    run(0.16)
    assert run(0.2, verify=True)["verified_frames"] == 6
    assert [row.split(",")[0] for row in table.read_text().split()[1:]] == list("012345")


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text.replace("0.04", "much"), "line 3: must be 4 numbers"),
        (lambda text: "", "must begin with the column 'frame'"),
        (lambda text: text + "\ud800", "cannot be read as one"),
    ],
)
def test_a_verified_run_is_not_resumed_with_damaged_counts(hanging, euler, tmp_path, damage, said):
    out = tmp_path / "v"
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=out, duration=0.08, verify=True)
    path = out / "frames.csv"
    path.write_bytes(damage(path.read_bytes().decode()).encode(errors="surrogatepass"))
    with pytest.raises(ls.CacheError, match=f"frames.csv.*{said}"):
        ls.Simulation(hanging, integrator=euler, threads=1).run(
            out=out, duration=0.16, verify=True, resume=True
        )
    path.unlink()
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=out, duration=0.16, resume=True)


def test_a_verified_run_finds_the_intersections_that_a_start_has(tmp_path):
    ball = ls.sphere(radius=0.05, subdivisions=1)
    scene = ls.Scene(
        cloths=[ls.Cloth(mesh=ls.grid(size=(0.2, 0.2), cells=(6, 6)))],
        obstacles=[ball],
        allow_initial_intersections=True,
    )
    report = ls.Simulation(scene, threads=1).run(out=tmp_path / "v", duration=0.0, verify=True)
    assert (
        report["verified_frames"] == report["intersecting_frames"] == 1
        and report["most_intersecting_pairs"] > 10
    )
