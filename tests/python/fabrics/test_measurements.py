"""Simulated laboratory tests of fabrics on small meshes, compared with plate theory, the elastica
and plain geometry.
"""

import json
from dataclasses import replace

import loomstone as ls
import numpy as np
import pytest
from loomstone.fabrics.measurements import (
    FabricReport,
    bring_to_rest,
    cantilever,
    cusick,
    report_fabrics,
)
from loomstone.fabrics.measurements.bending_test import overhang_of_elastica
from loomstone.fabrics.measurements.drape_test import (
    DISC,
    SPECIMEN,
    count_folds,
    drape_scene,
    shadow_area,
    specimen,
)


def isotropic(bending, **fields):
    stiffness = {
        "weft_stiffness": 1000,
        "warp_stiffness": 1000,
        "shear_stiffness": 500,
        "density": 0.2,
    }
    return ls.ClothMaterial(
        **{**stiffness, "bending_weft": bending, "bending_warp": bending, **fields}
    )


def test_the_specimen_is_a_disc_with_a_ring_of_vertices_on_the_edge_of_the_clamp():
    mesh = specimen(1200)
    radius = np.linalg.norm(mesh.vertices[:, :2], axis=1)
    on_clamp = np.abs(radius - DISC) < 1e-12
    assert abs(mesh.n_triangles - 1200) <= 1 and radius.max() == pytest.approx(SPECIMEN)
    edges = np.linalg.norm(
        mesh.vertices[mesh.edges[:, 0]] - mesh.vertices[mesh.edges[:, 1]], axis=1
    )
    ring = on_clamp[mesh.edges].all(1)
    assert ring.sum() == on_clamp.sum(), (
        "neighbours on the clamp's edge are joined: the clamp line is meshed"
    )
    assert edges[ring].max() < 1.5 * mesh.mean_edge


def test_a_shadow_is_the_area_of_the_union_seen_from_above():
    flat = ls.grid(size=(0.2, 0.1), cells=(8, 4))
    # The error is smaller than the area of one row of pixels along the edge.
    assert shadow_area(flat.vertices, flat.triangles) == pytest.approx(0.02, rel=5e-3)
    folded = flat.vertices * [1, 1, 0] + [0, 0, 0]
    folded[:, 0] = np.abs(folded[:, 0])  # folded in half
    assert shadow_area(folded, flat.triangles) == pytest.approx(0.01, rel=8e-3)
    angle = np.radians(60)
    tilted = (
        flat.vertices
        @ np.array(
            [[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]]
        ).T
    )
    assert shadow_area(tilted, flat.triangles) == pytest.approx(0.01, rel=8e-3)
    upright = flat.vertices[:, [0, 2, 1]]
    assert shadow_area(upright, flat.triangles) < 1e-4, "seen edge on"


def test_a_shadow_gets_exact_with_small_pixels():
    mesh = specimen(600)
    a, b, c = (mesh.vertices[mesh.triangles[:, k], :2] for k in range(3))
    exact = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
    errors = [
        abs(shadow_area(mesh.vertices, mesh.triangles, pixel=pixel) / exact - 1)
        for pixel in (2e-3, 2.5e-4)
    ]
    # An error of 2e-4 of the area is 0.03 percentage points of the drape coefficient.
    assert errors[1] < errors[0] and errors[1] < 2e-4


def test_folds_are_maxima_of_the_outline():
    mesh = specimen(3000)
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    for folds in (0, 3, 7):
        waved = (
            mesh.vertices * (1 + 0.1 * (np.cos(folds * angle) if folds else 0))[..., None]
            if folds
            else mesh.vertices
        )
        assert count_folds(mesh, waved) == folds


def test_the_elastica_is_a_beam_where_it_hardly_sags_and_spans_two_bending_lengths_at_41_5():
    for degrees in (0.1, 1.0):
        assert overhang_of_elastica(degrees) ** 3 / 8 == pytest.approx(
            np.tan(np.radians(degrees)), rel=1e-3
        )
    # At 41.5 degrees, the overhang is twice the bending length. Therefore standards define the
    # bending length as half of the overhang.
    assert overhang_of_elastica(41.5) == pytest.approx(2.0, rel=1e-3)
    assert overhang_of_elastica(0.01) < 0.15 and overhang_of_elastica(87.5) > 5
    for degrees in (0.009, 87.6, 95.0, float("nan")):
        with pytest.raises(ls.InvalidInput, match=r"must be in \[0.01, 87.5\], got"):
            overhang_of_elastica(degrees)


