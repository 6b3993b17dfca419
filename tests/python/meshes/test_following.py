"""Points that follow a deforming mesh."""

import loomstone as ls
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

BODY = ls.meshes.capsule(radius=0.08, length=0.4)


def waist(count, radius=0.1):
    """Returns a slanting ring of points around the body (count x 3) [m]."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.c_[radius * np.cos(angle), radius * np.sin(angle), 0.03 * np.sin(angle)]


def bent(points, curvature):
    """Returns points of a bar along z after bending.

    The axis becomes a circular arc in the xz-plane, and the cross-sections of the bar stay plane.
    """
    x, y, z = np.asarray(points).T
    turn = curvature * z
    # The cross-section at z is turned by `turn`. The coordinates x and z of its centre are the
    # integrals of sin(curvature s) and cos(curvature s) over s from 0 to z.
    return np.c_[
        (1 - np.cos(turn)) / curvature + x * np.cos(turn),
        y,
        np.sin(turn) / curvature - x * np.sin(turn),
    ]


def spacing(points):
    return np.linalg.norm(np.roll(points, 1, axis=-2) - points, axis=-1)


def test_points_beside_a_rigidly_moving_body_move_with_it():
    rng = np.random.default_rng(4)
    points = np.vstack([waist(40), rng.uniform(-0.4, 0.4, (40, 3))])
    turns = Rotation.random(5, random_state=rng)
    shifts = rng.uniform(-2, 2, (5, 3))
    frames = [
        turn.apply(np.array(BODY.vertices)) + shift
        for turn, shift in zip(turns, shifts, strict=True)
    ]
    expected = [turn.apply(points) + shift for turn, shift in zip(turns, shifts, strict=True)]
    # The tolerance covers rounding of lengths of a few metres.
    assert ls.obstacles.follow(BODY, frames, points) == pytest.approx(np.array(expected), abs=1e-13)


def test_points_that_only_shift_with_the_nearest_vertex_are_torn_apart_by_a_turn():
    points, turn = waist(100), Rotation.from_rotvec((0, 0, 1.8))
    frame = turn.apply(np.array(BODY.vertices))
    nearest = ls.meshes.nearest_vertices(BODY, points)
    shifted = points + frame[nearest] - BODY.vertices[nearest]
    followed = ls.obstacles.follow(BODY, [frame], points)[0]
    assert (spacing(shifted) / spacing(points)).max() > 1.2
    assert spacing(followed) == pytest.approx(spacing(points), rel=1e-12)


@pytest.mark.parametrize("curvature", [1.0, 4.0])
def test_points_beside_a_bent_body_move_with_its_cross_sections(curvature):
    points = waist(400)
    followed = ls.obstacles.follow(BODY, [bent(BODY.vertices, curvature)], points)[0]
    expected = bent(points, curvature)
    # The patch of triangles that a point follows reaches 0.04 m from its centre. At its border, a
    # bent axis deviates from its tangent by 0.0008 m^2 times the curvature. The fit averages over
    # the patch and weights its border less.
    assert np.abs(followed - expected).max() < 2e-4 * curvature
    # The points are ten times as close to each other as the vertices of the body are.
    assert spacing(followed) == pytest.approx(spacing(expected), rel=0.02 * curvature)


def test_points_beside_a_bent_body_keep_their_distance_from_it():
    frame = bent(BODY.vertices, 4.0)
    followed = ls.obstacles.follow(BODY, [frame], waist(40))[0]
    query = ls.meshes.SpatialQuery(ls.TriangleMesh(frame, BODY.triangles))
    distances = [query.closest(point, 0.05).distance for point in followed]
    # The facets of the body lie up to 0.0004 m inside the cylinder that they approximate. The fit
    # is as accurate as in the preceding test.
    assert distances == pytest.approx(np.full(40, 0.02), abs=1e-3)


def test_points_follow_the_rows_of_an_obstacle(tmp_path):
    frames = np.array([bent(BODY.vertices, curvature) for curvature in (0.5, 1.0, 2.0)])
    np.savez(tmp_path / "body.npz", positions=frames, times=[0.0, 0.1, 0.2])
    body = ls.obstacles.sequence(tmp_path / "body.npz", mesh=BODY)
    points = waist(20)
    followed = ls.obstacles.follow(body.mesh, body.vertex_positions, points)
    assert followed.shape == (3, 20, 3)
    assert followed[0] == pytest.approx(points, abs=1e-14)
    assert np.array_equal(followed, ls.obstacles.follow(body.mesh, frames, points))


def test_a_mesh_may_have_a_single_triangle_and_there_may_be_no_points():
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    mesh = ls.TriangleMesh(corners, [[0, 1, 2]])
    turn = Rotation.from_rotvec((0.3, 0.2, 0.1))
    points = [(0.2, 0.2, 0.1), (3.0, -1.0, 0.0)]
    followed = ls.obstacles.follow(mesh, [turn.apply(corners)], points)[0]
    assert followed == pytest.approx(turn.apply(points), abs=1e-14)
    assert ls.obstacles.follow(mesh, [corners], np.empty((0, 3))).shape == (1, 0, 3)


@pytest.mark.parametrize(
    ("frames", "points", "said"),
    [
        (
            [BODY.vertices],
            (0, 0, 0),
            r"points must have the shape \(points x 3\) \[m\], got \(3,\)",
        ),
        ([BODY.vertices], [(0, 0, np.nan)], "points must be finite numbers"),
        (
            [BODY.vertices[:-1]],
            waist(4),
            r"one row per vertex .* x 1300 x 3\) \[m\], got \(1, 1299",
        ),
        (BODY.vertices[:-1], waist(4), r"one row per vertex .* got \(1299, 3\)"),
        ([BODY.vertices * np.nan], waist(4), "frames must be finite numbers"),
    ],
)
def test_what_is_wrong_with_frames_or_points_is_one_sentence(frames, points, said):
    with pytest.raises(ls.InvalidInput, match=said):
        ls.obstacles.follow(BODY, frames, points)
