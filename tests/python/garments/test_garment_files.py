"""Garments from files: GarmentCode patterns, sewn meshes with the pattern as uv, and seams that a
simulation pulls shut.
"""

import json
from pathlib import Path

import loomstone as ls
import numpy as np
import pytest

g = ls.garments

DRESS = Path(__file__).parents[4] / "shared/data/meshes/dress.obj"


def specification(panels: dict, stitches: list, **properties: object) -> dict:
    kept = {"curvature_coords": "relative", "units_in_meter": 100, **properties}
    return {"pattern": {"panels": panels, "stitches": stitches}, "properties": kept}


def rectangle(
    translation=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), clockwise=False, width=40.0, height=50.0
) -> dict:
    corners = [[-width / 2, 0.0], [width / 2, 0.0], [width / 2, height], [-width / 2, height]]
    ends = [[0, 1], [1, 2], [2, 3], [3, 0]] if not clockwise else [[1, 0], [0, 3], [3, 2], [2, 1]]
    edges = [{"endpoints": e} for e in ends]
    return {
        "translation": list(translation),
        "rotation": list(rotation),
        "vertices": corners,
        "edges": edges,
    }


def skirt(gap: float = 2.0) -> dict:
    """Front and back panels in cm, with y up and z to the front. Both panels face outward."""
    panels = {
        "front": rectangle((0, 100, gap / 2)),
        "back": rectangle((0, 100, -gap / 2), clockwise=True),
    }
    # Indices of the edges. Front: 0 hem, 1 right, 2 waist, 3 left. Back: 0 hem, 1 left, 2 waist,
    # 3 right. Left and right are those of an observer in front of the skirt.
    stitches = [
        [{"panel": "front", "edge": 1}, {"panel": "back", "edge": 3}],
        [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 1}],
    ]
    return specification(panels, stitches)


def write(tmp_path: Path, content: object) -> Path:
    path = tmp_path / "skirt_specification.json"
    path.write_text(json.dumps(content))
    return path


def front_hem(content: dict) -> dict:
    return content["pattern"]["panels"]["front"]["edges"][0]


def test_a_garmentcode_pattern_is_sewn_in_metres_with_z_up(tmp_path):
    skirt_file = write(tmp_path, skirt())
    garment = g.read(skirt_file, triangles=800)
    assert garment.panel_names == ("front", "back")
    assert len(garment.openings()) == 2, "waist and hem"
    low, high = garment.mesh.vertices.min(0), garment.mesh.vertices.max(0)
    # The relaxed skirt is about 40 cm wide and 50 cm high, and its hem is at 1 m.
    assert high[2] - low[2] == pytest.approx(0.5, rel=0.02) and low[2] == pytest.approx(
        1.0, abs=0.02
    )
    assert high[0] - low[0] == pytest.approx(0.4, rel=0.05)
    front = garment.mesh.vertices[garment.groups["front"]]
    assert front[:, 1].mean() < garment.mesh.vertices[garment.groups["back"]][:, 1].mean(), (
        "the front looks to -y"
    )
    # The panels face outward, so the signed volume between the skirt and its centroid is
    # positive.
    corners = garment.mesh.vertices[garment.mesh.triangles] - garment.mesh.vertices.mean(0)
    assert np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0


def test_curvatures_are_relative_to_the_edge(tmp_path):
    panel = rectangle()
    r = 25.0
    # The hem runs along +x. It becomes a minor arc that bulges to its right, which is downwards.
    panel["edges"][0]["curvature"] = {
        "type": "circle",
        "params": [r, 0, 1],
    }
    panel["edges"][1]["curvature"] = {"type": "quadratic", "params": [[0.5, -0.2]]}
    panel["edges"][2]["curvature"] = {"type": "cubic", "params": [[1 / 3, 0.1], [2 / 3, 0.1]]}
    panel["edges"][3]["curvature"] = [0.5, 0.2]  # format of older files
    pattern = g.read_garmentcode(write(tmp_path, specification({"a": panel}, [])))
    a = pattern.panel("a")
    angle = 2 * np.arcsin(20.0 / r)
    assert a.edge("edge_0").length == pytest.approx(0.01 * r * angle, rel=1e-5)
    assert a.edge("edge_0").curve()[:, 1].min() == pytest.approx(
        -0.01 * (r - np.sqrt(r**2 - 20.0**2)), rel=1e-4
    )
    # The panel lies to the left of its edges. A quadratic curve reaches 1/2 of its control point's
    # distance from the edge, and a cubic curve 3/4 of the common distance of its control points.
    assert a.edge("edge_1").curve()[:, 0].max() == pytest.approx(0.2 + 0.5 * 0.2 * 0.5, rel=1e-5)
    assert a.edge("edge_2").curve()[:, 1].min() == pytest.approx(0.5 - 0.75 * 0.1 * 0.4, rel=1e-5)
    assert a.edge("edge_3").curve()[:, 0].max() == pytest.approx(-0.2 + 0.5 * 0.2 * 0.5, rel=1e-5)


