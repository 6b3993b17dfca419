"""A flag in the wind.

Waves run from the pole to the free end, which flaps. The edge at the pole is pinned. Drag acts on
every triangle, much more strongly along its normal than along its plane.
"""

import loomstone as ls
import numpy as np

duration = 3.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=2e-3)
render = ls.RenderOptions(camera=ls.Camera(eye=(0.4, -2.0, 0.3)), pattern="plain")


def scene(triangles: int = 4800, wind: float = 7.0, fabric: str = "silk") -> ls.Scene:
    flat = ls.meshes.irregular(size=(0.9, 0.6), triangles=triangles)
    upright = np.array(
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    )  # x points roughly downwind, warp points up
    mesh = flat.moved((0.45, 0.0, 0.0), rotation=upright)
    pole = [int(i) for i in np.flatnonzero(mesh.vertices[:, 0] < 1e-9)]
    air = ls.Air(normal_drag=1.0, tangential_drag=0.02, wind=(wind, 0.3 * wind, 0.0), gust=0.2)
    return ls.Scene(
        cloths=[ls.Cloth(name="flag", mesh=mesh, material=ls.fabrics[fabric], pins=pole)], air=air
    )


def check(run: ls.Run) -> None:
    last = run[-1]
    assert last.positions[:, 0].max() > 0.5, "the wind holds the flag up"
    assert np.abs(last.velocities).max() > 0.1, "it does not come to rest"
    assert last.stretch.max() < 1.3, "silk hardly stretches in such a wind"
