"""Makes a character in Blender and exports it; blender_character.py runs this file with
Blender's Python.

A tube is skinned to two bones and has a shape key. Within 25 frames the upper bone turns, the
armature moves and the shape key grows. The only argument is the directory for tube.glb, tube.usdc
and tube.npy, which has the vertices in world space (25 x n x 3) [m].
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np

FRAMES = range(1, 26)


def tube() -> bpy.types.Object:
    """Returns a closed tube, 2 m high, with a shape key that widens it."""
    bpy.ops.mesh.primitive_cylinder_add(
        vertices=12, radius=0.2, depth=2, end_fill_type="TRIFAN", location=(0.3, 0.2, 1)
    )
    made = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=3)
    bpy.ops.object.mode_set(mode="OBJECT")
    made.shape_key_add(name="Basis")
    wide = made.shape_key_add(name="wide")
    for vertex in wide.data:
        vertex.co.x *= 1.2
    for value, frame in ((0.0, FRAMES[0]), (1.0, FRAMES[-1])):
        wide.value = value
        wide.keyframe_insert("value", frame=frame)
    return made


def bind(made: bpy.types.Object) -> None:
    """Binds an object to a moving armature of two bones. The upper bone turns."""
    bpy.ops.object.armature_add(location=(0.3, 0.2, 0))
    bones = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    lower = bones.data.edit_bones[0]
    lower.tail = (0, 0, 1)
    upper = bones.data.edit_bones.new("upper")
    upper.head, upper.tail, upper.parent = (0, 0, 1), (0, 0, 2), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.select_all(action="DESELECT")
    made.select_set(True)
    bones.select_set(True)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    turning = bones.pose.bones["upper"]
    for frame, angle in ((1, 0.0), (13, 0.8), (25, -0.4)):
        turning.rotation_quaternion = (math.cos(angle / 2), math.sin(angle / 2), 0, 0)
        turning.keyframe_insert("rotation_quaternion", frame=frame)
        bones.location = (0.3 + 0.01 * frame, 0.2, 0)
        bones.keyframe_insert("location", frame=frame)


def vertices(made: bpy.types.Object, frame: int) -> np.ndarray:
    """Returns the vertices (n x 3) [m] of an object at a frame, in world space."""
    bpy.context.scene.frame_set(frame)
    shown = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.empty(3 * len(shown.data.vertices), np.float32)
    shown.data.vertices.foreach_get("co", points)
    pose = np.array(shown.matrix_world)
    return points.reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]


def main() -> None:
    out = Path(sys.argv[1])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 24, FRAMES[0], FRAMES[-1]
    made = tube()
    bind(made)
    bpy.ops.export_scene.gltf(filepath=str(out / "tube.glb"))
    bpy.ops.wm.usd_export(filepath=str(out / "tube.usdc"), export_animation=True)
    np.save(out / "tube.npy", np.array([vertices(made, frame) for frame in FRAMES]))


main()
