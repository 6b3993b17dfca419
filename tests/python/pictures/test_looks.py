"""Colours and textures of surfaces are those of the scene, also in pictures of a stored run."""

import loomstone as ls
import numpy as np
import pytest
from loomstone.base.images import read_image
from loomstone.cli import app
from PIL import Image
from typer.testing import CliRunner

SMALL = ls.RenderOptions(
    width=96,
    height=96,
    pattern="plain",
    shadows=False,
    ambient_occlusion=False,
    light_direction=(0, 0, 1),
    camera=ls.Camera(fit=False, eye=(0, 0, 1), up=(0, 1, 0), field_of_view_degrees=28.072),
)  # The square of 0.5 m fills the picture: tan(14.036 degrees) is 0.25 m / 1 m.

CHECKER = np.zeros((2, 2, 3), np.uint8)
CHECKER[0, 0], CHECKER[0, 1], CHECKER[1, 0], CHECKER[1, 1] = np.eye(3)[[0, 1, 2, 0]] * 255


def scene(look, **more):
    cloth = ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), cells=(4, 4)), pins=[0, 4, 20, 24], look=look)
    return ls.Scene(cloths=[cloth], gravity=(0, 0, 0), **more)


def drawn(look, **more):
    sim = ls.Simulation(scene(look, **more), threads=1)
    return ls.pictures.Renderer(sim.topology, SMALL).render(sim.frame()).astype(int)


def main_channel(picture, x, y):
    return int(np.argmax(picture[y, x]))


def test_a_texture_in_a_file_lies_on_the_cloth_by_its_uv(tmp_path):
    for name in ("checker.png", "checker.bmp"):
        path = tmp_path / name
        Image.fromarray(CHECKER).resize((64, 64), Image.Resampling.NEAREST).save(path)
        for given in (path, str(path), np.asarray(Image.open(path))):
            picture = drawn(ls.Look(texture=given))
            seen = [main_channel(picture, x, y) for y in (24, 72) for x in (24, 72)]
            assert seen == [0, 1, 2, 0]


def test_grey_images_of_16_bits_keep_their_values(tmp_path):
    grey = np.full((8, 8), 0x80FF, np.uint16)
    for name in ("grey.png", "grey.tif"):
        Image.fromarray(grey).save(tmp_path / name)
        assert (read_image(tmp_path / name) == (128, 128, 128, 255)).all()


def test_grey_images_of_32_bits_keep_values_of_bytes(tmp_path):
    Image.fromarray(np.full((8, 8), 200, np.int32)).save(tmp_path / "grey.tif")
    assert (read_image(tmp_path / "grey.tif") == (200, 200, 200, 255)).all()


def test_an_image_that_covers_the_cloth_once_does_not_wrap_at_the_border():
    halves = np.zeros((8, 8, 3), np.uint8)
    halves[:4, :, 0], halves[4:, :, 2] = 255, 255
    once, repeated = (drawn(ls.Look(texture=halves, texture_width=w))[:, 48] for w in (0, 0.5))
    assert (once[1:40, 0] > 2 * once[1:40, 2]).all() and (once[56:95, 2] > once[56:95, 0]).all()
    assert repeated[1, 0] < 2 * repeated[1, 2]  # blended with the image's last row


def seen_on_floor(floor, x, y):
    """Returns the strongest channel (0 to 2) at points (x, y, 0) [m] of a floor seen from above."""
    cloth = ls.Cloth(mesh=ls.grid(size=(0.5, 0.5), cells=(4, 4)).moved((0, 0, 0.1)))
    sim = ls.Simulation(ls.Scene(cloths=[cloth], obstacles=[floor]), threads=1)
    above = SMALL.camera.replace(eye=(0.6, 0, 1), target=(0.6, 0, 0))
    renderer = ls.pictures.Renderer(sim.topology, SMALL.replace(camera=above))
    picture = renderer.render(sim.frame()).astype(int)
    # The picture of 96 pixels shows 0.5 m. Its centre is at (0.6, 0), and y points up.
    columns = np.floor(48 + (np.asarray(x) - 0.6) / 0.5 * 96).astype(int)
    rows = np.floor(48 - np.asarray(y) / 0.5 * 96).astype(int)
    return picture[rows, columns].argmax(1)


