"""A cloth pinned at two corners is released from the horizontal and swings for four seconds.

The cloth falls, swings through and swings back. The height that it reaches shows how much energy
the integrator preserves. The material has no damping, and collisions are off. Figure 4.1 of
[Thomaszewski2010] shows such a motion of a square sheet with an unstructured mesh.

    loomstone run scenes/swing.py --integrator implicit-midpoint
    loomstone plot out/swing --what energy
"""

import loomstone as ls

duration = 4.0
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(camera=ls.Camera(eye=(1.2, -0.9, 0.2)))


def scene(columns: int = 44, rows: int = 57) -> ls.Scene:
    mesh = ls.grid(size=(0.44, 0.57), cells=(columns, rows))
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.3,
        bending_weft=1e-5,
        bending_warp=1e-5,
    )
    return ls.Scene(
        cloths=[ls.Cloth(mesh=mesh, material=material, pins=[0, columns])], collisions=False
    )


def check(run: ls.Run) -> None:
    first, last = run[0], run[-1]
    assert last.positions[:, 2].mean() < -0.15, "the cloth hangs below its pins"
    assert last.positions[:, 2].max() < 0.1, "it never swings above where it started"
    energy = last.report.energy
    total = energy.kinetic + energy.membrane + energy.bending + energy.gravity
    begin = first.report.energy.gravity
    assert total < begin + 1e-3, "no energy is gained"
