"""Alembic files of rigid surfaces have one normal per corner of the triangles."""

import loomstone as ls
import numpy as np
import pytest


def test_a_surface_whose_triangles_share_no_vertices_keeps_its_normals(tmp_path):
    geometry = pytest.importorskip("alembic3d.AbcGeom")
    from alembic3d import Abc

    cube = ls.meshes.box(size=(0.1, 0.1, 0.1))
    corners = cube.vertices[cube.triangles].reshape(-1, 3)
    order = np.random.default_rng(1).permutation(len(cube.triangles))
    mesh = ls.TriangleMesh(corners, np.arange(len(corners)).reshape(-1, 3)[order])
    crate = ls.obstacles.mesh(mesh, name="crate")
    sheet = ls.Cloth(mesh=ls.grid(size=(0.1, 0.1), cells=(1, 1)).moved((0, 0, 1)))
    ls.Simulation(ls.Scene(cloths=[sheet], obstacles=[crate])).run(
        out=tmp_path / "out", duration=0.01, rate=100
    )
    (path,) = ls.Run(tmp_path / "out").export(tmp_path / "run.abc")
    pose = geometry.IXform(Abc.IArchive(str(path)).getTop(), "crate")
    surface = geometry.IPolyMesh(pose, "crate_surface").getSchema()
    found = surface.getNormalsParam().getExpandedValue()
    assert found.getScope() == geometry.GeometryScope.kFacevaryingScope
    normals = np.array([tuple(n) for n in found.getVals()]).reshape(-1, 3, 3)
    points = np.array([tuple(p) for p in surface.getValue().getPositions()])
    faces = points[np.array(list(surface.getValue().getFaceIndices())).reshape(-1, 3)]
    sides = np.cross(faces[:, 2] - faces[:, 0], faces[:, 1] - faces[:, 0])
    flat = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    assert normals == pytest.approx(np.repeat(flat[:, None], 3, axis=1), abs=1e-6)
