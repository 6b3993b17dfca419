"""A glTF export repeats vertices whose corners have different texture coordinates."""

import loomstone as ls
import numpy as np
import pytest


def test_gltf_keeps_seams_of_textures_on_flat_faces_of_obstacles(tmp_path):
    """The corners at the diagonals of a cube's faces have equal normals and different uv."""
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("pygltflib")
    cube = ls.meshes.box(size=(0.1, 0.1, 0.1))
    uv = np.random.default_rng(1).uniform(size=(3 * len(cube.triangles), 2))
    corners = np.arange(len(uv), dtype=np.int32).reshape(-1, 3)
    mesh = ls.TriangleMesh(cube.vertices, cube.triangles, uv=uv, uv_triangles=corners)
    image = np.full((2, 2, 3), 128, np.uint8)
    crate = ls.obstacles.mesh(mesh, name="crate", look=ls.Look(texture=image, texture_width=1.0))
    sheet = ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(1, 1)).moved((0, 0, 1)))
    ls.Simulation(ls.Scene(cloths=[sheet], obstacles=[crate])).run(
        out=tmp_path / "out", duration=0.01, rate=100
    )
    written = ls.Run(tmp_path / "out").export(tmp_path / "run.glb")[0]
    made = trimesh.load_scene(written, process=False).geometry["crate"]
    assert made.visual.uv[made.faces] == pytest.approx(uv[corners], abs=1e-6)