def test_a_large_arc_is_the_rest_of_the_circle(tmp_path):
    panel = rectangle(width=10.0)
    panel["edges"][0]["curvature"] = {"type": "circle", "params": [8.0, 1, 1]}
    edge = g.read_garmentcode(write(tmp_path, specification({"a": panel}, []))).edge("a.edge_0")
    assert edge.length == pytest.approx(0.08 * (2 * np.pi - 2 * np.arcsin(5.0 / 8.0)), rel=3e-5)


def test_rotations_are_about_fixed_axes_in_the_order_x_y_z(tmp_path):
    # A rotation by 90 degrees about x maps (0, 1, 0) to (0, 0, 1). The rotation about y then gives
    # (1, 0, 0), and the one about z (0, 1, 0).
    panel = rectangle(translation=(0, 0, 0), rotation=(90, 90, 90))
    place = g.read_garmentcode(write(tmp_path, specification({"a": panel}, []))).panel("a").place
    # The reader converts from y up to z up.
    assert np.allclose(place(np.array([[0.0, 1.0]])), [[0.0, 0.0, 1.0]], atol=1e-12)


def test_units_are_those_of_the_file(tmp_path):
    metres = specification({"a": rectangle(width=0.4, height=0.5)}, [], units_in_meter=1)
    assert g.read_garmentcode(write(tmp_path, metres)).panel("a").area == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: s.pop("pattern"), "KeyError: 'pattern'"),
        (lambda s: s["pattern"]["panels"]["front"].pop("vertices"), "KeyError: 'vertices'"),
        (lambda s: s["pattern"]["panels"]["front"]["edges"].pop(), "panel 'front' is open"),
        (lambda s: front_hem(s).update(curvature={"type": "spline", "params": []}), "'spline'"),
        (
            lambda s: s["pattern"]["stitches"].pop() and s["pattern"]["stitches"].pop(),
            "falls into pieces",
        ),
        (lambda s: s["pattern"]["stitches"].append(s["pattern"]["stitches"][0]), "is sewn twice"),
        (lambda s: s["pattern"]["stitches"][0][0].update(edge=9), "no edge 'edge_9'"),
    ],
)
def test_mistakes_in_a_pattern_are_reported(tmp_path, change, message):
    content = skirt()
    change(content)
    with pytest.raises(ls.InvalidInput) as error:
        g.read(write(tmp_path, content), triangles=100)
    assert message in str(error.value)


