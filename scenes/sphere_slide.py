"""A square cloth falls off-centre on a sphere, drapes over it and slides down to the floor.

The cloth hangs over the sphere, slips off on its heavier side and crumples on the floor. The limits
of strain along weft and warp are 10 %, and these strains stay below 11 %. This is the scene of
figure 3.8 of [Thomaszewski2010].

    loomstone run scenes/sphere_slide.py --verify -p triangles=3600
"""

import loomstone as ls

duration = 3.0
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(fit=False, eye=(0.72, -0.9, 0.3), target=(0.07, 0.02, -0.1))
)

RADIUS = 0.15
LIMITS = (0.1, 0.1, 0.4)


def scene(triangles: int = 14476, limited: bool = True, friction: float = 0.1) -> ls.Scene:
    """limited: whether there are strain limits; friction: that of cloth and sphere."""
    mesh = ls.meshes.irregular(size=(0.5, 0.5), triangles=triangles, seed=3).moved(
        (0.045, 0.03, RADIUS + 0.006)
    )
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.3,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    cloth = ls.Cloth(
        name="cloth",
        mesh=mesh,
        material=material,
        friction=friction,
        strain_limit=ls.StrainLimit(*LIMITS) if limited else None,
    )
    return ls.Scene(
        cloths=[cloth],
        obstacles=[
            ls.sphere(radius=RADIUS, friction=friction),
            ls.floor(height=-0.3, friction=0.3),
        ],
    )


def check(run: ls.Run) -> None:
    worst = max(
        max(f.report.limits.weft_excess, f.report.limits.warp_excess, f.report.limits.shear_excess)
        for f in run
    )
    assert worst < 0.01, "no triangle strains beyond its limits"
    assert run[-1].positions[:, 2].mean() < -0.1, "the cloth has slid to the floor"
