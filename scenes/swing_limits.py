"""Seven soft cloths, pinned at two corners and released from the horizontal, differ only in their
strain limits (example 3.1 of [Thomaszewski2010]).

From left to right, the first four cloths have the limits (weft, warp, shear) = (2, 2, 2) %,
(2, 2, 20) %, (2, 20, 20) % and (20, 2, 20) %. The next two have a single limit for all edges, 2 %
and 20 %, and the last has no limit. These are the columns of figure 3.6 of the thesis. With a loose
shear limit, a cloth sags like a bag in spite of tight limits along weft and warp. Swapping the
limits of weft and warp makes the cloth wider instead of longer. A single limit for all edges merely
makes the whole cloth softer or stiffer.

The commands below draw the three rows of the figure: the cloths, the strain along weft (left half
of each cloth) and warp (right half), and the shear.

    loomstone run scenes/swing_limits.py --out out/swing_limits
    loomstone render out/swing_limits --color-map diverging --color-low -0.25 --color-high 0.25 \
        --color-by cloth+strain_split+strain_shear
"""

import loomstone as ls

duration = 1.5
rate = 25.0
integrator = ls.SemiImplicitEuler(step=4e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        eye=(0.0, -13.0, 0.5), target=(0.0, 0.7, -0.85), field_of_view_degrees=16.0, fit=False
    ),
    width=1800,
    height=420,
    floor=False,
)

SIZE, SPACING = 1.5, 2.1
COLUMNS = {
    "2 2 2": ls.StrainLimit(0.02, 0.02, 0.02),
    "2 2 20": ls.StrainLimit(0.02, 0.02, 0.2),
    "2 20 20": ls.StrainLimit(0.02, 0.2, 0.2),
    "20 2 20": ls.StrainLimit(0.2, 0.02, 0.2),
    "edges 2": ls.StrainLimit(edge=0.02),
    "edges 20": ls.StrainLimit(edge=0.2),
    "none": None,
}


def scene(triangles: int = 3616, sweeps: int = 100) -> ls.Scene:
    flat = ls.meshes.irregular(size=(SIZE, SIZE), triangles=triangles)
    pins = ls.meshes.nearest_vertices(flat, [(-SIZE / 2, SIZE / 2, 0), (SIZE / 2, SIZE / 2, 0)])
    material = ls.ClothMaterial(
        weft_stiffness=100.0, warp_stiffness=100.0, shear_stiffness=30.0, density=0.5
    )
    cloths = [
        ls.Cloth(
            name=name,
            mesh=flat.moved(((i - 3) * SPACING, 0, 0)),
            material=material,
            pins=pins,
            strain_limit=limit,
        )
        for i, (name, limit) in enumerate(COLUMNS.items())
    ]
    return ls.Scene(cloths=cloths, limits=ls.LimitOptions(max_sweeps=sweeps))


def check(run: ls.Run) -> None:
    assert max(frame.report.limits.broken for frame in run) == 0, (
        "limits hold, to a fifth of 2 % and to 0.01"
    )
    last, column = run[-1], run.topology.cloth_of_triangle
    mean = [abs(last.strain[column == i]).mean(axis=0) for i in range(len(COLUMNS))]
    assert mean[6].max() > 2 * mean[0].max(), (
        "without limits it stretches further than with tight ones"
    )
    assert mean[1][2] > 2 * mean[0][2], "loose shear is used"
    assert mean[2][1] > mean[3][1] and mean[3][0] > mean[2][0], "swapped limits swap weft and warp"
