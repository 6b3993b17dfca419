"""Writes small USD files for tests."""

import numpy as np
import pytest


def new_stage(path, *, up="Z", metres=1.0, codes=(0.0, 1.0)):
    """Returns a new stage with this upward axis, unit of length [m] and first and last time code.

    Skips the test if USD is not installed.
    """
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    stage.SetStartTimeCode(codes[0])
    stage.SetEndTimeCode(codes[1])
    return stage


def define_mesh(stage, path, points, faces):
    """Adds a mesh with these points (n x 3) and faces (m x k), and returns it."""
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(points, np.float32)))
    mesh.CreateFaceVertexCountsAttr([faces.shape[1]] * len(faces))
    mesh.CreateFaceVertexIndicesAttr(faces.reshape(-1).tolist())
    return mesh
