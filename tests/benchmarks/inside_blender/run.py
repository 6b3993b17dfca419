"""Loads an exported run into Blender and draws a frame; blender.py runs this with Blender's Python.

The only argument is JSON with the entries `files`, `frame`, `rate`, `picture`, `positions`,
`samples` and `width`. Prints the times of the import and of the picture [s] as JSON, and writes the
vertices of all meshes at the frame, in world space, to `positions`.
"""

import json
import math
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector


def load(order: dict) -> None:
    """Imports the files and moves to the frame."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = round(order["rate"])
    files = [Path(name) for name in order["files"]]
    if files[0].suffix == ".usdc":
        bpy.ops.wm.usd_import(filepath=str(files[0]))
    elif files[0].suffix == ".glb":
        # By default, the importer would infer flat shading from the flat cloth of the first frame.
        bpy.ops.import_scene.gltf(filepath=str(files[0]), import_shading="SMOOTH")
    elif files[0].suffix == ".abc":
        bpy.ops.wm.alembic_import(filepath=str(files[0]))
    else:
        load_caches(files)
    scene.frame_set(order["frame"])


def load_caches(files: list[Path]) -> None:
    """Imports OBJ files. If a file has a point cache, a Mesh Cache modifier moves its mesh."""
    caches = {path.stem: path for path in files if path.suffix != ".obj"}
    for path in files:
        if path.suffix != ".obj":
            continue
        bpy.ops.wm.obj_import(filepath=str(path), forward_axis="Y", up_axis="Z")
        made = bpy.context.selected_objects[0]
        made.data.shade_smooth()
        if path.stem in caches:
            moved = made.modifiers.new("cache", "MESH_CACHE")
            moved.cache_format = caches[path.stem].suffix[1:].upper()
            moved.filepath = str(caches[path.stem])
            moved.frame_start = 0.0


def vertices() -> dict[str, np.ndarray]:
    """Returns the vertices (n x 3) [m] of each mesh in world space.

    The keys are "0", "1" and so on, in the order of the objects of the scene.
    """
    graph = bpy.context.evaluated_depsgraph_get()
    found = {}
    for made in bpy.context.scene.objects:
        if made.type != "MESH":
            continue
        shown = made.evaluated_get(graph)
        points = np.empty(3 * len(shown.data.vertices), np.float32)
        shown.data.vertices.foreach_get("co", points)
        pose = np.array(shown.matrix_world)
        found[str(len(found))] = points.reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]
    return found


def draw(order: dict, seen: dict[str, np.ndarray]) -> None:
    """Draws the scene from the front right and above, with a sun and a grey world."""
    scene = bpy.context.scene
    small = [points for points in seen.values() if np.ptp(points, axis=0).max() < 3.0]
    whole = np.concatenate(small or list(seen.values()))
    centre = Vector(0.5 * (whole.min(0) + whole.max(0)))
    reach = 0.5 * float(np.linalg.norm(np.ptp(whole, axis=0)))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = centre + 3.2 * reach * Vector((0.55, -0.75, 0.4)).normalized()
    camera.rotation_euler = (centre - camera.location).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle = 1.5, 0.1
    sun.rotation_euler = (math.radians(35), math.radians(15), math.radians(30))
    for made in (camera, sun):
        scene.collection.objects.link(made)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.4, 0.43, 0.46, 1.0)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = order["samples"]
    scene.render.resolution_x = order["width"]
    scene.render.resolution_y = order["width"] * 9 // 16
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = order["picture"]
    bpy.ops.render.render(write_still=True)


def main() -> None:
    order = json.loads(sys.argv[1])
    begun = time.perf_counter()
    load(order)
    seen = vertices()
    loaded = time.perf_counter()
    np.savez(order["positions"], **seen)
    draw(order, seen)
    drawn = time.perf_counter()
    print(json.dumps({"import": loaded - begun, "picture": drawn - loaded}))


main()
