"""Collision queries on arrays: exact continuous tests against rational arithmetic of another kind."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

import loomstone as ls
from loomstone import collision


def polynomial_product(a, b):
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return product


def value(p, t):
    result = Fraction(0)
    for c in reversed(p):
        result = result * t + c
    return result


def linear_combination(*terms):
    length = max(len(p) for _, p in terms)
    return [sum((f * p[i] for f, p in terms if i < len(p)), Fraction(0)) for i in range(length)]


def cross(a, b):
    following = ((1, 2), (2, 0), (0, 1))
    return [linear_combination((1, polynomial_product(a[i], b[j])), (-1, polynomial_product(a[j], b[i]))) for i, j in following]


def dot(a, b):
    return linear_combination(*((1, polynomial_product(x, y)) for x, y in zip(a, b)))


def derivative(p):
    return [k * c for k, c in enumerate(p)][1:] or [Fraction(0)]


# Times are found to 2^-220. For the small whole numbers used here a polynomial of degree <= 4 that is not zero at a root of
# another one is above 1e-40 there (their resultant is a whole number), so smaller values are zeros.
FINE, ZERO = 220, Fraction(1, 10**40)


def roots(p):
    """Roots in [0, 1], by bisection between the roots of the derivative."""
    if all(c == 0 for c in p):
        return []
    if len(p) == 1:
        return []
    marks = [Fraction(0), *sorted(roots(derivative(p))), Fraction(1)]
    found = [t for t in marks if abs(value(p, t)) < ZERO]
    for low, high in zip(marks, marks[1:]):
        a, b = value(p, low), value(p, high)
        if abs(a) < ZERO or abs(b) < ZERO or (a > 0) == (b > 0):
            continue
        for _ in range(FINE):
            middle = (low + high) / 2
            if (value(p, middle) > 0) == (a > 0):
                low = middle
            else:
                high = middle
        found.append((low + high) / 2)
    return found


def sign(p, t):
    x = value(p, t)
    return 0 if abs(x) < ZERO else 1 if x > 0 else -1


def hull_holds_origin(corners, t):
    """Is the origin in the convex hull of corners that lie in one plane with it at t? By Caratheodory's theorem."""
    if any(sign(dot(a, a), t) == 0 for a in corners):
        return True
    for a, b in combinations(corners, 2):
        if sign(dot(a, b), t) < 0 and all(sign(c, t) == 0 for c in cross(a, b)):
            return True
    for a, b, c in combinations(corners, 3):
        normals = cross(a, b), cross(b, c), cross(c, a)
        if all(sign(dot(n, m), t) > 0 for n, m in combinations(normals, 2)):
            return True
    return False


def meets(kind, query):
    points = [[[Fraction(int(a)), Fraction(int(b - a))] for a, b in zip(start, end)] for start, end in zip(query[:4], query[4:])]
    pairs = [(0, 1), (0, 2), (0, 3)] if kind == "vertex-face" else [(0, 2), (1, 2), (0, 3), (1, 3)]
    corners = [[linear_combination((1, points[i][k]), (-1, points[j][k])) for k in range(3)] for i, j in pairs]
    volume = dot(corners[0], cross(corners[1], corners[2]))
    if any(volume):
        return any(hull_holds_origin(corners, t) for t in roots(volume))
    events = [c for corner in corners for c in corner] + [c for a, b in combinations(corners, 2) for c in cross(a, b)]
    times = {Fraction(0), Fraction(1)}.union(*(roots(p) for p in events))
    return any(hull_holds_origin(corners, t) for t in times)


@pytest.mark.parametrize("kind", ["vertex-face", "edge-edge"])
def test_verdicts_are_those_of_rational_arithmetic(kind):
    random = np.random.default_rng(3)
    queries = random.integers(-2, 3, size=(90, 8, 3)).astype(float)
    queries[::5, :, 2] = 0.0  # within one plane
    hit, _ = collision.continuous(kind, queries)
    truth = [meets(kind, query) for query in queries]
    assert 20 < sum(truth) < 80
    assert hit.tolist() == truth


def test_continuous_gives_a_time_before_the_contact_and_names_bad_input():
    face = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    queries = np.array([[[0.25, 0.25, 1], *face, [0.25, 0.25, -1], *face], [[2, 2, 1], *face, [2, 2, -1], *face]], float)
    hit, time = collision.continuous("vertex-face", queries)
    assert hit.tolist() == [True, False]
    assert 0.5 - 1e-6 < time[0] <= 0.5 and time[1] == np.inf
    with pytest.raises(ls.InvalidInput, match='kind must be "vertex-face" or "edge-edge", got "face"'):
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
    found = [collision.candidates(x0, x1, mesh.triangles, engine=e, threads=2) for e in ("clusters", "embree", "brute-force")]
    assert len(found[0][0]) > 100 and len(found[0][1]) > 50
    for vertex_face, edge_edge in found[1:]:
        assert np.array_equal(vertex_face, found[0][0]) and np.array_equal(edge_edge, found[0][1])
    more = collision.candidates(x0, x1, mesh.triangles, inflation=1e-3)
    assert {*map(tuple, found[0][1])} < {*map(tuple, more[1])}
    with pytest.raises(ls.InvalidInput, match='engine must be "clusters", "embree" or "brute-force", got "bvh"'):
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
            assert np.array_equal(found.vertex_face, expected[0][0]) and np.array_equal(found.edge_edge, expected[1][0])
            assert np.array_equal(found.vertex_face_time, expected[0][1]) and np.array_equal(found.edge_edge_time, expected[1][1])
            assert found.time == min(expected[0][1].min(), expected[1][1].min())
            named = detector.candidates(x0, x1)
            assert np.array_equal(named[0], vertex_face) and np.array_equal(named[1], edge_edge)
            unordered = detector.candidates(x0, x1, ordered=False)
            assert np.array_equal(np.array(sorted(map(tuple, unordered[1]))), edge_edge)
        x0, x1 = x1, x1 + random.normal(scale=0.005, size=x0.shape)
    assert 0 < detector.tree_bytes < 600 * len(triangles)  # half empty at this size; large meshes take about 340
    flat = ls.grid(size=(0.2, 0.2), triangles=200)
    free = collision.Detector(flat.triangles).collisions(flat.vertices, flat.vertices + [0.0, 0.0, 0.1])
    assert len(free) == 0 and free.time == np.inf


def test_a_detector_names_bad_input():
    triangles, x0, x1 = crumpled(np.random.default_rng(7))
    detector = collision.Detector(triangles)
    with pytest.raises(ls.InvalidInput, match="triangles must hold vertices 0 to 99"):
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
