"""Legends have labels at the places of their numbers. Colour maps are those of matplotlib."""

import loomstone as ls
import numpy as np
import pytest
from loomstone.pictures.color_bar import bar_labels, bar_place, draw_color_bar, field_title
from loomstone.pictures.color_maps import color_table


@pytest.mark.parametrize("name", ["viridis", "magma", "cividis", "RdBu_r", "coolwarm", "inferno"])
def test_colour_maps_are_those_of_matplotlib(name):
    from matplotlib import colormaps

    theirs = colormaps[name](np.arange(256), bytes=True)[:, :3]
    # The two tables may round differently to bytes.
    assert np.abs(color_table(name)[0].astype(int) - theirs).max() <= 1


def test_a_map_of_few_colours_is_drawn_in_steps():
    table, _ = color_table("Set1")
    assert table.shape == (256, 3) and len(np.unique(table, axis=0)) == 9


def test_diverging_maps_are_known_and_an_unknown_map_is_refused():
    assert color_table("diverging")[1] and color_table("RdBu_r")[1]
    assert not color_table("viridis")[1]
    for name in ("nope", ""):
        with pytest.raises(ls.InvalidInput, match="such as viridis, .* got"):
            ls.pictures.Renderer(_sim().topology, ls.RenderOptions(color_map=name))


def _sim():
    mesh = ls.grid(size=(0.2, 0.2), cells=(4, 4))
    return ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh)]), threads=1)


@pytest.mark.parametrize(
    "limits",
    [(0, 1), (1.0, 1.55), (-0.2, 0.17), (1.0, 1.000684), (1.0, 1.000002), (-3e3, 12e3), (1e6, 3e6)],
)
def test_labels_stand_where_their_numbers_are_and_never_collide(limits):
    low, high = limits
    labels = bar_labels(low, high)
    places = np.array([place for place, _ in labels])
    assert len(labels) >= 3 and np.all(np.diff(places) > 0.08)
    values = np.array([float(text) for _, text in labels])
    # The numbers in the labels are rounded by up to 0.005 of the range.
    assert np.all(np.abs(values - low - places * (high - low)) <= 0.006 * (high - low))


def test_labels_at_the_ends_have_enough_digits():
    assert [text for _, text in bar_labels(1.0, 1.25)][:: len(bar_labels(1.0, 1.25)) - 1] == [
        "1.00",
        "1.25",
    ]
    assert bar_labels(-0.0413, 0.0413)[0][1] == "-0.0413"
    assert bar_labels(0.0, 3e7)[-1][1] == "3e+07"
    assert bar_labels(1.0, 1.000684)[-1][1] == "1.000684"


@pytest.mark.parametrize("channels", [3, 4])
def test_the_ends_of_the_bar_have_the_end_colours(channels):
    table, _ = color_table("magma")
    blank = np.full((360, 640, channels), 255, np.uint8)
    image = draw_color_bar(blank, table, (0.0, 1.0), "stretch")
    left, top, width, height = bar_place(640, 360)
    middle = left + width // 2
    assert np.array_equal(image[top, middle, :3], table[255])
    assert np.array_equal(image[top + height - 1, middle, :3], table[0])
    title = image[:top, :, :3].min(2)
    assert (title < 100).sum() > 60  # the title is written above the bar
    labels = image[top : top + height, left + width + 2 :, :3].min(2)
    assert (labels < 100).sum() > 100
    # Nothing touches the right edge, so no label is cut off.
    assert (image[:, -2:] == 255).all()


@pytest.mark.parametrize("name", ["stretch", "strain_split", "contact"])
@pytest.mark.parametrize("size", [(320, 180), (1280, 720), (400, 400)])
def test_titles_stand_above_the_bar_within_the_legend(name, size):
    width, height = size
    table, _ = color_table("viridis")
    blank = np.full((height, width, 3), 255, np.uint8)
    image = draw_color_bar(blank, table, (0.0, 1.0), field_title(name))
    left, top, _, _ = bar_place(*size)
    assert (image[:, : left - 1] == 255).all() and (image[:, -1] == 255).all()
    rows = np.flatnonzero((image[: top - 2].min(2) < 100).any(1))
    assert rows.size >= 5 and rows[0] > 0


def test_a_picture_of_a_field_has_a_legend_and_one_of_the_cloth_has_none():
    sim = _sim()
    sim.positions = sim.positions * (1.2, 1.0, 1.0)
    frame = sim.frame()
    options = ls.RenderOptions(width=320, height=180, color_by="cloth+stretch")
    renderer = ls.pictures.Renderer(sim.topology, options)
    cloth, stretch = np.split(renderer.render(frame), 2)
    left, top, width, height = bar_place(320, 180)
    strip = (slice(top, top + height), slice(left, left + width))
    assert np.ptp(stretch[strip].reshape(-1, 3), axis=0).max() > 150
    assert np.ptp(cloth[strip].reshape(-1, 3), axis=0).max() < 60
    assert renderer.color_ranges(frame)[1] == pytest.approx((1.2, 1.2), rel=1e-5)
    again = ls.pictures.Renderer(sim.topology, options).render(frame)
    assert np.array_equal(again, renderer.render(frame))


@pytest.mark.parametrize("size", [(320, 180), (1280, 720), (400, 400)])
def test_a_fitted_picture_of_a_field_keeps_the_cloth_off_the_legend(size):
    mesh = ls.grid(size=(1.0, 0.1), cells=(20, 2))
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh)]), threads=1)
    width, height = size
    look = ls.RenderOptions(width=width, height=height, color_by="stretch", samples=1)
    look = look.replace(camera=ls.Camera(eye=(0.0, 0.0, 1.0), up=(0.0, 1.0, 0.0), fit=True))

    def columns(options):
        return np.flatnonzero(
            (ls.pictures.Renderer(sim.topology, options).surfaces(sim.frame())[2] == 1).any(0)
        )

    assert width * 0.55 < np.ptp(columns(look)) and columns(look).max() < bar_place(*size)[0]
    assert columns(look.replace(color_by="cloth")).max() > bar_place(*size)[0]
