"""Garments: panels, seams, and sewn meshes with the pattern as uv."""

import loomstone as ls
import numpy as np
import pytest

g = ls.garments


def square(name: str = "square", size: float = 0.3, **more: object) -> g.Panel:
    corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)]
    return g.Panel.polygon(name, corners, names=("hem", "right", "top", "left"), **more)


def flat_area(garment: g.Garment) -> float:
    e, f = (garment.flat_corners()[:, i] - garment.flat_corners()[:, 0] for i in (1, 2))
    return float(np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]).sum() / 2)


def euler(mesh: ls.TriangleMesh) -> int:
    triangles = np.asarray(mesh.triangles)
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.unique(np.sort(half, axis=1), axis=0)
    return mesh.n_vertices - len(edges) + mesh.n_triangles


@pytest.fixture(scope="module")
def dress() -> g.Garment:
    return g.dress()


@pytest.fixture(scope="module")
def tshirt() -> g.Garment:
    return g.tshirt(1500)


nan = float("nan")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: g.polyline("a", [(0, 0, 0), (1, 1, 1)]), "edge 'a' needs .* two finite numbers"),
        (
            lambda: g.polyline("a", np.array([(0, 0), (nan, 1)])),
            r"got \[\[0.0, 0.0\], \[nan, 1.0\]\]",
        ),
        (lambda: g.polyline("a", [(0.25, 0), (0.25, 0)]), r"all its points are \(0.25, 0\)"),
        (lambda: g.Panel.polygon("p", [(0, 0), (1, nan), (1, 1)], names="abc"), "edge 'a' needs"),
        (lambda: g.Panel.polygon("p", [(0, 0), (1, 0), (1, 0)], names="abc"), "'b' has no length"),
        (lambda: g.Panel("p", 3), "panel 'p': edges must be created with line, .* got 3"),
        (lambda: square().placed(3), "place must be a Placement or a function, got 3"),
        (lambda: g.garment(3, triangles=50), r"at least one Panel, got \(3,\)"),
        (lambda: g.garment([square()], 3, triangles=50), "seams must be a list of seams, got 3"),
        (lambda: g.garment([square()], [3], triangles=50), "a seam must be a Seam or two names"),
        (lambda: g.close_seams([square()], triangles=50), "close_seams needs a Pattern, got"),
    ],
)
def test_arguments_of_another_kind_are_refused_by_name(make, message):
    with pytest.raises(ls.InvalidInput, match=message):
        make()


def test_panels_may_come_from_a_generator():
    assert g.garment((square(name) for name in ["one"]), triangles=50).mesh.n_triangles == 50


def test_curves_have_the_lengths_of_their_closed_forms():
    assert g.line("a", (0, 0), (0.3, 0.4)).length == pytest.approx(0.5, rel=1e-15)
    # 512 chords of a half circle are too short by the fraction (pi / 512)^2 / 24 = 1.6e-6.
    assert g.arc("a", (0.1, 0), (0, 0.1), (-0.1, 0)).length == pytest.approx(0.1 * np.pi, rel=2e-6)
    assert g.arc("a", (0.1, 0), (0, -0.1), (0, 0.1)).length == pytest.approx(
        0.1 * 1.5 * np.pi, rel=2e-5
    )
    # y = x (1 - x) as a Bezier curve has length sqrt(2)/2 + asinh(1)/2.
    parabola = g.quadratic("a", (0, 0), (0.5, 0.5), (1, 0))
    assert parabola.length == pytest.approx(np.sqrt(0.5) + np.arcsinh(1) / 2, rel=2e-6)
    # A parabola elevated to degree three is the same curve.
    raised = g.cubic("a", (0, 0), (1 / 3, 1 / 3), (2 / 3, 1 / 3), (1, 0))
    assert np.allclose(raised.curve(), parabola.curve(), atol=1e-15)