def test_files_that_are_not_json_are_reported(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("{")
    with pytest.raises(ls.InvalidInput, match="is not JSON"):
        g.read(path)
    with pytest.raises(ls.CacheError, match="cannot be read"):
        g.read(tmp_path / "missing.json")


@pytest.mark.parametrize(
    "content", [[1, 2], {"properties": {"units_in_meter": 0}, "pattern": {"panels": {}}}]
)
def test_json_that_is_no_pattern_is_refused(tmp_path, content):
    path = tmp_path / "none.json"
    path.write_text(json.dumps(content))
    with pytest.raises(ls.InvalidInput, match="is not a readable GarmentCode pattern"):
        g.read_garmentcode(path)


@pytest.mark.parametrize(
    "wrong, said",
    [
        ({"longest": 0.0}, "longest must be > 0"),
        ({"step": float("nan")}, "step must be > 0"),
        ({"ease": float("nan")}, "ease must be in"),
    ],
)
def test_closing_refuses_invalid_times_and_ease(wrong, said):
    with pytest.raises(ls.InvalidInput, match=said):
        g.close_seams(g.tshirt_pattern(), triangles=300, places=apart(0.3), threads=1, **wrong)


def test_a_sewn_mesh_is_read_back_with_its_panels_and_seams(tmp_path):
    shirt = g.tshirt(800)
    ls.meshes.write(tmp_path / "shirt.obj", shirt.mesh)
    again = g.read(tmp_path / "shirt.obj")
    assert len(again.panel_names) == 4
    assert sorted(np.bincount(again.panel_of_triangle)) == sorted(
        np.bincount(shirt.panel_of_triangle)
    )
    assert len(again.seam_edges) == len(shirt.seam_edges)
    # The stretch relative to the pattern is that of the original mesh.
    assert np.allclose(again.stretches(), shirt.stretches(), atol=1e-5)
    assert len([name for name in again.groups if name.startswith("opening")]) == 4


def test_a_mesh_without_pattern_or_with_open_seams_is_refused():
    flat = ls.grid(size=(0.2, 0.2), cells=(4, 4))
    with pytest.raises(ls.InvalidInput, match="has no uv"):
        g.sewn(ls.TriangleMesh(flat.vertices, flat.triangles))
    # Two halves meet without sharing vertices.
    vertices = np.concatenate([flat.vertices, flat.vertices + (0.2, 0.0, 0.0)])
    triangles = np.concatenate([flat.triangles, flat.triangles + flat.n_vertices])
    with pytest.raises(ls.InvalidInput, match="5 seam points are open"):
        g.sewn(ls.TriangleMesh(vertices, triangles, vertices[:, :2]))


@pytest.mark.skipif(not DRESS.exists(), reason="data beside the project")
def test_the_dress_of_the_garment_library_is_read_with_its_seams():
    dress = g.read(DRESS)
    assert dress.mesh.n_triangles == 8958
    # A circle skirt and a halter bodice share 46 edges around the waist. The openings are the hem,
    # the back with the armholes, and the neck.
    assert len(dress.panel_names) == 2 and len(dress.seam_edges) == 46
    assert [len(dress.groups[f"opening_{i}"]) for i in (1, 2, 3)] == [160, 44, 18]
    # The pattern is in metres, like the dress: the middle half of all principal stretches differs
    # from 1 by less than 2 %.
    quarters = np.percentile(dress.stretches(), [25, 75])
    assert quarters[0] > 0.98 and quarters[1] < 1.02


def body() -> ls.Obstacle:
    return ls.capsule(radius=0.13, length=0.42, centre=(0.0, 0.0, 0.3), name="trunk")


def apart(distance: float) -> dict[str, g.Plane]:
    return {
        "front": g.Plane((0.0, -distance, 0.0)),
        "back": g.Plane((0.0, distance, 0.0), across=(-1.0, 0.0, 0.0)),
    }


def test_seams_close_round_a_body_and_weld_without_intersections():
    shirt = g.close_seams(
        g.tshirt_pattern(), triangles=800, places=apart(0.16), obstacles=[body()], threads=1
    )
    assert len(shirt.openings()) == 4
    assert ls.collision.intersecting_pairs(shirt.mesh.vertices, shirt.mesh.triangles) == []
    trunk = body().mesh
    points = np.concatenate([shirt.mesh.vertices, trunk.vertices])
    triangles = np.concatenate([shirt.mesh.triangles, trunk.triangles + shirt.mesh.n_vertices])
    assert ls.collision.intersecting_pairs(points, triangles) == []
    # The last gaps, of at most half an edge, are closed by moving vertices. Relaxation spreads the
    # stretch that this causes.
    assert shirt.stretches().max() < 1.1 and shirt.stretches().min() > 0.9
    # The triangles are those of a garment that is welded from the start.
    at_once = g.tshirt(800)
    assert np.array_equal(shirt.mesh.triangles, at_once.mesh.triangles)
    # A simulation can start: nothing intersects.
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=shirt.mesh)], obstacles=[body()]), threads=1)
    sim.step()


def test_seams_that_stay_open_are_named():
    with pytest.raises(ls.SolverFailure, match="is still .* mm open"):
        g.close_seams(g.tshirt_pattern(), triangles=300, places=apart(0.3), longest=0.02, threads=1)


def test_seams_that_are_shut_already_stay_shut(tmp_path):
    content = skirt(gap=16.0)
    halves = content["pattern"]["panels"]
    # The front consists of two halves that touch from the start.
    for name, shift in (("front_left", -10.0), ("front_right", 10.0)):
        halves[name] = rectangle((shift, 100, 8.0), width=20.0)
    del halves["front"]
    content["pattern"]["stitches"] = [
        [{"panel": "front_left", "edge": 1}, {"panel": "front_right", "edge": 3}],
        [{"panel": "front_right", "edge": 1}, {"panel": "back", "edge": 3}],
        [{"panel": "front_left", "edge": 3}, {"panel": "back", "edge": 1}],
    ]
    closed = g.close_seams(g.read_garmentcode(write(tmp_path, content)), triangles=400, threads=1)
    assert len(closed.openings()) == 2
    assert closed.stretches().max() < 1.1


def test_the_dress_closes_from_13_pieces_that_stand_apart():
    pattern = g.dress_pattern(chord=0.06)
    places = {}
    for panel in pattern.panels:
        middle = panel.place(np.mean([edge.start for edge in panel.edges], axis=0)[None])[0]
        outward = 0.05 * np.array([*middle[:2], 0.0]) / np.hypot(*middle[:2])
        # Skirt, bodice and straps move apart vertically.
        rise = (
            0.0
            if panel.name.startswith("gore")
            else 0.06
            if panel.name.startswith("strap")
            else 0.02
        )
        outward = outward * (not panel.name.startswith("strap")) + (0.0, 0.0, rise)
        places[panel.name] = lambda points, place=panel.place, by=outward: place(points) + by
    dress = g.close_seams(pattern, triangles=900, places=places, threads=1)
    assert len(dress.panel_names) == 13 and len(dress.openings()) == 4
    assert ls.collision.intersecting_pairs(dress.mesh.vertices, dress.mesh.triangles) == []
    assert dress.stretches().min() > 0.9 and dress.stretches().max() < 1.1