@pytest.mark.parametrize("name", ["cotton", "stretch denim"])
@pytest.mark.parametrize("angle", [0, 90])
def test_strips_along_weft_and_warp_hang_out_as_the_elastica_of_their_rigidity(name, angle):
    strip = cantilever(ls.fabrics[name], angle_degrees=angle)
    # docs/fabrics.md reports differences of up to 0.3 % between the two overhangs.
    assert strip.at_rest and strip.overhang == pytest.approx(strip.elastica, rel=0.005)
    assert strip.bending_length == strip.overhang / 2


def test_strips_on_the_bias_hang_out_as_plate_theory_says_in_the_limit_of_no_width():
    """The clamp prevents twisting and thereby stiffens strips on the bias. At a width of 25 mm, the
    overhang is 5 % longer for this reason. The narrower the strip, the smaller is the effect.
    """
    wide, narrow = (
        cantilever(ls.fabrics["t-shirt"], angle_degrees=45, width=width).error
        for width in (0.006, 0.003)
    )
    assert narrow < 0.65 * wide < 0.65 * 0.025
    assert 2 * narrow - wide == pytest.approx(0.0, abs=0.005)  # extrapolated to no width


def test_strips_that_are_turned_with_their_material_hang_alike():
    fabric = isotropic(1e-5, bending_warp=3e-5)
    turned = isotropic(3e-5, bending_warp=1e-5)
    assert cantilever(fabric, angle_degrees=0).overhang == pytest.approx(
        cantilever(turned, angle_degrees=90).overhang, rel=1e-4
    )


def test_a_stiff_specimen_sags_at_its_rim_as_a_clamped_annular_plate():
    """In linear plate theory with nu = 0, the sag is w = c0 + c1 r^2 + c2 ln r + c3 r^2 ln r
    + q r^4 / (64 B), where q is the load per area and B the bending stiffness.

    Linear theory applies because the sag is only 0.13 mm.
    """
    bending, density = 3e-2, 0.2
    load, a, b = density * 9.81, DISC, SPECIMEN

    def rows(r):  # rows: value, slope, moment / B, shear / B; columns: terms of w
        log = np.log(r)
        return np.array(
            [
                [1, r**2, log, r**2 * log, r**4],
                [0, 2 * r, 1 / r, 2 * r * log + r, 4 * r**3],
                [0, 2, -1 / r**2, 2 * log + 3, 12 * r**2],
                [0, 0, 0, 4 / r, 32 * r],
            ]
        )

    clamped, free = rows(a)[:2], rows(b)[2:]
    conditions, particular = np.concatenate([clamped, free]), load / (64 * bending)
    constants = np.linalg.solve(conditions[:, :4], -particular * conditions[:, 4])
    sag = rows(b)[0] @ np.append(constants, particular)
    errors = []
    for triangles in (800, 1500):
        mesh = specimen(triangles)
        # The stiff specimen hardly sags. The direct solver is used because it has no tolerance.
        options = ls.SemiImplicitEuler(step=4e-3, linear_solver="direct")
        sim = ls.Simulation(
            drape_scene(isotropic(bending, density=density), mesh), integrator=options
        )
        assert bring_to_rest(sim, drift=1e-7).at_rest
        rim = np.linalg.norm(mesh.vertices[:, :2], axis=1) > SPECIMEN - 1e-9
        errors.append(abs(-sim.positions[rim, 2].mean() / sag - 1))
    # The error is of second order in the edge length.
    assert errors[1] < 0.03 and errors[1] < 0.6 * errors[0]


def test_limits_of_a_hundredth_change_the_drape_by_less_than_a_tenth_and_the_cloth_comes_to_rest():
    # The knit is limp and strains by more than 2 % if its limits allow it. The test compares means
    # of sixteen specimens, because individual specimens differ by one fold on average.
    knit = isotropic(3.6e-6, weft_stiffness=33, warp_stiffness=60, shear_stiffness=37)
    limits = (ls.StrainLimit(0.05, 0.05, 0.05), ls.StrainLimit(0.01, 0.01, 0.05))
    loose, tight = (
        [cusick(knit, strain_limit=limit, triangles=600, seed=seed) for seed in range(1, 17)]
        for limit in limits
    )
    for result in tight:
        strain = ls.limits.strain(result.positions, result.mesh)
        assert strain[:, :2].max() < 0.012
        assert result.rest.at_rest and result.rest.energy_ratio < 1e-6 and result.intersections == 0
    assert max(ls.limits.strain(r.positions, r.mesh)[:, 0].max() for r in loose) > 0.02
    coefficient = [np.mean([r.drape_coefficient for r in results]) for results in (loose, tight)]
    assert coefficient[1] == pytest.approx(coefficient[0], rel=0.1)
    folds = [np.mean([r.folds for r in results]) for results in (loose, tight)]
    assert folds[1] == pytest.approx(folds[0], rel=0.1)