def test_points_divide_an_edge_evenly_by_length():
    edge = g.cubic("a", (0, 0), (0.01, 0.3), (0.3, 0.3), (0.4, 0))
    steps = np.linalg.norm(np.diff(edge.sampled(400), axis=0), axis=1)
    assert steps.max() / steps.min() < 1.01


def test_a_mirrored_panel_keeps_area_and_names_and_turns_its_grain():
    panel = g.dress_pattern().panel("front").mirrored("other")
    assert panel.area == pytest.approx(g.dress_pattern().panel("front").area, rel=1e-12)
    assert panel.edge("left").length == pytest.approx(g.dress_pattern().edge("front.left").length)
    assert square(grain_degrees=30.0).mirrored("m").grain_degrees == -30.0


@pytest.mark.parametrize("triangles", [40, 300, 2500])
@pytest.mark.parametrize("seed", [1, 2])
def test_panels_with_notches_and_curves_have_no_angle_below_25_degrees(triangles, seed):
    outline = (
        *(
            g.line(n, a, b)
            for n, a, b in [("hem_a", (0, 0), (0.2, 0)), ("dart_a", (0.2, 0), (0.225, 0.15))]
        ),
        *(
            g.line(n, a, b)
            for n, a, b in [("dart_b", (0.225, 0.15), (0.25, 0)), ("hem_b", (0.25, 0), (0.5, 0))]
        ),
        g.line("right", (0.5, 0), (0.5, 0.4)),
        g.quadratic("armhole", (0.5, 0.4), (0.4, 0.42), (0.42, 0.6)),
        g.line("shoulder", (0.42, 0.6), (0.33, 0.63)),
        g.arc("neck", (0.33, 0.63), (0.25, 0.55), (0.17, 0.63)),
        g.line("other_shoulder", (0.17, 0.63), (0.0, 0.6)),
        g.line("left", (0.0, 0.6), (0.0, 0.0)),
    )
    panel = g.Panel("front", outline)
    garment = ls.garment([panel], triangles=triangles, seed=seed)
    assert garment.min_angle_degrees() > 25.0
    assert abs(garment.mesh.n_triangles - triangles) <= 2
    edge = np.sqrt(panel.area / triangles)
    assert flat_area(garment) == pytest.approx(panel.area, abs=2.0 * edge**2), "chords of curves"


def test_sharp_corners_of_the_outline_limit_the_angles():
    panel = g.Panel.polygon("sharp", [(0, 0), (0.5, 0), (0, 0.15)], names="abc")
    corner = np.degrees(np.arctan2(0.15, 0.5))
    # No mesh can avoid the small angle, because the sampled outline keeps the sharp corner.
    assert ls.garment([panel], triangles=400).min_angle_degrees() > corner - 1.0


def test_holes_are_cut_exactly_and_leave_good_triangles():
    eyelets = [g.circle(f"eyelet_{i}", (0.06 + 0.18 * i, 0.25), 0.03) for i in range(2)]
    window = [
        g.arc("arch", (0.1, 0.1), (0.15, 0.15), (0.2, 0.1)),
        g.line("sill", (0.2, 0.1), (0.1, 0.1)),
    ]
    panel = square(holes=[*eyelets, window])
    assert panel.area == pytest.approx(0.09 - 2 * np.pi * 0.03**2 - np.pi * 0.05**2 / 2, rel=1e-5)
    for triangles in (400, 1000):
        garment = ls.garment([panel], triangles=triangles)
        assert abs(garment.mesh.n_triangles - triangles) <= 2
        assert garment.min_angle_degrees() > 25.0
        assert euler(garment.mesh) == 1 - 3
        # Chords of length h on curves with a total turn of 5 pi make the holes smaller by a total
        # area of 5 pi h^2 / 12. Rounding to a whole number of chords changes h by at most a tenth.
        edge2 = panel.area / triangles * 4 / np.sqrt(3)
        assert flat_area(garment) == pytest.approx(panel.area, abs=1.2 * 5 * np.pi / 12 * edge2)
        loops = {tuple(sorted(loop)) for loop in garment.openings()}
        for names in (["eyelet_0"], ["eyelet_1"], ["arch", "sill"]):
            assert tuple(garment.group(*(f"square.{name}" for name in names))) in loops
    at = np.asarray(garment.mesh.vertices)[garment.group("square.eyelet_1")][:, [0, 2]]
    assert np.linalg.norm(at - (0.24, 0.25), axis=1) == pytest.approx(0.03, rel=1e-4), (
        "vertices lie on the circle"
    )


