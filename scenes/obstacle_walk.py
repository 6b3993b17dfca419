"""A figure in a dress walks over two hurdles and up three stairs.

The figure is a closed surface over a skeleton of 21 bones. It takes two steps per second. The balls
of its feet stand still while they bear weight. The dress moves by asynchronous steps; the command
below uses implicit ones instead. Example 4.3 of [Thomaszewski2010] (figures 4.8 and 4.9) has about
the same number of triangles, but a different figure, course and dress.

    loomstone run scenes/obstacle_walk.py --integrator semi-implicit-euler --step 1e-3
"""

from typing import NamedTuple

import loomstone as ls
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

Floats = NDArray[np.float64]

duration = 5.0
rate = 25.0
integrator = ls.Asynchronous(step=2.5e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(2.9, -6.2, 2.0), target=(1.95, 0.0, 1.02), field_of_view_degrees=26.0
    )
)

STEP, SWING, START = 0.5, 0.42, 0.3  # durations of a step and of its swing, start of the walk [s]
CELL = 0.025  # cell size of the grid from which the figure's surface is extracted [m]
SAMPLES = 100  # samples of the motion per second
GROUND = 0.004  # height of the soles above the ground [m]
RISE = 0.17  # height of a stair [m]
RISERS = (2.65, 3.0, 3.35)  # x coordinates of the risers of the stairs [m]
HURDLES, HURDLE = (0.72, 1.72), (0.04, 1.0, 0.18)  # x coordinates and box size of hurdles [m]
# Places of the ankles along the course [m]: first both feet, then the right and left foot in turn
PLACES = (0.0, 0.0, 0.4, 0.9, 1.4, 1.9, 2.4, 2.78, 3.13, 3.48, 3.83)
BALL = np.array((0.10, 0.0, -0.08))  # ball of the foot relative to the ankle [m]
# Height of the axis of the bar over which the dress would hang [m]. The shoulders take the place of
# this bar; their joints are 6 mm lower.
SHOULDER = 1.437
# Largest distance from hip to ankle, as seen from the side [m]. It limits the pelvis's height.
REACH = 0.822
END = 4.6  # x coordinate of the end of the stairs [m]


class Bone(NamedTuple):
    """A joint and the limb that follows it, a cone with round ends, in the initial pose."""

    joint: tuple[float, float, float]  # [m]
    end: tuple[float, float, float]  # [m]
    radius: float  # radius at the joint [m]
    end_radius: float  # radius at the end [m]


def skeleton() -> dict[str, Bone]:
    """Returns the bones of a figure that faces +x with its left side at +y."""
    bones = {
        "pelvis": Bone((0.0, -0.06, 0.93), (0.0, 0.06, 0.93), 0.095, 0.095),
        "waist": Bone((0.0, 0.0, 1.0), (0.0, 0.0, 1.12), 0.10, 0.105),
        "chest": Bone((0.0, 0.0, 1.16), (0.0, 0.0, 1.25), 0.115, 0.13),
        "neck": Bone((0.0, 0.0, 1.42), (0.0, 0.0, 1.54), 0.04, 0.04),
        "head": Bone((0.0, 0.0, 1.59), (0.0, 0.0, 1.67), 0.075, 0.09),
    }
    for side, y in (("left", 1.0), ("right", -1.0)):
        arm = np.array((0.0, 0.5 * y, -0.866))
        shoulder = np.array((0.0, 0.15 * y, SHOULDER - 0.006))
        chain = [tuple(shoulder + length * arm) for length in (0.0, 0.28, 0.53, 0.64)]
        hip, knee, ankle = (0.0, 0.1 * y, 0.91), (0.0, 0.105 * y, 0.49), (0.0, 0.11 * y, 0.08)
        heel, ball, toe = (-0.03, 0.11 * y, 0.046), (0.1, 0.11 * y, 0.042), (0.15, 0.11 * y, 0.04)
        bones |= {
            f"{side} collar": Bone((0.0, 0.02 * y, SHOULDER - 0.006), chain[0], 0.042, 0.042),
            f"{side} arm": Bone(chain[0], chain[1], 0.044, 0.038),
            f"{side} forearm": Bone(chain[1], chain[2], 0.038, 0.03),
            f"{side} hand": Bone(chain[2], chain[3], 0.032, 0.03),
            f"{side} thigh": Bone(hip, knee, 0.075, 0.055),
            f"{side} shank": Bone(knee, ankle, 0.055, 0.038),
            f"{side} foot": Bone(heel, ball, 0.04, 0.036),
            f"{side} toe": Bone(ball, toe, 0.036, 0.034),
        }
    return bones