def test_conforming_triangles_do_not_lock_at_limits_of_a_hundredth_in_stretch_and_compression():
    # Triangles that lock would increase the drape coefficient. tests/benchmarks/locking.py also
    # tests limits of 0.1 %.
    knit = isotropic(3.6e-6, weft_stiffness=33, warp_stiffness=60, shear_stiffness=37)
    hundredth = ls.StrainLimit(0.01, 0.01, 0.01, weft_min=-0.01, warp_min=-0.01)
    free, limited = (
        [cusick(knit, strain_limit=limit, triangles=1800, seed=seed) for seed in (1, 2)]
        for limit in (None, hundredth)
    )
    for result in limited:
        assert np.abs(ls.limits.strain(result.positions, result.mesh)).max() < 0.012
        assert result.rest.at_rest and result.intersections == 0
    assert max(np.abs(ls.limits.strain(r.positions, r.mesh)).max() for r in free) > 0.02
    coefficient = [np.mean([r.drape_coefficient for r in results]) for results in (free, limited)]
    assert coefficient[1] == pytest.approx(coefficient[0], rel=0.1)


def test_a_limp_fabric_drapes_and_card_does_not():
    limp, card = cusick(isotropic(2e-6), triangles=800), cusick(isotropic(1e-2), triangles=800)
    assert limp.rest.at_rest and card.rest.at_rest
    assert limp.intersections == card.intersections == 0
    assert card.drape_coefficient > 99.5 and card.folds == 0
    assert limp.drape_coefficient < 60 and limp.folds >= 4


def test_rest_is_distinguished_from_motion():
    scene = drape_scene(isotropic(1e-5), specimen(600))
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=4e-3))
    short = bring_to_rest(sim, longest=0.1)
    assert not short.at_rest and short.time == pytest.approx(0.1, abs=5e-3)
    rest = bring_to_rest(sim)
    assert rest.at_rest and rest.stops > 0 and rest.energy_ratio < 1e-6 and rest.drift < 1e-4
    before = sim.positions
    for _ in range(25):
        sim.step()
    assert np.abs(sim.positions - before).max() < 1e-4, "without damping it stays where it is"
    with pytest.raises(ls.InvalidInput, match="bring_to_rest: ratio must be finite and > 0"):
        bring_to_rest(sim, ratio=-1)


def test_a_report_measures_and_writes_tables_and_pictures(tmp_path):
    pytest.importorskip("matplotlib")
    told = []
    (report,) = report_fabrics(
        ["cotton"], out=tmp_path / "fabrics", triangles=600, specimens=2, done=told.append
    )
    assert told == [report] and report.fabric.name == "cotton"
    (kept,) = json.loads((tmp_path / "fabrics" / "report.json").read_text())
    assert kept["band"] == [60, 76] and kept["in_band"] == (60 <= kept["drape_coefficient"] <= 76)
    coefficients = [drape["drape_coefficient"] for drape in kept["specimens"]]
    assert (
        kept["drape_coefficient"] == sum(coefficients) / 2
        and kept["spread"] == abs(np.diff(coefficients)[0]) / 2
    )
    assert report.spread > 0, "another mesh is another specimen"
    assert set(kept["cantilever"]) == {"weft", "bias", "warp"}
    assert (tmp_path / "fabrics" / "drape.png").stat().st_size > 20_000
    without_band = FabricReport(ls.fabrics["rib knit"], report.drapes, report.strips)
    assert without_band.in_band is None and without_band.remark == ""
    far_off = FabricReport(
        ls.fabrics["cotton"], [replace(report.drapes[0], drape_coefficient=95.0)], report.strips
    )
    assert far_off.in_band is False and far_off.off_band == 19.0
    assert far_off.remark.startswith("19.0 points outside the published range; bending is a median")
    near = [
        replace(report.drapes[0], drape_coefficient=coefficient) for coefficient in (58.0, 61.0)
    ]
    assert (
        "0.5 points outside the published range, less than the spread of the specimens"
        in FabricReport(ls.fabrics["cotton"], near, report.strips).remark
    )


def test_mistakes_are_reported_before_anything_is_computed(tmp_path):
    with pytest.raises(ls.InvalidInput, match="there is no fabric 'velvet'"):
        report_fabrics(["velvet"])
    with pytest.raises(ls.InvalidInput, match="at least one fabric"):
        report_fabrics([])
    with pytest.raises(ls.InvalidInput, match="triangles must be in"):
        cusick(isotropic(1e-5), triangles=10)
    with pytest.raises(ls.InvalidInput, match="must resist bending"):
        cantilever(isotropic(0.0))
