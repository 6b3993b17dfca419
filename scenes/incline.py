"""Four sheets with increasing friction lie on one slope: two slide down, two stay.

The tangent of the slope is 0.30. The friction coefficients of the sheets on it are 0.15, 0.29, 0.31
and 0.45. By Coulomb's law the first two slide with the acceleration g (sin a - mu cos a) on a slope
of angle a. The other two stay at rest, even the one that is close to the limit.
"""

import loomstone as ls
import numpy as np

duration = 1.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=2e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.85, -1.25, 0.85), target=(0.12, 0.0, -0.05), field_of_view_degrees=33.0
    )
)

SLOPE, PLANE = 0.30, 0.3
FRICTION = (0.15, 0.29, 0.31, 0.45)  # friction coefficient between each sheet and the slope
GAP = 1e-3


def scene(triangles: int = 400, slope: float = SLOPE) -> ls.Scene:
    cells = max(1, round(np.sqrt(triangles / 2)))
    angle = np.arctan(slope)
    down, normal = (
        np.array([np.cos(angle), 0.0, -np.sin(angle)]),
        np.array([np.sin(angle), 0.0, np.cos(angle)]),
    )
    frame = np.stack([down, [0.0, 1.0, 0.0], normal], axis=1)
    cloths = []
    for i, friction in enumerate(FRICTION):
        start = -0.35 * down + 0.16 * (i - 1.5) * np.array([0.0, 1.0, 0.0]) + 0.999 * GAP * normal
        mesh = ls.grid(size=(0.12, 0.12), cells=(cells, cells)).moved(start, rotation=frame)
        # The friction coefficient of a contact is the geometric mean of the coefficients of both
        # surfaces.
        cloths.append(
            ls.Cloth(
                name=f"friction {friction}", mesh=mesh, thickness=GAP, friction=friction**2 / PLANE
            )
        )
    plane = ls.obstacles.mesh(
        ls.meshes.box(size=(1.3, 0.75, 0.02)).moved(0.15 * down - 0.01 * normal, rotation=frame),
        name="slope",
        friction=PLANE,
        thickness=GAP,
    )
    return ls.Scene(cloths=cloths, obstacles=[plane])


def check(run: ls.Run) -> None:
    first, last, cloth = run[0], run[-1], run.topology.cloth_of_vertex
    angle = np.arctan(SLOPE)
    for i, friction in enumerate(FRICTION):
        moved = last.positions[cloth == i] - first.positions[cloth == i]
        distance = np.linalg.norm(moved.mean(axis=0))
        pull = 9.81 * (np.sin(angle) - friction * np.cos(angle))
        if pull < 0.0:
            assert distance < 1e-4, f"friction {friction} holds on a slope of {SLOPE}"
        else:
            expected = 0.5 * pull * last.time**2
            assert abs(distance - expected) < 0.05 * expected + 1e-3, (
                f"friction {friction}: slides as Coulomb says"
            )