def test_a_sleeve_is_sewn_into_a_hole():
    radius = 0.05
    body = g.Panel.polygon(
        "body",
        [(-0.15, -0.15), (0.15, -0.15), (0.15, 0.15), (-0.15, 0.15)],
        names=("hem", "right", "top", "left"),
        place=lambda points: np.c_[points, np.zeros(len(points))],
        holes=[g.circle("armhole", (0, 0), radius)],
    )
    round_ = 2 * np.pi * radius
    tube = g.Panel.polygon(
        "sleeve",
        [(-round_ / 2, 0), (round_ / 2, 0), (round_ / 2, 0.1), (-round_ / 2, 0.1)],
        names=("cap", "under", "cuff", "over"),
        place=g.Cylinder(radius=radius, angle_degrees=-90.0),
    )
    garment = ls.garment(
        [body, tube],
        [("body.armhole", "sleeve.cap"), ("sleeve.under", "sleeve.over")],
        triangles=500,
    )
    assert len(garment.openings()) == 2, "the outline and the cuff"
    assert euler(garment.mesh) == 2 - 2
    assert sorted(garment.groups["body.armhole"][:-1]) == sorted(garment.groups["sleeve.cap"][:-1])


def test_mirrored_panels_keep_their_holes():
    panel = square(holes=[g.circle("eyelet", (0.1, 0.2), 0.03)])
    other = panel.mirrored("other")
    assert other.area == pytest.approx(panel.area, rel=1e-12)
    assert other.edge("eyelet").curve().mean(0) == pytest.approx((-0.1, 0.2), abs=1e-3)


def test_an_edge_that_gives_too_many_triangles_is_refused():
    with pytest.raises(ls.InvalidInput, match=r"edge must be at least .* 10000000 triangles, got"):
        ls.garment([square()], edge=1e-6)


def test_a_hole_that_crosses_the_last_of_many_chords_is_refused():
    angle = np.linspace(np.pi, 0.0, 129)
    arc = np.c_[0.15 + 0.08 * np.cos(angle), 0.1 + 0.08 * np.sin(angle)]
    # The 129th chord is the diameter, on which the circle is centred.
    half = g.polyline("half", np.r_[arc, arc[:1]])
    with pytest.raises(ls.InvalidInput, match="edges 'half' and 'dot' cross or touch"):
        square(holes=[[half], g.circle("dot", (0.15, 0.1), 0.01)])


@pytest.mark.parametrize(
    ("holes", "message"),
    [
        ([g.circle("eyelet", (0.29, 0.1), 0.02)], "edges 'right' and 'eyelet' cross or touch"),
        (
            [g.circle("a", (0.1, 0.1), 0.04), g.circle("b", (0.15, 0.1), 0.04)],
            "edges 'a' and 'b' cross or touch",
        ),
        (
            [g.circle("a", (0.1, 0.1), 0.02), g.circle("b", (0.1, 0.1), 0.04)],
            "hole 'a' lies within hole 'b'",
        ),
        ([g.circle("a", (0.5, 0.1), 0.02)], "hole 'a' lies outside the outline"),
        ([g.circle("hem", (0.1, 0.1), 0.02)], "two edges 'hem'"),
        (
            [[g.line("a", (0.1, 0.1), (0.2, 0.1)), g.line("b", (0.2, 0.1), (0.2, 0.2))]],
            "hole 'a' is open: edge 'b'",
        ),
        (
            [[g.polyline("a", [(0.1, 0.1), (0.2, 0.1), (0.2, 0.2), (0.1, 0.1)])]],
            "hole 'a' runs counter-clockwise",
        ),
        ([[g.polyline("a", [(0.1, 0.1), (0.2, 0.1), (0.1, 0.1)])]], "edge 'a' crosses itself"),
        ([[]], "edges must be created with"),
        ([[g.circle("a", (0.1, 0.1), 0.02), 3]], "edges must be created with"),
    ],
)
def test_holes_that_cannot_be_cut_are_refused(holes, message):
    with pytest.raises(ls.InvalidInput, match=message):
        square(holes=holes)


