"""A square cloth falls onto a sphere and comes to rest in folds.

The corners swing down and folds form between them. The sphere is off-centre, so the cloth hangs
unevenly. The cloth does not reach the floor below. The initial state and the material are those of
the comparison with other programs (docs/performance.md). Example 3.3 of [Thomaszewski2010] (figure
3.8) starts in a similar way.
"""

import loomstone as ls
import numpy as np

duration = 1.0
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(fit=False, eye=(0.62, -0.86, 0.42), target=(0.03, 0.02, -0.04))
)

RADIUS, CENTRE = 0.15, np.array([0.03, 0.02, 0.0])


def scene(triangles: int = 14450) -> ls.Scene:
    cells = max(1, round(np.sqrt(triangles / 2)))
    mesh = ls.grid(size=(0.5, 0.5), cells=(cells, cells)).moved((0.0, 0.0, RADIUS + 0.006))
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.3,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    return ls.Scene(
        cloths=[ls.Cloth(name="cloth", mesh=mesh, material=material, friction=0.3)],
        obstacles=[
            ls.sphere(radius=RADIUS, centre=CENTRE, friction=0.3),
            ls.floor(height=-0.30, friction=0.3),
        ],
    )


def check(run: ls.Run) -> None:
    last = run[-1]
    distance = np.linalg.norm(last.positions - CENTRE, axis=1)
    assert distance.min() > 0.999 * RADIUS, "no vertex is inside the sphere"
    lowest, stretched = last.positions[:, 2].min(), np.quantile(last.stretch, 0.99)
    assert -0.25 < lowest < -0.10, (
        f"the corners hang beside the sphere, well above the floor, got {lowest:.3f} m"
    )
    # The contact distance is a tenth of the mean edge. Gaps are measured from the exact sphere,
    # which lies slightly outside the facets of the obstacle.
    start = run[0].positions[run.topology.triangles]
    gap = (distance - RADIUS) / (
        0.1 * np.linalg.norm(start - np.roll(start, 1, axis=1), axis=2).mean()
    )
    gap = gap[(last.contact > 0) & (gap < 3.0)]  # leaves out vertices without contact, and folds
    assert len(gap) > 10 and gap.min() > 0.6, (
        f"what lies on the sphere keeps its distance, got {gap.min():.2f} of it"
    )
    assert 0.8 < np.median(gap) < 1.7, f"and does not hover, got {np.median(gap):.2f}"
    assert stretched < 1.05, (
        f"99 % of the cloth is stretched by less than 1.05, got {stretched:.3f}"
    )
    assert last.stretch.max() < 1.55, "contacts do not tear the cloth"
    assert max(frame.stretch.max() for frame in run) < 1.55, "nor on the way"
