"""Tests of the page that plays runs and shows running simulations."""

import base64
import time
import urllib.request

import imageio.v3 as iio
import loomstone as ls
import numpy as np
import pytest
from browser import Browser
from loomstone import viewer
from loomstone.viewer.grips import BodyGrip, ClothGrip, ObstacleGrip
from loomstone.viewer.holding import Holder

pytest.importorskip("viser")

MESH = ls.grid(size=(0.4, 0.4), cells=(10, 10))
BALL = ls.meshes.sphere(radius=0.05, subdivisions=2)


def scene(**more):
    cloth = ls.Cloth(name="cloth", mesh=MESH.moved((0, 0, 0.3)), pins=[0, 10])
    return ls.Scene(cloths=[cloth], obstacles=[ls.sphere(radius=0.1, centre=(0, 0, 0.15))], **more)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("viewer") / "run"
    ls.Simulation(scene(), threads=1).run(out=out, duration=0.2, rate=25)
    return ls.Run(out)


def lead(sim, grip, duration):
    """Simulates `duration` [s] and calls grip.lead() after every step. Returns the largest number
    of pairs of triangles that intersect after a step.
    """
    end, most = sim.time + duration, 0
    while sim.time < end:
        begun = sim.time
        sim.step()
        grip.lead(sim, sim.time - begun)
        most = max(most, len(sim.intersecting_pairs()))
    return most


def test_fields_are_strains_of_the_cloth():
    flat = ls.grid(size=(0.2, 0.2), cells=(4, 4))
    sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=flat)]), threads=1)
    sim.positions = flat.vertices * (1.1, 1.0, 1.0)
    frame, topology = sim.frame(), sim.topology
    for field, value in (("stretch", 1.1), ("strain_weft", 0.1), ("strain_warp", 0.0)):
        assert np.allclose(ls._core.scalar_field(field, topology, frame), value, atol=1e-12), field
    assert not ls._core.scalar_field("contact", topology, frame).any()


def test_a_grip_brings_cloth_to_the_mouse_without_intersections():
    sim = ls.Simulation(scene(), threads=1)
    lead(sim, _Nothing(), 0.3)
    bottom = int(np.argmin(sim.positions[:, 2]))
    grip = Holder(scene(), sim).hold(sim, "cloth", 0, sim.positions[bottom])
    assert isinstance(grip, ClothGrip)
    grip.goal = np.array([0.05, 0.0, 0.35])  # above the ball
    assert lead(sim, grip, 1.5) == 0
    held = grip._centre(sim.positions) + grip._arm
    # The goal does not move, so the integral term of the grip's spring balances the weight, and the
    # cloth hangs only slightly below the goal.
    assert np.linalg.norm(held - grip.goal) < 5e-3
    grip.release(sim)
    assert not sim.external_forces.any()


def test_cloth_that_is_pulled_against_a_ball_stays_outside():
    sim = ls.Simulation(scene(), threads=1)
    lead(sim, _Nothing(), 0.3)
    grip = Holder(scene(), sim).hold(sim, "cloth", 0, (0.1, -0.1, 0.2))
    grip.goal = np.array([0.0, 0.1, 0.1])  # on the other side of the ball
    assert lead(sim, grip, 0.5) == 0


def test_a_grip_moves_a_body_and_keeps_it_there():
    ball = ls.RigidBody(mesh=BALL, density=500.0, position=(0, 0, 0.3))
    made = ls.Scene(bodies=[ball])
    sim = ls.Simulation(made, threads=1)
    wind = np.array([[0.5, 0.0, 0.0]])
    sim.external_body_forces = wind
    grip = Holder(made, sim).hold(sim, "body", 0, (0, 0, 0.3))
    assert isinstance(grip, BodyGrip)
    grip.goal = np.array([0.2, 0.1, 0.4])
    lead(sim, grip, 3.0)
    assert np.linalg.norm(sim.body_centres[0] - grip.goal) < 1e-3
    grip.release(sim)
    np.testing.assert_array_equal(sim.external_body_forces, wind)