@pytest.mark.parametrize(
    ("centre", "radius"), [((0, 0), 0.0), ((0, 0), "x"), ((0,), 1.0), ((0, np.nan), 1.0)]
)
def test_a_circle_needs_a_centre_and_a_radius(centre, radius):
    with pytest.raises(
        ls.InvalidInput, match="circle 'a' needs a centre of two numbers and a radius > 0"
    ):
        g.circle("a", centre, radius)


def test_the_dress_has_13_panels_8900_triangles_and_four_openings(dress):
    assert len(dress.panel_names) == 13
    assert abs(dress.mesh.n_triangles - 8900) <= 13
    assert len(dress.openings()) == 4, "neck, two armholes, hem"
    assert euler(dress.mesh) == 2 - 4
    assert dress.min_angle_degrees() > 25.0
    assert len(dress.groups["strap_left"]) > 20


def test_the_tshirt_has_four_openings(tshirt):
    assert tshirt.panel_names == ("front", "back", "sleeve_right", "sleeve_left")
    assert len(tshirt.openings()) == 4, "neck, hem, two sleeves"
    assert euler(tshirt.mesh) == 2 - 4
    assert tshirt.min_angle_degrees() > 25.0


def test_both_start_free_of_intersections_and_nearly_free_of_strain(dress, tshirt):
    # Cones and straight straps are developable, so the dress is hardly strained. The sleeve caps of
    # the T-shirt are as long as the armholes, but curve differently.
    for garment, most in ((dress, 1.04), (tshirt, 1.06)):
        assert ls.collision.intersecting_pairs(garment.mesh.vertices, garment.mesh.triangles) == []
        assert 1 / most < garment.stretches().min() and garment.stretches().max() < most


def test_the_pattern_keeps_its_areas_and_the_lengths_of_its_seams(dress):
    pattern = dress.cut.pattern
    edge = dress.mesh.mean_edge
    for index, panel in enumerate(pattern.panels):
        e, f = (dress.flat_corners()[dress.panel_of_triangle == index][:, i] for i in (1, 2))
        o = dress.flat_corners()[dress.panel_of_triangle == index][:, 0]
        area = np.abs((e - o)[:, 0] * (f - o)[:, 1] - (e - o)[:, 1] * (f - o)[:, 0]).sum() / 2
        # A chord of length h cuts an area of h^3 / (12 r) off a curve of radius r >= 0.1 m.
        around = sum(side.length for side in panel.edges)
        assert area == pytest.approx(panel.area, abs=around * edge**2 / (12 * 0.1))
    for seam in pattern.seams:
        a, b = (pattern.edge(name).length for name in (seam.first, seam.second))
        assert a == pytest.approx(b, rel=0.01), str(seam)
        assert sorted(dress.groups[seam.first]) == sorted(dress.groups[seam.second]), (
            "one row of vertices"
        )