def distances(points: Floats, bones: dict[str, Bone]) -> Floats:
    """Returns approximate distances (n x bones) [m] of points (n x 3) from bones, < 0 inside."""
    columns = []
    for bone in bones.values():
        joint, along = np.array(bone.joint), np.subtract(bone.end, bone.joint)
        share = np.clip((points - joint) @ along / (along @ along), 0.0, 1.0)
        radius = bone.radius + share * (bone.end_radius - bone.radius)
        columns.append(np.linalg.norm(points - joint - share[:, None] * along, axis=1) - radius)
    return np.stack(columns, axis=1)


def blended(points: Floats, bones: dict[str, Bone]) -> Floats:
    """Returns smooth distances (n) [m] of points from the union of all bones, negative inside."""
    every, smooth = distances(points, bones), 0.01
    least = every.min(axis=1)
    return np.asarray(
        least - smooth * np.log(np.exp((least[:, None] - every) / smooth).sum(axis=1))
    )


def surface(bones: dict[str, Bone]) -> ls.TriangleMesh:
    """Returns a smoothed closed surface around the bones. Before smoothing, its vertices are the
    centres of the grid cells that the surface crosses (surface nets).
    """
    axes = [np.arange(low, high, CELL) for low, high in ((-0.25, 0.3), (-0.7, 0.7), (-0.1, 1.9))]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    inside = (blended(grid.reshape(-1, 3), bones) < 0.0).reshape(grid.shape[:3])
    ends = (slice(None, -1), slice(1, None))
    corners = np.stack([inside[a, b, c] for a in ends for b in ends for c in ends])
    mixed = corners.any(axis=0) & ~corners.all(axis=0)
    index = np.full(mixed.shape, -1)
    index[mixed] = np.arange(mixed.sum())
    triangles = []
    for axis in range(3):
        # The centres of the four cells around a grid edge that the surface crosses are the corners
        # of a square, which is divided into two triangles.
        turned, cells = np.moveaxis(inside, axis, 0), np.moveaxis(index, axis, 0)
        crossed = (turned[:-1] != turned[1:])[:, 1:-1, 1:-1]
        a, b, c, d = (cells[:, y, z][crossed] for y in ends for z in ends)
        outward = turned[:-1, 1:-1, 1:-1][crossed] != (axis == 1)
        b, c = np.where(outward, b, c), np.where(outward, c, b)
        triangles += [np.stack((a, c, b), axis=1), np.stack((b, c, d), axis=1)]
    faces = np.concatenate(triangles)
    points = grid[:-1, :-1, :-1][mixed] + 0.5 * CELL
    for _ in range(8):
        points = projected(0.5 * (points + relaxed(points, faces)), bones)
    return ls.TriangleMesh(points, faces)


def relaxed(points: Floats, faces: NDArray[np.int64]) -> Floats:
    """Returns the mean of the neighbours of each vertex (n x 3) [m]."""
    total, count = np.zeros_like(points), np.zeros((len(points), 1))
    for one, other in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        np.add.at(total, faces[:, one], points[faces[:, other]])
        np.add.at(count, faces[:, one], 1.0)
    return total / count


def projected(points: Floats, bones: dict[str, Bone]) -> Floats:
    """Returns points moved towards the bones' surface by one step of Newton's method."""
    small = 1e-4 * np.eye(3)
    slope = np.stack(
        [(blended(points + e, bones) - blended(points - e, bones)) / 2e-4 for e in small], axis=1
    )
    return np.asarray(
        points - (blended(points, bones) / (slope**2).sum(axis=1).clip(0.1))[:, None] * slope
    )


