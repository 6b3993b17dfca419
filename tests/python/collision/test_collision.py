"""Collision queries on arrays, compared with exact integer arithmetic and with brute force."""

from fractions import Fraction

import loomstone as ls
import numpy as np
import pytest
from exact_queries import FAMILIES, degenerate_queries, exact_verdict
from loomstone import collision


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("kind", ["vertex-face", "edge-edge"])
def test_verdicts_of_degenerate_queries_are_exact_and_times_are_not_late(kind, family):
    """tests/benchmarks/exact_verdicts.py tests a million queries in the same way."""
    queries = degenerate_queries(np.random.default_rng(11), kind, family, 100)
    hit, time = collision.continuous(kind, queries)
    exact = [exact_verdict(kind, query) for query in queries]
    assert hit.tolist() == [contact is not None for contact in exact]
    assert all(
        Fraction(float(t)) <= contact
        for t, contact in zip(time, exact, strict=True)
        if contact is not None
    )


@pytest.mark.parametrize("kind", ["vertex-face", "edge-edge"])
def test_verdicts_are_those_of_rational_arithmetic(kind):
    random = np.random.default_rng(3)
    queries = random.integers(-2, 3, size=(90, 8, 3)).astype(float)
    queries[::5, :, 2] = 0.0  # these queries lie in a plane
    hit, _ = collision.continuous(kind, queries)
    truth = [exact_verdict(kind, query) is not None for query in queries]
    assert 20 < sum(truth) < 80
    assert hit.tolist() == truth


def test_continuous_gives_a_time_before_the_contact_and_names_bad_input():
    face = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    queries = np.array(
        [[[0.25, 0.25, 1], *face, [0.25, 0.25, -1], *face], [[2, 2, 1], *face, [2, 2, -1], *face]],
        float,
    )
    hit, time = collision.continuous("vertex-face", queries)
    assert hit.tolist() == [True, False]
    assert 0.5 - 1e-6 < time[0] <= 0.5 and time[1] == np.inf
    with pytest.raises(
        ls.InvalidInput, match='kind must be "vertex-face" or "edge-edge", got "face"'
    ):
        collision.continuous("face", queries)
    with pytest.raises(ls.InvalidInput, match=r"queries must have shape \(n, 8, 3\), got \(4, 6\)"):
        collision.continuous("edge-edge", np.zeros((4, 6)))
    queries[1, 3, 0] = np.nan
    with pytest.raises(ls.InvalidInput, match="query 1 is not"):
        collision.continuous("edge-edge", queries)


def test_candidates_of_all_engines_and_their_bad_input():
    mesh = ls.grid(size=(0.2, 0.2), triangles=200)
    random = np.random.default_rng(4)
    x0 = mesh.vertices + random.normal(scale=0.02, size=mesh.vertices.shape)
    x1 = x0 + random.normal(scale=0.005, size=x0.shape)
    found = [
        collision.candidates(x0, x1, mesh.triangles, engine=e, threads=2)
        for e in ("clusters", "embree", "brute-force")
    ]
    assert len(found[0][0]) > 100 and len(found[0][1]) > 50
    for vertex_face, edge_edge in found[1:]:
        assert np.array_equal(vertex_face, found[0][0]) and np.array_equal(edge_edge, found[0][1])
    more = collision.candidates(x0, x1, mesh.triangles, inflation=1e-3)
    assert {*map(tuple, found[0][1])} < {*map(tuple, more[1])}
    with pytest.raises(
        ls.InvalidInput, match='engine must be "clusters", "embree" or "brute-force", got "bvh"'
    ):
        collision.candidates(x0, x1, mesh.triangles, engine="bvh")
    with pytest.raises(ls.InvalidInput, match="triangle 1 has 500"):
        collision.candidates(x0, x1, [[0, 1, 2], [0, 1, 500]])
    with pytest.raises(ls.InvalidInput, match="x1 must have as many rows"):
        collision.candidates(x0, x1[:-1], mesh.triangles)
    with pytest.raises(ls.InvalidInput, match="inflation must be at least 0 m"):
        collision.candidates(x0, x1, mesh.triangles, inflation=-1.0)
    x1[7, 1] = np.nan
    with pytest.raises(ls.InvalidInput, match="vertex 7 is not"):
        collision.candidates(x0, x1, mesh.triangles)