def test_a_grip_moves_an_obstacle_from_its_present_place():
    moving = ls.sphere(radius=0.1, times=[0, 1], positions=[(0, 0, 0), (0.1, 0, 0)])
    made = ls.Scene(cloths=[ls.Cloth(mesh=MESH.moved((0, 0, 0.3)))], obstacles=[moving])
    sim = ls.Simulation(made, threads=1)
    lead(sim, _Nothing(), 0.2)
    place = sim.state.obstacle_vertices.mean(0)
    grip = Holder(made, sim).hold(sim, "body", 0, place)
    assert isinstance(grip, ObstacleGrip)
    grip.goal = place + (0.0, 0.0, -0.05)
    lead(sim, grip, 0.3)
    assert np.allclose(sim.state.obstacle_vertices.mean(0), grip.goal, atol=1e-6)


class _Nothing:
    def lead(self, sim, length):
        """Holds nothing."""


def test_floors_and_deforming_obstacles_are_not_held():
    wavy = ls.Obstacle(
        mesh=BALL, times=[0, 1], vertex_positions=np.concatenate([BALL.vertices, BALL.vertices])
    )
    cloth = ls.Cloth(mesh=MESH.moved((0, 0, 0.5)))
    made = ls.Scene(cloths=[cloth], obstacles=[ls.floor(height=-1.0), wavy])
    holder = Holder(made, ls.Simulation(made, threads=1))
    assert not holder.can_hold(0) and not holder.can_hold(1)


def test_a_run_is_served_and_played(run):
    player = viewer.play(run, port=0)
    try:
        assert b"<html" in urllib.request.urlopen(player.page.url).read().lower()
        _until(lambda: player.page.frame.time > 0.1)
    finally:
        player.stop()


@pytest.mark.parametrize("unreadable", [0, 1])
def test_new_frames_of_a_run_in_progress_are_shown(tmp_path, monkeypatch, unreadable):
    ls.Simulation(scene(), threads=1).run(out=tmp_path, duration=0.08)
    player = viewer.play(tmp_path, port=0)
    failures = iter([ls.CacheError("the file is being written")] * unreadable)

    def reopened(path):
        for failure in failures:
            raise failure
        return ls.Run(path)

    monkeypatch.setattr(viewer.player, "Run", reopened)
    try:
        ls.Simulation(scene(), threads=1).run(out=tmp_path, duration=0.2, resume=True)
        _until(lambda: player.page.frame.time > 0.15)
        assert player._slider.max == 5 and next(failures, None) is None
    finally:
        player.stop()


def test_a_run_is_played_with_at_most_30_pictures_per_second(run):
    player = viewer.play(run, port=0)
    shown = []
    player.page.show = lambda frame: shown.append(time.monotonic())  # takes no time
    try:
        _until(lambda: len(shown) >= 13)
    finally:
        player.stop()
    assert shown[12] - shown[1] > 10 / 30.0


def test_a_live_simulation_starts_again():
    shown = viewer.live(scene(), threads=1, port=0)
    times, show = [], shown.page.show

    def noted(frame):
        times.append(frame.time)
        show(frame)

    try:
        _until(lambda: shown.time > 0.05)
        shown.page.show = noted
        shown._ask_to_restart()
        _until(lambda: 0.0 in times and times[-1] > 0.0)
        assert shown.intersecting_pairs() == []
    finally:
        shown.stop()


def test_a_live_simulation_starts_and_pauses():
    shown = viewer.live(scene(), threads=1, port=0, paused=True)
    try:
        time.sleep(0.2)
        assert shown.time == 0.0
        shown.start()
        _until(lambda: shown.time > 0.05)
        shown.pause()

        def stands():
            before = shown.time
            time.sleep(0.2)
            return shown.time == before

        _until(stands)  # a step may be in progress
    finally:
        shown.stop()


def test_wrong_arguments_are_refused(run, tmp_path):
    with pytest.raises(ls.InvalidInput, match="color_by must be cloth"):
        viewer.write_html(run, tmp_path / "page.html", color_by="colour")
    with pytest.raises(ls.InvalidInput, match="every must be >= 1"):
        viewer.write_html(run, tmp_path / "page.html", every=0)
    assert not list(tmp_path.iterdir())


