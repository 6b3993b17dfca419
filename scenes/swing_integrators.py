"""A square sheet of 2 m with an unstructured mesh swings from two corners, with any integrator.

The material has no damping unless `viscosity` is given, and collisions are off. Strain is limited
to 10 %; asynchronous steps begin to limit it at 7.5 %. This is example 4.1 of [Thomaszewski2010]
(figures 4.1 and 4.6).

    loomstone run scenes/swing_integrators.py --integrator symplectic-euler --step 2.5e-4
    python tests/benchmarks/integrators.py        # all integrators: pictures, times, energies
"""

import loomstone as ls
import numpy as np

duration = 4.0
rate = 25.0
integrator = ls.Asynchronous(step=2.5e-3, predicted=0.075, present=0.1)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(3.4, -5.2, 0.6), target=(0.0, 0.4, -0.7), field_of_view_degrees=34.0
    ),
    floor=False,
)

SIZE = 2.0


def scene(triangles: int = 5016, viscosity: float = 0.0, limit: float = 0.1) -> ls.Scene:
    """viscosity: in dilation and in shear [N s/m]; limit: largest strain [1], or 0 for no limit."""
    mesh = ls.meshes.irregular(size=(SIZE, SIZE), triangles=triangles)
    corners = [(-SIZE / 2, SIZE / 2, 0.0), (SIZE / 2, SIZE / 2, 0.0)]
    material = ls.ClothMaterial(
        weft_stiffness=300.0,
        warp_stiffness=300.0,
        shear_stiffness=150.0,
        density=0.5,
        bending_weft=1e-5,
        bending_warp=1e-5,
        viscosity_dilation=viscosity,
        viscosity_shear=viscosity,
    )
    cloth = ls.Cloth(
        name="sheet",
        mesh=mesh,
        material=material,
        pins=ls.meshes.nearest_vertices(mesh, corners),
        strain_limit=ls.StrainLimit(limit, limit, limit) if limit else None,
    )
    return ls.Scene(cloths=[cloth], collisions=False)


def check(run: ls.Run) -> None:
    energies = [frame.report.energy for frame in run]
    total = np.array([e.kinetic + e.membrane + e.bending + e.gravity for e in energies])
    kinetic = max(e.kinetic for e in energies)
    assert kinetic > 0.1 * (total.max() - min(e.gravity for e in energies)), "the sheet swings"
    assert total.max() < total[0] + 0.005 * kinetic, "no energy is gained"
    assert max(frame.stretch.max() for frame in run) < 1.4, "strain is limited"
