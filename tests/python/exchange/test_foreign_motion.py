"""Details of glTF and USD files that other programs write, and the ends of their motions."""

import json

import loomstone as ls
import numpy as np
import pytest
from usd_stages import define_mesh, new_stage

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
SHIFT = np.tile(np.array([0, 0, 1], "<f4"), (3, 1))


def write_triangle(path, buffer, **node):
    """Writes a triangle with a morph target that shifts it by 1 along z (y after reading).

    buffer : name of the file with the numbers, as in the glTF file
    """
    pytest.importorskip("pygltflib")
    accessor = {"componentType": 5126, "count": 3, "type": "VEC3"}
    primitive = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}
    views = [{"buffer": 0, "byteOffset": k, "byteLength": 36} for k in (0, 36)]
    content = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **node}],
        "meshes": [{"primitives": [primitive], "weights": [0.0]}],
        "accessors": [{"bufferView": k, **accessor} for k in (0, 1)],
        "bufferViews": views,
        "buffers": [{"uri": buffer, "byteLength": 72}],
    }
    path.write_text(json.dumps(content))
    return path


def test_weights_of_a_node_of_gltf_replace_those_of_its_mesh(tmp_path):
    (tmp_path / "t.bin").write_bytes(CORNERS.tobytes() + SHIFT.tobytes())
    plain = ls.meshes.read(write_triangle(tmp_path / "a.gltf", "t.bin"))
    moved = ls.meshes.read(write_triangle(tmp_path / "b.gltf", "t.bin", weights=[0.5]))
    assert np.allclose(moved.vertices - plain.vertices, (0, -0.5, 0))


def test_a_buffer_of_gltf_is_found_by_its_encoded_name_and_named_if_it_is_missing(tmp_path):
    (tmp_path / "my dé.bin").write_bytes(CORNERS.tobytes() + SHIFT.tobytes())
    read = ls.meshes.read(write_triangle(tmp_path / "a.gltf", "my%20d%C3%A9.bin"))
    assert read.n_triangles == 1
    with pytest.raises(ls.CacheError, match=r"its data cannot be read: .*missing\.bin"):
        ls.meshes.read(write_triangle(tmp_path / "b.gltf", "missing.bin"))


@pytest.fixture
def stage(tmp_path):
    """Path of a file, its USD stage with time codes 1 to 3, and two meshes, `moving` and `other`.

    The points of `moving` shift by 1 m along x from one time code to the next.
    """
    path = tmp_path / "motion.usda"
    made, face = new_stage(path, codes=(1.0, 3.0)), np.array([[0, 1, 2]])
    moving, other = (
        define_mesh(made, f"/{name}", CORNERS + shift, face)
        for name, shift in (("moving", 0.0), ("other", 5.0))
    )
    for code in (1, 2, 3):
        moving.GetPointsAttr().Set((CORNERS + (code, 0, 0)).astype("f4"), code)
    return path, made, moving, other


def test_a_mesh_of_usd_that_is_hidden_at_all_time_codes_is_left_out(stage):
    path, made, _, other = stage
    attribute = other.CreateVisibilityAttr()
    attribute.Set("invisible", 1)
    made.Save()
    assert ls.obstacles.baked(path).mesh.n_vertices == 3
    attribute.Set("inherited", 2)
    made.Save()
    assert ls.obstacles.baked(path).mesh.n_vertices == 6


def test_faces_of_usd_may_be_stored_at_each_time_code_but_not_change(stage):
    path, made, moving, _ = stage
    for code in (1, 2, 3):
        moving.GetFaceVertexIndicesAttr().Set([0, 1, 2], code)
    made.Save()
    assert ls.obstacles.baked(path).mesh.n_triangles == 2
    moving.GetFaceVertexIndicesAttr().Set([0, 2, 1], 3)
    made.Save()
    with pytest.raises(
        ls.InvalidInput, match="must keep its faces, but they change at time code 3"
    ):
        ls.obstacles.baked(path)


def test_a_motion_is_read_to_its_end(stage):
    path, made, _, _ = stage
    made.SetEndTimeCode(2.6)
    made.Save()
    obstacle = ls.obstacles.baked(path)
    assert np.allclose(obstacle.times, np.array([0, 1, 1.6]) / made.GetTimeCodesPerSecond())
    frames = obstacle.vertex_positions.reshape(3, 6, 3)
    assert (frames[2] - frames[0])[:, 0].max() == pytest.approx(1.6)


@pytest.mark.parametrize("rate", [0.0, -24.0])
def test_time_codes_of_usd_need_a_rate(stage, rate):
    path, made, _, _ = stage
    made.SetTimeCodesPerSecond(rate)
    made.Save()
    for read in (ls.obstacles.baked, ls.meshes.read):
        with pytest.raises(ls.CacheError, match="timeCodesPerSecond must be above 0, got"):
            read(path)