def test_panels_meet_along_seams_with_different_uv(dress):
    corners = dress.flat_corners()
    of_vertex: dict[int, set[tuple[float, float]]] = {}
    for t, triangle in enumerate(np.asarray(dress.mesh.triangles)):
        for c, v in enumerate(triangle):
            of_vertex.setdefault(int(v), set()).add(tuple(corners[t, c]))
    for name in ("front.right", "gore_1.waist"):
        assert all(len(of_vertex[int(v)]) >= 2 for v in dress.groups[name])
    # Panels and seams are recovered from uv alone.
    again = g.sewn(dress.mesh)
    assert len(again.panel_names) == 13
    found, sewn = ({tuple(sorted(e)) for e in of.seam_edges.tolist()} for of in (again, dress))
    assert found == sewn


def test_the_same_seed_gives_the_same_garment():
    a, b, c = g.dress(900), g.dress(900), g.dress(900, seed=2)
    assert np.array_equal(a.mesh.vertices, b.mesh.vertices) and np.array_equal(
        a.mesh.triangles, b.mesh.triangles
    )
    assert not np.array_equal(a.mesh.triangles, c.mesh.triangles)


def test_the_grain_turns_weft_and_warp():
    flat = ls.garment([square()], triangles=50)
    turned = ls.garment([square(grain_degrees=90.0)], triangles=50)
    # The warp runs along -x of the panel, so the pattern is the panel rotated clockwise by
    # 90 degrees.
    u, v = np.asarray(flat.mesh.uv).T
    assert np.allclose(np.sort(np.asarray(turned.mesh.uv)[:, 0]), np.sort(v), atol=1e-12)
    assert np.allclose(np.sort(np.asarray(turned.mesh.uv)[:, 1]), np.sort(u.max() - u), atol=1e-12)


def test_a_dart_closes_and_takes_its_angle_out():
    half = 0.04
    corners = [(-0.2, 0), (-half, 0), (0, 0.2), (half, 0), (0.2, 0), (0.2, 0.4), (-0.2, 0.4)]
    names = ("hem_left", "dart_left", "dart_right", "hem_right", "right", "top", "left")
    panel = g.Panel.polygon("front", corners, names=names)
    garment = ls.garment([panel], [("front.dart_left", "front.dart_right")], triangles=600)
    assert len(garment.openings()) == 1 and euler(garment.mesh) == 1
    tip = int(garment.groups["front.dart_left"][-1])
    vertices = np.asarray(garment.mesh.vertices)
    around = [
        float(np.degrees(np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))))
        for t in np.asarray(garment.mesh.triangles)
        if tip in t
        for a, b in [[vertices[v] - vertices[tip] for v in t if v != tip]]
    ]
    # The garment stays flat, so its angles at the tip add up to 360 degrees. The angle of the dart
    # turns into strain.
    assert sum(around) == pytest.approx(360.0, abs=1e-6)
    corners_at_tip = garment.flat_corners()[(np.asarray(garment.mesh.triangles) == tip).any(1)]
    assert len(corners_at_tip) == len(around)


def test_a_tube_hangs_together_with_a_seam_to_itself():
    panel = square("tube", place=g.Cylinder(radius=0.3 / (2 * np.pi)))
    tube = ls.garment([panel], [("tube.left", "tube.right")], triangles=400)
    assert len(tube.openings()) == 2 and euler(tube.mesh) == 0
    # A chord of length h is shorter than its arc by the fraction (h / r)^2 / 24, here 1 %.
    assert tube.stretches().min() > 0.985


def test_a_seam_between_insides_turns_a_panel_over():
    a = square("a")
    b = square("b", place=g.Plane(origin=(0.0, 0.1, 0.0)))  # also faces -y
    garment = ls.garment([a, b], [g.Seam("a.right", "b.right")], triangles=200, relax=0)
    assert len(garment.openings()) == 1, "one surface with one outside"


