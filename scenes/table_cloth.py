"""A round table cloth falls on a sphere one third as wide as the cloth, and hangs in folds.

At first only the middle of the cloth touches the sphere. Then the rim closes into folds that touch
one another, so the collisions spread over the whole cloth. This is example 5.1 of
[Thomaszewski2010], with 1,000 steps of 1 ms. The mesh has 27,531 triangles instead of the 27,532 of
the thesis, because its number of boundary points is odd, which makes the number of triangles odd,
too. The material is our choice.

    loomstone run scenes/table_cloth.py -p triangles=3000
"""

import loomstone as ls
import numpy as np

duration = 1.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(fit=False, eye=(0.72, -0.95, 0.42), target=(0.0, 0.0, -0.08))
)

RADIUS, BALL = 0.5, 0.5 / 3.0


def scene(triangles: int = 27532) -> ls.Scene:
    mesh = ls.meshes.disc(radius=RADIUS, triangles=triangles).moved((0.0, 0.0, BALL + 0.006))
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.3,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    return ls.Scene(
        cloths=[ls.Cloth(name="table cloth", mesh=mesh, material=material, friction=0.3)],
        obstacles=[ls.sphere(radius=BALL, friction=0.3)],
    )


def check(run: ls.Run) -> None:
    first, last = run[0], run[-1].positions
    rim = np.linalg.norm(first.positions[:, :2], axis=1) > 0.999 * RADIUS
    middle = np.linalg.norm(first.positions[:, :2], axis=1).argmin()
    assert np.linalg.norm(last, axis=1).min() > 0.999 * BALL, "no vertex is inside the sphere"
    assert abs(last[middle, 2] - BALL) < 0.02, "the middle stays on top of the sphere"
    assert last[rim, 2].max() < 0.0, "the whole rim hangs below the centre of the sphere"
    # A rim that keeps its length but lies within a narrower circle is folded.
    width = np.linalg.norm(last[rim, :2], axis=1).mean()
    assert width < 0.7 * RADIUS, f"the rim has closed into folds, got a mean radius of {width:.3f}"
    assert max(frame.stretch.max() for frame in run) < 1.55, "contacts do not tear the cloth"
