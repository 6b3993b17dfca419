"""A long upright sheet falls onto its lower edge and folds into ten layers.

The sheet starts upright above the floor, pleated like a map. After its lower edge lands, the
creases close one after another from below and the layers settle on one another.
"""

import loomstone as ls
import numpy as np

duration = 1.6
rate = 25.0
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.62, -0.40, 0.36), target=(0.0, 0.0, 0.18), field_of_view_degrees=39.0
    )
)

LAYER, WIDTH, DROP = 0.06, 0.20, 0.02


def scene(triangles: int = 6000, layers: int = 10, lean: float = 50.0) -> ls.Scene:
    """lean: initial angle of each layer from the vertical, with alternating sign [degrees]."""
    length = LAYER * layers
    edge = np.sqrt(2.0 * length * WIDTH / triangles)
    per_layer = max(2, round(LAYER / edge))
    flat = ls.grid(size=(WIDTH, length), cells=(max(2, round(WIDTH / edge)), per_layer * layers))
    # Height and sideways position of each row of vertices. Layers are straight and lean to
    # alternating sides.
    along = flat.vertices[:, 1] + 0.5 * length
    place = along / LAYER
    upwards = along * np.cos(np.radians(lean))
    sideways = LAYER * np.sin(np.radians(lean)) * (0.5 - np.abs(place % 2.0 - 1.0))
    bent = np.stack([sideways, flat.vertices[:, 0], DROP + upwards], axis=1)
    mesh = ls.TriangleMesh(bent, flat.triangles, flat.vertices[:, :2])
    material = ls.ClothMaterial(density=0.2, bending_weft=2e-6, bending_warp=2e-6)
    return ls.Scene(
        cloths=[ls.Cloth(name="sheet", mesh=mesh, material=material, friction=0.2)],
        obstacles=[ls.floor()],
    )


def check(run: ls.Run) -> None:
    last = run[-1].positions
    assert last[:, 2].max() < 0.1, "the sheet has come down"
    assert last[:, 2].min() > 0.0, "no vertex is below the floor"
    assert max(frame.stretch.max() for frame in run) < 1.3, "contacts do not tear the cloth"
