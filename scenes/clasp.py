"""Magnets sewn into cloth: a magnetic clasp closes two curtains.

Two curtains hang side by side and overlap. One has a magnet sewn to its back, and the other has one
sewn to its front. The magnets attract each other, snap together with both cloths between them, and
keep the curtains closed. Red is north and blue is south.
"""

import loomstone as ls
import numpy as np

duration = 0.8
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.42, -0.85, 0.10), target=(0.0, 0.0, -0.16), field_of_view_degrees=30.0
    )
)

WIDTH, HEIGHT = 0.24, 0.30
OVERLAP = 0.05
APART = 0.012  # distance of each curtain from the plane between them [m]
MAGNET = (0.014, 0.004, 0.014)
AT = -0.20  # height of the clasp relative to the rail [m]


def curtain(side: int, triangles: int) -> ls.TriangleMesh:
    """A curtain that hangs from z = 0. side: -1 is left and behind (y > 0), 1 is right and in front
    (y < 0).
    """
    flat = ls.grid(size=(WIDTH, HEIGHT), triangles=triangles)
    upright = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
    return flat.moved(
        (side * 0.5 * (WIDTH - OVERLAP), -side * APART, -0.5 * HEIGHT), rotation=upright
    )


def scene(triangles: int = 1200, polarization: float = 1.2) -> ls.Scene:
    """triangles: approximate number of triangles of each curtain; polarization: that of the
    magnets [T].
    """
    linen = ls.ClothMaterial(
        weft_stiffness=800,
        warp_stiffness=800,
        shear_stiffness=200,
        density=0.15,
        bending_weft=3e-6,
        bending_warp=3e-6,
    )
    cloths, bodies, magnets, attachments = [], [], [], []
    for side, name in ((-1, "left"), (1, "right")):
        mesh = curtain(side, triangles)
        x = np.asarray(mesh.vertices)
        place = np.array((0.0, -side * APART, AT))
        # The cloth is sewn to the magnet up to one mean edge length beyond the magnet's outline and
        # thus hardly bends where it touches the magnet.
        beyond = np.maximum(
            np.abs(x[:, 0] - place[0]) - 0.5 * MAGNET[0],
            np.abs(x[:, 2] - place[2]) - 0.5 * MAGNET[2],
        )
        sewn = np.flatnonzero(beyond <= mesh.mean_edge)
        cloths.append(
            ls.Cloth(
                name=name,
                mesh=mesh,
                material=linen,
                pins=np.flatnonzero(x[:, 2] > -1e-9),
                friction=0.4,
            )
        )
        body = ls.RigidBody(
            name=f"{name} magnet",
            mesh=ls.meshes.box(size=MAGNET, cells_per_side=2),
            shape="box",
            density=7500,
            friction=0.4,
            position=place - (0, side * (0.5 * MAGNET[1] + 0.001), 0),
        )
        bodies.append(body)
        magnet = ls.magnetics.cuboid(size=MAGNET, polarization=(0, polarization, 0))
        magnets.append(ls.Magnet(body=body.name, source=magnet))
        attachments.append(ls.Attachment(cloth=name, body=body.name, vertices=sewn))
    return ls.Scene(
        cloths=cloths,
        bodies=bodies,
        magnets=magnets,
        attachments=attachments,
        magnetic_tolerance=1e-3,
    )


def check(run: ls.Run) -> None:
    owner = run.topology.body_of_vertex

    def gap(frame: ls.Frame) -> float:
        left, right = (frame.body_vertices[owner == b] for b in range(2))
        return float(np.linalg.norm(left[:, None] - right[None], axis=2).min())

    assert gap(run[-1]) < 0.4 * gap(run[0]), "the clasp has shut"
    assert gap(run[-1]) > 2e-4, "with cloth between the magnets"