def smoothstep(share: Floats) -> Floats:
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def turn(axis: int, angles: Floats) -> Floats:
    """Returns the rotations (k x 3 x 3) about a coordinate axis by angles (k) [rad]."""
    c, s = np.cos(angles), np.sin(angles)
    result = np.zeros((len(angles), 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result[:, axis, axis] = 1.0
    result[:, i, i] = result[:, j, j] = c
    result[:, i, j], result[:, j, i] = -s, s
    return result


def height(place: float) -> float:
    """Returns the height [m] of the sole of a foot whose ankle stands at x = `place` [m]."""
    return GROUND + RISE * sum(riser < place for riser in RISERS)


class Foot(NamedTuple):
    """Motion of one foot, one row for each time."""

    ball: Floats  # (k x 3) place of the ball of the foot [m]
    pitch: Floats  # (k) angle by which the heel is raised [rad]
    toe_pitch: Floats  # (k) angle by which the toes are turned downwards [rad]
    stands: Floats  # (k) 1 while the foot bears weight, 0 in the air


def foot(times: Floats, y: float, first: int) -> Foot:
    """Returns the motion of one foot, which takes every second step.

    y: coordinate of the foot across the course [m]; first: index in PLACES of its first place
    """
    places = PLACES[first::2]
    ball = np.tile((places[0] + BALL[0], y, height(places[0])), (len(times), 1))
    pitch, toe_pitch, stands = (np.full(len(times), value) for value in (0.0, 0.0, 1.0))
    for i, (a, b) in enumerate(zip(places[:-1], places[1:], strict=True)):
        s = (times - START - STEP * (2 * i + first)) / SWING
        bar = [hurdle for hurdle in HURDLES if a < hurdle < b]
        lift = HURDLE[2] + 0.08 if bar else 0.07 + 0.05 * (height(b) > height(a))
        # A foot that starts close to a hurdle rises for longer before it moves forwards.
        late = 0.12 if bar and bar[0] - a < 0.5 * (b - a) else 0.05
        up = smoothstep(s / 0.3) * smoothstep((1.0 - s) / 0.3)
        air = (s > 0.0) & (s < 1.0)
        after = s > 0.0
        moved = a + BALL[0] + (b - a) * smoothstep((s - late) / (0.95 - late))
        climbed = height(a) + (height(b) - height(a)) * smoothstep(s / 0.45)
        ball[after, 0], ball[after, 2] = moved[after], (climbed + lift * up)[after]
        stands[air] = 0.0
        # The heel leaves the ground before the toes do, and lands before them.
        off = smoothstep(1.0 + s * SWING / 0.12) * smoothstep((0.4 - s) / 0.4)
        near = (s > -0.12 / SWING) & (s < 1.0)
        dip = 0.2 * np.sin(np.pi * np.clip((s - 0.4) / 0.6, 0.0, 1.0))
        pitch[near] = (0.5 * off - dip)[near]
        toe_pitch[near] = (pitch * smoothstep(s / 0.4))[near]
    return Foot(ball, pitch, toe_pitch, stands)


class Motion(NamedTuple):
    """Motion of a limb from the initial pose, one row for each time."""

    rotation: Floats  # (k x 3 x 3)
    shift: Floats  # (k x 3) translation after the rotation [m]

    def at(self, point: Floats) -> Floats:
        """Returns the positions (k x 3) [m] over time of a point given in the initial pose."""
        return np.asarray(self.rotation @ point + self.shift)


def about(rotation: Floats, point: Floats, places: Floats) -> Motion:
    """Returns the motion that rotates a limb about a point and moves this point to `places` [m]."""
    return Motion(rotation, places - rotation @ point)


def frames(along: Floats) -> Floats:
    """Returns three orthonormal axes of a limb (k x 3 x 3; columns). The first is the direction of
    `along` (k x 3), the second is as close to +x as possible, and the third points sideways.
    """
    u = along / np.linalg.norm(along, axis=1, keepdims=True)
    front = np.array((1.0, 0.0, 0.0)) - u[:, :1] * u
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    return np.stack((u, front, np.cross(u, front)), axis=2)


def leg(bones: dict[str, Bone], side: str, hip: Floats, moves: Foot) -> dict[str, Motion]:
    """Returns the motions of the bones of a leg, given the positions of its hip (k x 3) [m] and the
    motion of its foot.
    """
    upper_leg, lower_leg = bones[f"{side} thigh"], bones[f"{side} shank"]
    start, knee, ankle = (
        np.array(point) for point in (upper_leg.joint, lower_leg.joint, lower_leg.end)
    )
    rotation = turn(1, moves.pitch)
    step = about(rotation, ankle + BALL, moves.ball)
    apart = step.at(ankle) - hip
    upper, lower = np.linalg.norm(knee - start), np.linalg.norm(ankle - knee)
    reach = np.linalg.norm(apart, axis=1, keepdims=True)
    along = (reach**2 + upper**2 - lower**2) / (2.0 * reach)
    aside = np.sqrt(np.clip(upper**2 - along**2, 0.0, None))
    knees = hip + along / reach * apart + aside * frames(apart)[:, :, 1]
    thigh = frames(knees - hip) @ frames((knee - start)[None])[0].T
    shank = frames(step.at(ankle) - knees) @ frames((ankle - knee)[None])[0].T
    return {
        f"{side} thigh": about(thigh, start, hip),
        f"{side} shank": about(shank, knee, knees),
        f"{side} foot": step,
        f"{side} toe": about(turn(1, moves.toe_pitch), ankle + BALL, moves.ball),
    }


def walk(times: Floats, bones: dict[str, Bone]) -> dict[str, Motion]:
    """Returns the motion of every bone."""
    feet = {"right": foot(times, -0.11, 0), "left": foot(times, 0.11, 1)}
    right, left = feet["right"], feet["left"]
    apart = (right.ball[:, 0] - left.ball[:, 0]) / STEP
    hips = np.zeros((len(times), 3))
    hips[:, 0] = 0.5 * (right.ball[:, 0] + left.ball[:, 0]) - BALL[0]
    # The hips shift towards the foot that bears the weight.
    hips[:, 1] = 0.03 * (left.stands - right.stands)
    hips = gaussian_filter1d(hips, 0.1 * SAMPLES, axis=0, mode="nearest")
    # The pelvis is about as high as the reach of both legs permits.
    highest = np.full(len(times), np.inf)
    for moves in feet.values():
        ankle = moves.ball - turn(1, moves.pitch) @ BALL
        highest = np.minimum(highest, ankle[:, 2] + np.sqrt(REACH**2 - (ankle - hips)[:, 0] ** 2))
    lowest = minimum_filter1d(highest, 1 + 2 * round(0.06 * SAMPLES), mode="nearest")
    hips[:, 2] = gaussian_filter1d(lowest, 0.05 * SAMPLES, mode="nearest")
    middle = np.array((0.0, 0.0, bones["left thigh"].joint[2]))
    yaw = gaussian_filter1d(apart, 0.05 * SAMPLES, mode="nearest")
    moved = {"pelvis": about(turn(2, 0.1 * yaw), middle, hips)}
    for name, parent, amount in (("waist", "pelvis", 0.0), ("chest", "waist", -0.1)):
        joint = np.array(bones[name].joint)
        moved[name] = about(turn(2, amount * yaw), joint, moved[parent].at(joint))
    for name, amount in (("neck", -0.05), ("head", 0.0)):
        joint = np.array(bones[name].joint)
        moved[name] = about(turn(2, amount * yaw), joint, moved["chest"].at(joint))
    for side, moves in feet.items():
        forward = -yaw if side == "right" else yaw
        moved |= {f"{side} collar": moved["chest"]}
        parent = "chest"
        for name, angles in (
            ("arm", -0.4 * forward),
            ("forearm", -0.5 - 0.6 * forward),
            ("hand", -0.5 - 0.6 * forward),
        ):
            joint = np.array(bones[f"{side} {name}"].joint)
            moved[f"{side} {name}"] = about(turn(1, angles), joint, moved[parent].at(joint))
            parent = f"{side} {name}"
        hip = moved["pelvis"].at(np.array(bones[f"{side} thigh"].joint))
        moved |= leg(bones, side, hip, moves)
    return moved


def skinned(points: Floats, bones: dict[str, Bone], moved: dict[str, Motion]) -> Floats:
    """Returns the positions (k x n x 3) [m] of vertices that follow their nearest bones."""
    every = distances(points, bones)
    weights = np.exp((every.min(axis=1)[:, None] - every) / 0.016)
    weights[weights < 0.05] = 0.0
    weights /= weights.sum(axis=1, keepdims=True)
    count = len(moved["pelvis"].shift)
    result = np.zeros((count, len(points), 3))
    for column, name in enumerate(bones):
        near = np.flatnonzero(weights[:, column])
        turned = np.einsum("kij,nj->kni", moved[name].rotation, points[near])
        result[:, near] += weights[near, column, None] * (turned + moved[name].shift[:, None])
    return result


def stairs() -> ls.TriangleMesh:
    """Returns a closed staircase, 1 mm above the floor."""
    profile = [(END, 0.001), (RISERS[0], 0.001)]
    for k, x in enumerate(RISERS):
        profile += [(x, (k + 1) * RISE), ((*RISERS[1:], END)[k], (k + 1) * RISE)]
    n = len(profile)
    vertices = [(x, y, z) for y in (-0.6, 0.6) for x, z in profile]
    triangles = []
    for i in range(n):
        j = (i + 1) % n
        triangles += [(i, n + j, j), (i, n + i, n + j)]
        if 0 < i < n - 1:
            triangles += [(0, i, i + 1), (n, n + i + 1, n + i)]
    return ls.TriangleMesh(np.array(vertices), np.array(triangles))


def course() -> list[ls.Obstacle]:
    """Returns the floor, the hurdles and the stairs."""
    hurdles = [
        ls.obstacles.box(
            name=f"hurdle {k + 1}",
            size=HURDLE,
            centre=(x, 0.0, 0.5 * HURDLE[2] + 0.001),
            friction=0.2,
        )
        for k, x in enumerate(HURDLES)
    ]
    return [
        ls.floor(height=0.0),
        *hurdles,
        ls.obstacles.mesh(stairs(), name="stairs", friction=0.2),
    ]


def scene(triangles: int = 8891) -> ls.Scene:
    bones = skeleton()
    figure = surface(bones)
    times = np.linspace(0.0, duration, 1 + round(SAMPLES * duration))
    moved = walk(times, bones)
    places = skinned(np.asarray(figure.vertices), bones, moved)
    walker = ls.Obstacle(
        mesh=ls.TriangleMesh(places[0], figure.triangles),
        name="figure",
        times=times,
        vertex_positions=places.reshape(-1, 3),
        friction=0.3,
    )
    dress = ls.garments.dress(triangles, bar_radius=0.05, skirt=0.72)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # rotates -y to x
    worn = dress.mesh.moved(moved["chest"].at(np.array((0.0, 0.0, SHOULDER)))[0], rotation=quarter)
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.2,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    cloth = ls.Cloth(name="dress", mesh=worn, material=material, friction=0.3)
    return ls.Scene(
        cloths=[cloth],
        obstacles=[walker, *course()],
        air=ls.Air(normal_drag=0.5, tangential_drag=0.02),
    )


def check(run: ls.Run) -> None:
    figure = run.topology.body_of_vertex == run.topology.body_names.index("figure")
    times = np.array([frame.time for frame in run])
    places = np.stack([frame.body_vertices[figure] for frame in run])
    for y, first in ((-0.11, 0), (0.11, 1)):
        moves = foot(times, y, first)
        ball = places[0] - moves.ball[0]
        sole = (np.linalg.norm(ball, axis=1) < 0.05) & (ball[:, 2] < 0.01)
        slides = np.linalg.norm(np.diff(places[:, sole, :2], axis=0), axis=2).max(axis=1)
        stands = (moves.stands[1:] * moves.stands[:-1]).astype(bool)
        assert slides[stands].max() < 0.01, "a foot that bears weight does not slide"
    last = run[-1].positions
    assert last[:, 2].max() > height(PLACES[-1]) + SHOULDER - 0.1, "the straps are on the shoulders"
    assert last[:, 0].mean() > RISERS[-1], "the dress has come up the stairs"
    assert max(frame.stretch.max() for frame in run) < 1.6, "nothing is torn"