# CHECKER with each pixel repeated 16 x 16 times, so that transitions between colours are narrow.
FINE = CHECKER.repeat(16, axis=0).repeat(16, axis=1)
PLACES = np.random.default_rng(5).uniform((0.38, -0.2), (0.8, 0.2), (200, 2))


def tiles(uv, width):
    """Returns the strongest channel of CHECKER, repeated every `width` [m], at uv [m]. Also returns
    which uv are not close to edges of CHECKER's pixels.

    Close means within 5 mm, which is about one pixel of the pictures of seen_on_floor().
    """
    at = uv / (0.5 * width)
    clear = (np.abs(at - np.rint(at)) * 0.5 * width > 5e-3).all(1)
    column, row = np.floor(at).astype(int).T % 2
    return np.array([[2, 0], [0, 1]])[row, column], clear  # row 0 is the lower one


def test_a_texture_repeats_on_a_floor_by_its_width_in_metres():
    width = 0.2
    floor = ls.floor(look=ls.Look(texture=FINE, texture_width=width))
    wanted, clear = tiles(PLACES, width)
    seen = seen_on_floor(floor, *PLACES.T)
    assert clear.sum() > 100 and set(wanted) == {0, 1, 2}
    assert np.array_equal(seen[clear], wanted[clear])


def test_a_texture_without_a_width_covers_the_square_of_a_floor_and_repeats_beyond_it():
    floor = ls.floor(size=0.8, look=ls.Look(texture=FINE))
    wanted, clear = tiles(PLACES - (-0.4, -0.4), 0.8)
    assert (PLACES[clear, 0] > 0.42).any(), "some places are outside the square"
    assert np.array_equal(seen_on_floor(floor, *PLACES.T)[clear], wanted[clear])


def test_a_texture_turns_and_moves_with_its_floor():
    floor = ls.floor(look=ls.Look(texture=FINE, texture_width=0.2)).replace(
        times=[0.0], positions=[(0.03, 0.05, 0.0)], axis_angles=[(0, 0, np.pi / 2)]
    )
    x, y = (PLACES - (0.03, 0.05)).T
    wanted, clear = tiles(np.column_stack([y, -x]), 0.2)
    assert np.array_equal(seen_on_floor(floor, *PLACES.T)[clear], wanted[clear])


def test_looks_are_stored_in_the_run_and_drawn_by_render(tmp_path):
    looks = [ls.Look(color=(0, 1, 0), roughness=0.3), ls.Look(texture=CHECKER, texture_width=0.1)]
    uv = ls.grid(size=(0.1, 0.1), cells=(1, 1)).moved((0, 0, -1))
    more = {
        "obstacles": [ls.obstacles.mesh(uv, look=looks[1]), ls.floor(height=-2)],
        "bodies": [
            ls.RigidBody(mesh=ls.meshes.sphere(radius=0.1), position=(9, 0, 0), look=looks[0])
        ],
    }
    sim = ls.Simulation(scene(looks[0], **more), threads=1)
    sim.run(out=tmp_path / "run", duration=0.04, render=SMALL)
    run = ls.Run(tmp_path / "run")
    assert run.topology.cloth_looks == [looks[0]]
    assert run.topology.body_looks == [looks[0], looks[1], ls.Look()]
    assert run.topology.body_looks[1].texture.shape == (2, 2, 4)
    assert np.array_equal(run.topology.body_corner_uv, sim.topology.body_corner_uv)
    assert run.topology.body_corner_uv.max() == 0.05
    done = CliRunner().invoke(app, ["render", str(run.directory), "--out", str(tmp_path / "new")])
    assert done.exit_code == 0, done.output
    path = tmp_path / "new" / "frame-00001.png"
    picture = np.asarray(Image.open(path)).astype(int)
    assert main_channel(picture, 12, 48) == 1
    assert np.array_equal(
        picture, np.asarray(Image.open(run.directory / "frames" / "frame-00001.png"))
    )


