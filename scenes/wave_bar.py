"""A square cloth falls over a thin wave-shaped bar and then on the floor below it.

At first, only the crests of the bar hold the cloth. The cloth folds on both sides while it sinks
towards the troughs. Its edges reach the floor, and parts of the cloth rest there. This is example
5.2 of [Thomaszewski2010], with 28,800 triangles and 1,000 steps of 1 ms. The dimensions of the bar
and the material are our choice.

    loomstone run scenes/wave_bar.py -p triangles=3200
"""

import loomstone as ls
import numpy as np

duration = 1.0
rate = 25.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(fit=False, eye=(1.15, -1.0, 0.55), target=(0.0, 0.0, -0.13))
)

SIZE, FLOOR = 1.0, -0.3
BAR, AMPLITUDE, WAVELENGTH = 0.015, 0.08, 0.4  # radius, amplitude and wavelength of the bar [m]


def scene(triangles: int = 28800) -> ls.Scene:
    cells = max(1, round(np.sqrt(triangles / 2)))
    mesh = ls.grid(size=(SIZE, SIZE), cells=(cells, cells))
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
        mesh=mesh.moved((0.03, 0.02, AMPLITUDE + BAR + 0.006)),
        material=material,
        friction=0.2,
    )
    bar = ls.obstacles.wave_bar(
        length=1.2 * SIZE, radius=BAR, amplitude=AMPLITUDE, wavelength=WAVELENGTH, friction=0.2
    )
    return ls.Scene(cloths=[cloth], obstacles=[bar, ls.floor(height=FLOOR, friction=0.3)])


def check(run: ls.Run) -> None:
    last = run[-1].positions
    assert last[:, 2].min() > FLOOR, "no vertex is below the floor"
    lying = (last[:, 2] < FLOOR + 0.03).mean()
    assert lying > 0.1, f"a tenth of the cloth lies on the floor, got {lying:.2f}"
    high = AMPLITUDE + BAR
    assert high < last[:, 2].max() < high + 0.02, "the crests hold the cloth"
    trough = np.abs(np.abs(last[:, 1]) - 0.5 * WAVELENGTH) < 0.02
    sunk = last[trough, 2].max()
    assert sunk < AMPLITUDE, f"it sinks between the crests, got {sunk:.3f} m"
    sides = [(side * last[:, 0] > BAR).mean() for side in (-1.0, 1.0)]
    assert min(sides) > 0.25, f"it hangs down on both sides, got shares of {sides}"
    assert max(frame.stretch.max() for frame in run) < 1.55, "contacts do not tear the cloth"
