"""All engines find the same candidates on random scenes.

Hypothesis draws the scenes, or the seeds and sizes of larger ones, and shrinks those that fail.
"""

import numpy as np
import pytest
from loomstone import collision

hypothesis = pytest.importorskip("hypothesis")  # in the extra `test` of pyproject.toml
st = hypothesis.strategies


@st.composite
def scenes(draw):
    """Generates a scene that starts on a lattice, so that boxes often touch and features coincide.

    Triangles may be degenerate or identical.
    """
    n = draw(st.integers(4, 14))
    point = st.tuples(*[st.integers(-3, 3)] * 3)
    x0 = np.array(draw(st.lists(point, min_size=n, max_size=n)), float)
    motion = np.array(draw(st.lists(point, min_size=n, max_size=n)), float) * draw(
        st.sampled_from([0.0, 0.1, 1.0])
    )
    corner = st.permutations(range(n)).map(lambda order: order[:3])
    triangles = draw(st.lists(corner, min_size=1, max_size=40))
    scale = draw(st.sampled_from([1.0, 0.1, 1e-9, 1e6]))
    return (
        scale * x0,
        scale * (x0 + motion),
        triangles,
        scale * draw(st.sampled_from([0.0, 0.01, 0.5])),
    )


def pairs(found):
    return [list(map(tuple, each)) for each in found]


@hypothesis.settings(max_examples=300, deadline=None)
@hypothesis.given(scenes())
def test_all_engines_find_the_pairs_of_brute_force(scene):
    x0, x1, triangles, inflation = scene
    expected = pairs(collision.candidates(x0, x1, triangles, inflation, engine="brute-force"))
    for engine in ("clusters", "embree"):
        assert (
            pairs(collision.candidates(x0, x1, triangles, inflation, engine=engine, threads=2))
            == expected
        )


@hypothesis.settings(max_examples=60, deadline=None)
@hypothesis.given(
    st.integers(0, 2**32 - 1),
    st.integers(30, 300),
    st.sampled_from([0.0, 1e-3, 0.02]),
    st.sampled_from([0.01, 0.05, 0.2]),
)
def test_all_engines_find_the_pairs_of_brute_force_among_many_triangles(seed, n, inflation, size):
    """Uses 30 to 300 triangles."""
    random = np.random.default_rng(seed)
    # The centres lie in space, in a plane, on a line or at a point.
    centres = random.random((n, 1, 3)) * random.choice([0.0, 1.0], size=3)
    x0 = (centres + size * random.normal(size=(n, 3, 3))).reshape(-1, 3)
    x1 = x0 + size * random.normal(size=x0.shape)
    triangles = np.arange(3 * n).reshape(n, 3)
    triangles[::3, 0] = triangles[0, 0]  # some triangles share a vertex
    expected = collision.candidates(x0, x1, triangles, inflation, engine="brute-force")
    detector = collision.Detector(triangles, threads=3)
    detector.candidates(random.normal(size=x0.shape), x1)  # builds the tree at other positions
    for found in (
        collision.candidates(x0, x1, triangles, inflation),
        collision.candidates(x0, x1, triangles, inflation, engine="embree"),
        detector.candidates(x0, x1, inflation),
    ):
        assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