def test_a_run_without_looks_stores_none(tmp_path):
    import h5py

    ls.Simulation(scene(None), threads=1).run(out=tmp_path / "run", duration=0.04)
    with h5py.File(tmp_path / "run" / "run.vtkhdf") as file:
        assert "looks" not in file["loomstone"]
    assert ls.Run(tmp_path / "run").topology.cloth_looks == []


def test_a_look_does_not_change_the_motion_and_may_change_when_a_run_is_resumed(tmp_path):
    fall = scene(None).replace(gravity=(0, 0, -9.81))
    red = scene(ls.Look(color=(1, 0, 0))).replace(gravity=(0, 0, -9.81))
    one, other = ls.Simulation(fall, threads=1), ls.Simulation(red, threads=1)
    one.step(), other.step()
    assert np.array_equal(one.positions, other.positions)
    other.restore(one.checkpoint())


@pytest.mark.parametrize(
    "made, said",
    [
        (lambda path: ls.Look(texture=path / "none.png"), "there is no such image"),
        (lambda path: ls.Look(texture=path), "the image cannot be read: .*directory"),
        (lambda path: ls.Look(texture=path / "text.png"), "must be an image, such as a PNG"),
        (lambda path: ls.Look(texture=path / "cut.png"), "the image cannot be read"),
        (lambda _: ls.Look(texture=np.zeros((4, 4))), r"bytes \(uint8\) of shape .*got float64"),
        (lambda _: ls.Look(texture=np.zeros((4, 4), np.uint8)), r"got uint8 of shape \(4, 4\)"),
        (lambda _: drawn(ls.Look(color=(200, 0, 0))), r"\[0, 1\], got \(200, 0, 0\); divide"),
        (lambda _: ls.Look(roughness=2.0), r"roughness must be in \[0, 1\]"),
        (
            lambda _: drawn(None, obstacles=[ls.sphere(radius=0.1, look=ls.Look(texture=CHECKER))]),
            "needs a mesh with uv, but its mesh has none",
        ),
        (
            lambda _: drawn(
                None,
                obstacles=[
                    ls.sphere(radius=0.1, look=ls.Look(texture=CHECKER)).replace(floor=True)
                ],
            ),
            "needs a mesh with uv, but its mesh has none",
        ),
    ],
)
def test_a_wrong_look_is_refused_in_one_sentence(tmp_path, made, said):
    (tmp_path / "text.png").write_text("no image")
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)).save(
        tmp_path / "whole.png"
    )
    (tmp_path / "cut.png").write_bytes((tmp_path / "whole.png").read_bytes()[:400])
    with pytest.raises(ls.InvalidInput, match=said) as refused:
        made(tmp_path)
    assert "\n" not in str(refused.value)


def test_a_transparent_picture_has_alpha_and_no_video(tmp_path):
    ls.Simulation(scene(None), threads=1).run(out=tmp_path / "run", duration=0.04)
    out = tmp_path / "out"
    done = CliRunner().invoke(
        app, ["render", str(tmp_path / "run"), "--background", "none", "--width", "64", "--height",
              "64", "--fit", "--out", str(out)]
    )  # fmt: skip
    assert done.exit_code == 0 and not (out / "video.mp4").exists(), done.output
    picture = np.asarray(Image.open(out / "frame-00000.png"))
    assert picture.shape == (64, 64, 4)
    alpha = picture[..., 3]
    assert (alpha[:2] == 0).all() and (alpha == 255).sum() > 200


def test_a_look_shows_its_values_in_one_line():
    look = ls.Look(color=(1, 0, 0), texture=CHECKER)
    assert repr(look) == "Look(color=array([1., 0., 0.]), texture=image(2 x 2))"
    assert look == ls.Look(color=(1, 0, 0), texture=CHECKER.copy())
    assert look != look.replace(texture=CHECKER[::-1])
    assert look.to_dict()["texture"] == {"width": 2, "height": 2}
