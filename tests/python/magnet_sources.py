"""Magnets and currents for tests of fields, forces and energies."""

import loomstone as ls
import numpy as np
from loomstone import magnetics as M

J = (0.3, -0.5, 0.8)

# Magnets of about the same size, whose energies and forces are finite.
MAGNETS = {
    "cuboid": M.cuboid(size=(0.01, 0.012, 0.008), polarization=(0.3, -0.5, 1.0)),
    "cylinder": M.cylinder(radius=0.006, height=0.01, polarization=(0.4, 0.2, 0.9)),
    "ring": M.cylinder(radius=0.006, height=0.01, inner_radius=0.003, polarization=(0.4, 0.2, 0.9)),
    "mesh": M.mesh(ls.meshes.sphere(radius=0.006, subdivisions=1), polarization=(0.1, 0.2, 0.8)),
    "sphere": M.sphere(radius=0.006, polarization=(0.5, 0.5, -0.5)),
}


def tetrahedron():
    return ls.TriangleMesh(
        [[0, 0, 0], [0.02, 0, 0], [0.004, 0.017, 0], [0.007, 0.005, 0.015]],
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )


def sources():
    rng = np.random.default_rng(7)
    return {
        "cuboid": M.cuboid(size=(0.02, 0.01, 0.015), polarization=J),
        "cylinder": M.cylinder(radius=0.01, height=0.013, polarization=J),
        "ring": M.cylinder(radius=0.01, height=0.013, inner_radius=0.004, polarization=J),
        "sphere": M.sphere(radius=0.01, polarization=J),
        "mesh": M.mesh(tetrahedron(), polarization=J).at((0, 0, 0)),
        "loop": M.loop(radius=0.01, current=3.0),
        "solenoid": M.solenoid(radius=0.01, length=0.02, turns=10, current=2.0),
        "polyline": (
            M.polyline([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0.003], [0, 0, 0]], current=2.0).at(
                (0, 0, 0)
            )
        ),
        "dipoles": M.dipoles(0.01 * rng.normal(size=(5, 3)), rng.normal(size=(5, 3))),
    }