def crumpled(random, triangles=200, noise=0.02):
    mesh = ls.grid(size=(0.2, 0.2), triangles=triangles)
    x0 = mesh.vertices + random.normal(scale=noise, size=mesh.vertices.shape)
    return mesh.triangles, x0, x0 + random.normal(scale=noise / 4, size=x0.shape)


def queries_of(x0, x1, triangles, edges, vertex_face, edge_edge):
    corners = np.hstack([vertex_face[:, :1], triangles[vertex_face[:, 1]]])
    ends = np.hstack([edges[edge_edge[:, 0]], edges[edge_edge[:, 1]]])
    return [np.concatenate([x0[v], x1[v]], axis=1) for v in (corners, ends)]


def test_a_detector_finds_exactly_the_colliding_pairs_whatever_its_tree_and_threads():
    random = np.random.default_rng(6)
    triangles, x0, x1 = crumpled(random)
    lasting = {threads: collision.Detector(triangles, threads=threads) for threads in (1, 3)}
    for _ in range(3):
        vertex_face, edge_edge = collision.candidates(x0, x1, triangles, engine="brute-force")
        edges = lasting[1].edges
        expected = [
            (pairs[hit], time[hit])
            for kind, pairs, queries in zip(
                ("vertex-face", "edge-edge"),
                (vertex_face, edge_edge),
                queries_of(x0, x1, triangles, edges, vertex_face, edge_edge),
                strict=True,
            )
            for hit, time in [collision.continuous(kind, queries)]
        ]
        lasting[3].forget_trees()
        for detector in (*lasting.values(), collision.Detector(triangles, threads=2)):
            found = detector.collisions(x0, x1)
            assert len(found) == len(expected[0][0]) + len(expected[1][0]) > 50
            assert np.array_equal(found.vertex_face, expected[0][0]) and np.array_equal(
                found.edge_edge, expected[1][0]
            )
            assert np.array_equal(found.vertex_face_time, expected[0][1]) and np.array_equal(
                found.edge_edge_time, expected[1][1]
            )
            assert found.time == min(expected[0][1].min(), expected[1][1].min())
            named = detector.candidates(x0, x1)
            assert np.array_equal(named[0], vertex_face) and np.array_equal(named[1], edge_edge)
            unordered = detector.candidates(x0, x1, ordered=False)
            assert np.array_equal(np.array(sorted(map(tuple, unordered[1]))), edge_edge)
        x0, x1 = x1, x1 + random.normal(scale=0.005, size=x0.shape)
    # The tree takes a few hundred bytes per triangle.
    assert 0 < detector.tree_bytes < 600 * len(triangles)
    flat = ls.grid(size=(0.2, 0.2), triangles=200)
    free = collision.Detector(flat.triangles).collisions(
        flat.vertices, flat.vertices + [0.0, 0.0, 0.1]
    )
    assert len(free) == 0 and free.time == np.inf


def test_a_detector_names_bad_input():
    triangles, x0, x1 = crumpled(np.random.default_rng(7))
    detector = collision.Detector(triangles)
    with pytest.raises(ls.InvalidInput, match=r"triangles must hold vertex indices in \[0, 100\)"):
        detector.collisions(x0[:100], x1[:100])
    with pytest.raises(ls.InvalidInput, match="x1 must have as many rows"):
        detector.candidates(x0, x1[:-1])
    with pytest.raises(ls.InvalidInput, match="triangle 0 has -1"):
        collision.Detector([[0, 1, -1]])
    with pytest.raises(ls.InvalidInput, match="threads must be at least 0, got -1"):
        collision.Detector(triangles, threads=-1)
    x0[3] = np.inf
    with pytest.raises(ls.InvalidInput, match="vertex 3 is not"):
        detector.collisions(x0, x1)


def test_points_that_are_not_finite_are_refused():
    points = np.zeros((6, 3))
    points[4, 1] = np.nan
    with pytest.raises(ls.InvalidInput, match="points must be finite, but row 4 is not"):
        ls.collision.intersecting_pairs(points, [[0, 1, 2], [3, 4, 5]])