def test_a_page_without_server_holds_all_frames(run, tmp_path):
    small = viewer.write_html(run, tmp_path / "few.html", every=5)
    whole = viewer.write_html(run, tmp_path / "all.html", color_by="stretch")
    assert "__VISER_EMBED_DATA__" in small.read_text()
    assert whole.stat().st_size > small.stat().st_size
    assert sorted(p.name for p in tmp_path.iterdir()) == ["all.html", "few.html"]


def test_a_drag_in_a_browser_moves_cloth(tmp_path):
    camera = ls.Camera(eye=(0.0, -1.2, 0.3), target=(0, 0, 0.25), fit=False)
    shown = viewer.live(scene(), threads=1, camera=camera, port=0)
    try:
        with Browser(shown.page.url, tmp_path / "profile") as browser:
            _until(lambda: shown.page.server.get_clients(), 60)
            client = next(iter(shown.page.server.get_clients().values()))
            _until(lambda: np.allclose(client.camera.position, camera.eye, atol=1e-3))
            picture = client.get_render(300, 400)[:, :, :3].astype(float)
            _compare_with_renderer(shown, camera, picture)
            size = browser.call("Runtime.evaluate", expression="[innerWidth, innerHeight]+''")
            width, height = map(int, size["result"]["value"].split(","))
            x, y = _pixel_of_cloth(shown.frame, camera, width, height)
            before = shown.frame.positions.copy()
            browser.mouse("mouseMoved", x, y, pressed=False)
            browser.mouse("mousePressed", x, y)
            for i in range(1, 11):
                browser.mouse("mouseMoved", x - 8 * i, y - 4 * i)
                time.sleep(0.05)
            _until(lambda: np.abs(shown.frame.positions - before).max() > 0.05)
            browser.mouse("mouseReleased", x - 80, y - 40, pressed=False)
            assert shown.intersecting_pairs() == []
            _until(lambda: not shown._sim.external_forces.any())
    finally:
        shown.stop()


def _compare_with_renderer(shown, camera, picture):
    """Tests that the browser and the renderer draw cloth and ball at nearly the same pixels."""
    options = ls.RenderOptions(width=400, height=300, camera=camera, shadows=False)
    drawn = ls._core.Renderer(shown._sim.topology, options).render(shown.frame).astype(float)
    masks = []
    for image in (drawn, picture):
        # The background is uniform along each row of pixels. The cloth and the ball differ from it.
        masks.append(np.abs(image - image[:, :1]).max(2) > 20)
    # The masks may differ by a few pixels at edges, and by the motion between the two pictures.
    assert (masks[0] & masks[1]).sum() > 0.85 * (masks[0] | masks[1]).sum()


def _pixel_of_cloth(frame, camera, width, height):
    """Returns the pixel of a vertex of the hanging part of the cloth, near the plane x = 0.

    Of all such vertices, takes the closest to the eye along the viewing direction.
    """
    eye, target = np.array(camera.eye), np.array(camera.target)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    inside = np.flatnonzero((frame.positions[:, 2] < 0.25) & (np.abs(frame.positions[:, 0]) < 0.1))
    seen = inside[np.argmin((frame.positions[inside] - eye) @ forward)]
    way = frame.positions[seen] - eye
    scale = 0.5 * height / np.tan(np.radians(camera.field_of_view_degrees) / 2) / (way @ forward)
    return (
        0.5 * width + scale * (way @ right),
        0.5 * height - scale * (way @ np.cross(right, forward)),
    )


def _until(condition, limit=30.0):
    """Waits until condition() is true. Fails after `limit` [s], so that no test hangs."""
    end = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < end, "the page did not react"
        time.sleep(0.05)


def test_the_screenshot_of_a_page_without_server_shows_the_cloth(run, tmp_path):
    page = viewer.write_html(run, tmp_path / "page.html", every=5)
    with Browser(page.as_uri(), tmp_path / "profile") as browser:

        def shades():
            data = base64.b64decode(browser.call("Page.captureScreenshot")["data"])
            return len(np.unique(iio.imread(data, extension=".png")))

        _until(lambda: shades() > 60, 60)  # without the cloth, the page has only a few shades