MISTAKES = {
    "panel 'p' is open: edge 'a' ends": lambda: g.Panel(
        "p", (g.line("a", (0, 0), (1, 0)), g.line("b", (1, 1), (0, 0)))
    ),
    "panel 'p': edges 'a' and 'c' cross": lambda: g.Panel.polygon(
        "p", [(0, 0), (1, 1), (1, 0), (0, 1)], names="abcd"
    ),
    "panel 'p' runs clockwise": lambda: g.Panel.polygon(
        "p", [(0, 0), (0, 1), (1, 1), (1, 0)], names="abcd"
    ),
    "panel 'p' has two edges 'a'": lambda: g.Panel.polygon(
        "p", [(0, 0), (1, 0), (0, 1)], names="aba"
    ),
    "edge 'a' has no length": lambda: g.line("a", (1, 1), (1, 1)),
    "its three points lie on a line": lambda: g.arc("a", (0, 0), (1, 1), (2, 2)),
    "no edge 'middle'; it has hem, right": lambda: ls.garment(
        [square()], [("square.middle", "square.left")], triangles=50
    ),
    "there is no panel 'round'": lambda: ls.garment(
        [square()], [("round.left", "square.left")], triangles=50
    ),
    "falls into pieces: no seam leads from 'a' to 'b'": lambda: ls.garment(
        [square("a"), square("b")], triangles=50
    ),
    "are 0.3000 m and 0.2000 m long, 33.3 % apart": lambda: ls.garment(
        [square("a"), square("b", 0.2)], [("a.right", "b.left")], triangles=50
    ),
    "is sewn twice": lambda: ls.garment(
        [square("a"), square("b"), square("c")],
        [("a.right", "b.left"), ("a.right", "c.left")],
        triangles=90,
    ),
    "two panels are called 'a'": lambda: ls.garment(
        [square("a"), square("a")], [("a.right", "a.left")], triangles=50
    ),
    "twists the garment into a one-sided surface": lambda: ls.garment(
        [square("a"), square("b")],
        [g.Seam("a.right", "b.left", True), g.Seam("b.right", "a.left", False)],
        triangles=90,
    ),
    "give either triangles or edge": lambda: ls.garment([square()]),
    "no group 'sleeve'": lambda: ls.garment([square()], triangles=50).group("sleeve"),
    "passes through itself": lambda: ls.garment(
        [square("a"), square("b", place=g.Plane((0.1, -0.1, 0.0), (0.0, 1.0, 0.0)))],
        [("a.hem", "b.hem")],
        triangles=90,
        relax=0,
    ),
    "bar_radius must be in [0.015, 0.05] m, got 0.2": lambda: g.dress(900, bar_radius=0.2),
    "bust < waist + 0.8 and hem in (waist, waist + 5 skirt)": lambda: g.dress(900, waist=1.2),
    "triangles must be in [200, 10000000], got 5": lambda: g.dress(5),
    "chest must be in [0.6, 2]": lambda: g.tshirt(chest=3.0),
    "join two corners of one triangle": lambda: ls.garment(
        [g.Panel.polygon("s", [(0, 0), (0.01, 0), (0.01, 1), (0, 1)], names="abcd")],
        [("s.b", "s.d")],
        triangles=60,
    ),
}


@pytest.mark.parametrize("message", MISTAKES, ids=lambda m: m[:40])
def test_a_mistake_is_one_clear_error(message):
    with pytest.raises(ls.InvalidInput) as error:
        MISTAKES[message]()
    assert message in str(error.value)


@pytest.mark.parametrize("triangles", [200, 300, 400])
def test_sewing_keeps_narrow_openings(triangles):
    outline = [(-0.02, 0), (0.02, 0), (0.1, 0.4), (-0.1, 0.4)]
    names = ("cuff", "right", "top", "left")
    front, back = (
        g.Panel.polygon(name, outline, names=names, place=g.Cylinder(radius=0.06, angle_degrees=a))
        for name, a in (("front", -90), ("back", 90))
    )
    seams = [("front.right", "back.left"), ("front.left", "back.right")]
    tube = ls.garment([front, back], seams, triangles=triangles)
    assert len(tube.openings()) == 2
