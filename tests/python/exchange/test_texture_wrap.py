"""Exported textures: which of them repeat, and which files they replace."""

import loomstone as ls
import numpy as np
import pytest


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of two frames: a cloth and a wall with textures that repeat, and a cloth and a wall
    with textures that do not.
    """
    out = tmp_path_factory.mktemp("wrap") / "out"
    image = np.array([[[255, 0, 0], [0, 0, 255]]], np.uint8)
    flat = ls.grid(size=(0.1, 0.1), cells=(2, 2))
    looks = {"tiled": ls.Look(texture=image, texture_width=0.05), "once": ls.Look(texture=image)}
    cloths = [
        ls.Cloth(name=f"{name}_cloth", mesh=flat.moved((0, 0, height)), look=look)
        for height, (name, look) in enumerate(looks.items())
    ]
    walls = [
        ls.obstacles.mesh(flat.moved((1, 0, height)), name=f"{name}_wall", look=look)
        for height, (name, look) in enumerate(looks.items())
    ]
    scene = ls.Scene(cloths=cloths, obstacles=walls)
    ls.Simulation(scene, threads=1).run(out=out, duration=0.01, rate=100)
    return ls.Run(out)


def test_usd_repeats_only_textures_with_a_width(run, tmp_path):
    pxr = pytest.importorskip("pxr.Usd")
    stage = pxr.Stage.Open(str(run.export(tmp_path / "run.usdc")[0]))
    for name, wrap in (("tiled", "repeat"), ("once", "clamp")):
        for kind in ("cloth", "wall"):
            image = stage.GetPrimAtPath(f"/run/materials/{name}_{kind}_0/image")
            assert {image.GetAttribute(f"inputs:wrap{axis}").Get() for axis in "ST"} == {wrap}


def test_gltf_repeats_only_textures_with_a_width(run, tmp_path):
    pygltflib = pytest.importorskip("pygltflib")
    made = pygltflib.GLTF2().load(str(run.export(tmp_path / "run.glb")[0]))
    assert len(made.samplers) == 2  # shared by the textures of each kind
    for material in made.materials:
        texture = made.textures[material.pbrMetallicRoughness.baseColorTexture.index]
        sampler = made.samplers[texture.sampler]
        wrap = pygltflib.REPEAT if "tiled" in material.name else pygltflib.CLAMP_TO_EDGE
        assert (sampler.wrapS, sampler.wrapT) == (wrap, wrap)


def test_an_image_beside_a_usd_file_is_replaced_only_on_request(run, tmp_path):
    pytest.importorskip("pxr")
    run.export(tmp_path / "run.usda")
    image = tmp_path / "run-tiled_cloth.png"
    (tmp_path / "run.usda").unlink()
    image.write_text("mine")
    with pytest.raises(ls.InvalidInput, match=rf"{image.name}: exists already"):
        run.export(tmp_path / "run.usda")
    assert image.read_text() == "mine" and not (tmp_path / "run.usda").exists()
    run.export(tmp_path / "run.usda", overwrite=True)
    assert image.read_bytes().startswith(b"\x89PNG")
