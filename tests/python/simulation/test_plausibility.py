"""A scene that can be simulated but looks like a mistake causes a warning of one sentence."""

import re
import warnings

import loomstone as ls
import numpy as np
import pytest
from loomstone.runs.frame_times import frame_count, warn_of_part_frame

BOX = ls.meshes.box(size=(0.02, 0.02, 0.02))
GRID = ls.grid(size=(0.2, 0.2), cells=(4, 4))


def cloth(**fields):
    return ls.Cloth(**({"name": "sheet", "mesh": GRID} | fields))


def scene(*cloths, **fields):
    return ls.Scene(cloths=list(cloths), **fields)


def told(described, **options):
    """Builds a simulation and returns the warnings that this causes."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ls.Simulation(described, threads=1, **options)
    assert all(each.category is ls.SceneWarning for each in caught)
    assert all(each.filename == __file__ for each in caught), "the caller's line is named"
    return [str(each.message) for each in caught]


def with_uv(scale):
    uv = scale * (np.asarray(GRID.vertices)[:, :2] + 0.1)
    return ls.TriangleMesh(GRID.vertices, GRID.triangles, uv)


def strip(weft, warp):
    """A strip of weft x warp [m] whose uv fill the unit square."""
    mesh = ls.grid(size=(weft, warp), cells=(4, 4))
    uv = np.asarray(mesh.vertices)[:, :2] / (weft, warp) + 0.5
    return ls.TriangleMesh(mesh.vertices, mesh.triangles, uv)


def jumping(times, places):
    """A cloth whose first vertex follows a script."""
    start = np.asarray(GRID.vertices)[0]
    return cloth(pins=[0], script_times=times, script_positions=[start + p for p in places])


def in_reversed_box():
    outward = ls.meshes.box(size=(1.0, 1.0, 1.0))
    inward = ls.TriangleMesh(outward.vertices, np.asarray(outward.triangles)[:, ::-1])
    return scene(cloth(), obstacles=[ls.Obstacle(name="room", mesh=inward)])


def ball(**fields):
    """A sphere below the cloth. `fields` may contain keyframes of its motion."""
    return ls.sphere(radius=0.05, centre=(0, 0, -0.5), **fields)


def turning(angles):
    """A cloth above a ball that turns about z to the given angles [rad], 25 of them per second."""
    vectors = [(0, 0, angle) for angle in angles]
    times = np.arange(len(vectors)) / 25
    return scene(cloth(), obstacles=[ball(times=times, axis_angles=vectors)])


def two_boxes(apart, **fields):
    return ls.Scene(
        bodies=[
            ls.RigidBody(name=name, mesh=BOX, shape="box", position=(x, 0, 0.5))
            for name, x in (("left", 0.0), ("right", apart))
        ],
        **fields,
    )


def magnet(body, size, at=(0.0, 0.0, 0.0)):
    source = ls.magnetics.cuboid(size=(size, size, size), polarization=(0, 0, 1)).moved(at)
    return ls.Magnet(body=body, source=source)


def attached_to_two():
    return scene(
        cloth(),
        bodies=two_boxes(0.3).bodies,
        attachments=[
            ls.Attachment(cloth="sheet", body="left", vertices=[3, 4]),
            ls.Attachment(cloth="sheet", body="right", vertices=[3, 5]),
        ],
        collisions=False,
    )


MISTAKES = {
    "texture coordinates taken as metres": (
        scene(cloth(mesh=with_uv(5.0))),
        r'cloths\[0\] \("sheet"\): its rest area is 1 m\^2 .* starts with 0.04 m\^2; .*rest="mesh"',
    ),
    "texture coordinates of a strip with the area of their square": (
        scene(cloth(mesh=strip(2.0, 0.5))),
        r"its uv fill a square of 1 m, .* 2 along weft and 0.5 along warp; .*rest=\"mesh\"",
    ),
    "a density in g/m^2": (
        scene(cloth(material=ls.ClothMaterial(density=150))),
        r"its density is 150 kg/m\^2, but fabrics .* if 150 g/m\^2 is meant, give 0.15",
    ),
    "a pattern in centimetres": (
        scene(cloth(mesh=with_uv(100.0))),
        r"its rest area is 400 m\^2 .* if uv are in centimetres, give TriangleMesh\(.* 0.01 \*",
    ),
    "a stiffness in N/mm": (
        scene(cloth(material=ls.ClothMaterial(warp_stiffness=0.5))),
        r"its warp_stiffness is 0.5 N/m, .* if 0.5 N/mm is meant, give 500",
    ),
    "a bending rigidity in uN m": (
        scene(cloth(material=ls.ClothMaterial(bending_weft=7.2, bending_warp=7.2))),
        r"its bending_weft is 7.2 N m, .* if 7.2 uN m is meant, give 7.2e-06",
    ),
    "pins that a script pulls apart": (
        scene(
            cloth(
                pins=[0, 1],
                script_times=[0.0, 1.0],
                script_positions=[
                    *np.asarray(GRID.vertices)[:2],
                    *(np.asarray(GRID.vertices)[:2] * (1.3, 1, 1)),
                ],
            )
        ),
        r"pulls the adjacent vertices 0 and 1 apart, by 30 % at 1 s; move pins like a rigid body",
    ),
    "a strain limit in per cent": (
        scene(cloth(strain_limit=ls.StrainLimit(0.5, 5, 20))),
        r"its strain limit along warp is 5, which is 500 %; if 5 % is meant, give 0.05",
    ),
    "wind without drag": (
        scene(cloth(), air=ls.Air(wind=(5, 0, 0))),
        r"scene.air: its wind has no effect, .* give a normal_drag of about 1",
    ),
    "wind without air": (
        scene(cloth(), air=ls.Air(density=0, wind=(5, 0, 0), normal_drag=1)),
        r"scene.air: its wind has no effect, because density is 0; give a density of 1.2 kg/m\^3",
    ),
    "a mesh of cloth in millimetres": (
        scene(cloth(mesh=GRID.moved(scale=1000))),
        r"cloths\[0\] .* is 200 m long; if its file is in millimetres, scale it by 0.001",
    ),
    "an obstacle in millimetres": (
        scene(
            cloth(mesh=GRID.moved((0, 0, 300.0))),
            obstacles=[ls.obstacles.mesh(BOX.moved(scale=1e4), name="block")],
        ),
        r'obstacles\[0\] \("block"\): its mesh is 200 m long',
    ),
    "a start inside the contact distance": (
        scene(cloth(mesh=GRID.moved((0, 0, 1e-3))), obstacles=[ls.floor()]),
        r'"sheet" starts 1 mm from "floor", but the contact distance is 5.69 mm \(\d+ such',
    ),
    "bodies that overlap": (
        two_boxes(0.015),
        r'bodies\[0\] \("left"\) and bodies\[1\] \("right"\) overlap at the start',
    ),
    "a body that sticks in the floor": (
        two_boxes(0.3, obstacles=[ls.floor(height=0.495)]),
        r'bodies\[0\] \("left"\) and obstacles\[0\] \("floor"\) overlap at the start',
    ),
    "a body inside an obstacle": (
        two_boxes(0.3, obstacles=[ls.obstacles.box(size=(0.1, 0.1, 0.1), centre=(0, 0, 0.5))]),
        r"bodies\[0\] .* and obstacles\[0\] .* overlap at the start",
    ),
    "magnets that overlap, on bodies that do not": (
        two_boxes(0.04, magnets=[magnet("left", 0.02, (0.022, 0, 0)), magnet("right", 0.02)]),
        r'magnets\[0\] on bodies\[0\] \("left"\) and magnets\[1\] on .* overlap at the start',
    ),
    "magnets that overlap on one body": (
        two_boxes(0.3, magnets=[magnet("left", 0.01, (x, 0, 0)) for x in (0.0, 0.004)]),
        r'magnets\[0\] and magnets\[1\] on bodies\[0\] \("left"\) overlap, so their polariz',
    ),
    "a reversed obstacle around cloth": (
        in_reversed_box(),
        r'obstacles\[0\] \("room"\) is closed but faces inwards .* cloths\[0\] .* starts inside',
    ),
    "a magnet larger than its body": (
        two_boxes(0.3, magnets=[magnet("left", 0.03)]),
        r'magnets\[0\] reaches 8.66 mm out of its body, bodies\[0\] \("left"\)',
    ),
    "a vertex attached to two bodies": (
        attached_to_two(),
        'vertex 3 of "sheet" is attached to "left" and to "right", which joins these bodies',
    ),
    "pins that jump at the start": (
        scene(jumping([0.0, 1.0], [(0, 0, 0.02), (0, 0, 0.05)])),
        r"vertex 0 jumps by 20 mm in the first step",
    ),
    "pins that jump later": (
        scene(jumping([0.0, 1.0, 1.001], [(0, 0, 0), (0, 0, 0), (0, 0, 0.3)])),
        r"vertex 0 jumps by 0.3 m from 1 s to 1.001 s \(300 m/s\), which tears cloth",
    ),
    "frame numbers as times of pins": (
        scene(jumping(list(range(51)), [(0, 0, 1e-3 * k) for k in range(51)])),
        r'cloths\[0\] \("sheet"\): its script_times are whole numbers up to 50 s; .* / 25',
    ),
    "frame numbers as times of an obstacle": (
        scene(cloth(), obstacles=[ball(times=[0, 120], positions=[(0, 0, -1), (0, 0, -0.5)])]),
        r'obstacles\[0\] \("sphere"\): its times are whole numbers up to 120 s',
    ),
    "angles in whole degrees": (
        scene(cloth(), obstacles=[ball(times=[0, 1], axis_angles=[(0, 0, 0), (0, 0, 90)])]),
        r"its axis_angles reach 90 rad; if 90 degrees are meant, give np.radians\(axis_angles\)",
    ),
    "a constant angle in degrees": (
        scene(cloth(), obstacles=[ball(times=[0], axis_angles=[(22.5, 0, 0)])]),
        r"its axis_angles reach 22.5 rad; if 22.5 degrees are meant",
    ),
    "angles in broken degrees": (
        scene(
            cloth(),
            obstacles=[ball(times=[0, 1, 2], axis_angles=[(0, 0, 0), (0, 0, 22.5), (0, 0, 45)])],
        ),
        r"turn it by 22.5 rad from 0 s to 1 s, but it turns the shorter way, .* degrees are meant",
    ),
    "a turn between two keyframes": (
        scene(cloth(), obstacles=[ball(times=[0, 1], axis_angles=[(0, 0, 0), (0, 0, 2 * np.pi)])]),
        r"turn it by 6.283 rad from 0 s to 1 s, .* give a keyframe for every third of a turn",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_scene_that_looks_like_a_mistake_is_told_when_it_is_built(name):
    described, sentence = MISTAKES[name]
    found = [each for each in told(described) if re.search(sentence, each)]
    assert len(found) == 1, told(described)
    assert "\n" not in found[0]


@pytest.mark.parametrize(
    "described",
    [
        scene(cloth(), obstacles=[ls.sphere(radius=0.1, centre=(0, 0, -0.11))]),
        scene(cloth(mesh=with_uv(5.0), rest="mesh")),
        scene(cloth(mesh=with_uv(0.95))),
        scene(cloth(mesh=strip(1.1, 0.95))),
        scene(cloth(), obstacles=[ls.floor(size=100.0, height=-1.0)]),
        two_boxes(0.02, obstacles=[ls.floor(height=0.49)]),
        two_boxes(0.3, magnets=[magnet("left", 0.02), magnet("right", 0.02)]),
        two_boxes(0.3, magnets=[magnet("left", 0.01, (x, 0, 0)) for x in (-0.005, 0.005)]),
        scene(jumping([0.0, 0.1], [(0, 0, 0), (0, 0, 1.0)])),
        scene(jumping([-1.0, 1.0], [(0, 0, -1.0), (0, 0, 1.0)])),
        scene(jumping([0, 30], [(0, 0, 0), (0, 0, 1.0)])),
        scene(jumping([0, 5, 10, 20], [(0, 0, k) for k in range(4)])),
        turning(np.linspace(0.0, 20 * np.pi, 100)),
        turning([0, 1, 2, 3]),
        turning([0.0, np.pi]),
        turning([2.5, 3.1, 3.7 - 2 * np.pi, 4.3 - 2 * np.pi]),
        turning([5.7, 6.2, 0.4, 0.9]),
    ],
    ids=[
        "beside a sphere",
        "texture coordinates with rest lengths of the mesh",
        "a cloth that is slightly stretched",
        "a square of about a metre",
        "a large floor",
        "boxes that touch each other and the floor",
        "magnets that fill their bodies",
        "magnets that touch on one body",
        "a fast pin",
        "a script that begins earlier",
        "a slow script of two whole seconds",
        "a script of whole seconds",
        "ten turns",
        "angles of whole radians",
        "half a turn",
        "rotation vectors of at most half a turn",
        "rotation vectors of at most a turn",
    ],
)
def test_a_plausible_scene_causes_no_warning(described):
    assert told(described) == []


def test_a_mesh_in_millimetres_causes_one_warning():
    assert len(told(scene(cloth(mesh=GRID.moved(scale=1000))))) == 1


def test_asynchronous_steps_need_no_distance_at_the_start():
    described, _ = MISTAKES["a start inside the contact distance"]
    assert told(described, integrator=ls.Asynchronous()) == []


def test_a_pinned_sheet_within_the_contact_distance_is_not_thrown_off():
    low = GRID.moved((0, 0, 1e-3))
    described = scene(cloth(mesh=low, pins=list(range(25))), obstacles=[ls.floor()])
    assert told(described) == []


def test_near_contacts_are_those_closer_than_the_contact_distance():
    low = GRID.moved((0, 0, 1e-3))
    with pytest.warns(ls.SceneWarning, match="starts 1 mm from"):
        sim = ls.Simulation(scene(cloth(mesh=low), obstacles=[ls.floor()]), threads=1)
    vertices, distances, thicknesses = sim.near_contacts()
    assert vertices.shape == (len(distances), 4) and len(distances) >= 25
    assert distances == pytest.approx(1e-3) and (distances < thicknesses).all()
    assert set(range(25)) <= set(vertices.ravel()), "every vertex of the sheet is near the floor"
    far = ls.Simulation(scene(cloth(), obstacles=[ls.floor(height=-1.0)]), threads=1)
    assert len(far.near_contacts()[1]) == 0
    alone = ls.Simulation(scene(cloth(mesh=low), collisions=False), threads=1)
    assert alone.near_contacts()[0].shape == (0, 4)


def test_warnings_can_be_made_errors():
    with warnings.catch_warnings(), pytest.raises(ls.SceneWarning, match="density"):
        warnings.simplefilter("error", ls.SceneWarning)
        ls.Simulation(MISTAKES["a density in g/m^2"][0])


@pytest.mark.parametrize(
    "duration, said",
    [
        (0.02, "duration 0.02 s is 0.5 frames at 25 frames/s, so no step is taken; 0.04 s is"),
        (3e-5, "so no step is taken; 0.04 s is"),
        (0.1, "2.5 frames at 25 frames/s, so the simulation ends at 0.08 s; 0.12 s is a whole"),
    ],
)
def test_a_duration_that_is_no_whole_number_of_frames_is_told(duration, said, tmp_path):
    sim = ls.Simulation(scene(cloth()), threads=1)
    with pytest.warns(ls.SceneWarning, match=said) as caught:
        list(sim.frames(duration=duration))
    assert caught[0].filename == __file__
    with pytest.warns(ls.SceneWarning, match=said) as caught:
        sim.run(out=tmp_path, duration=duration)
    assert caught[0].filename == __file__


@pytest.mark.filterwarnings("error::loomstone.SceneWarning")
def test_whole_numbers_of_frames_are_not_told_whatever_their_rounding():
    sim = ls.Simulation(scene(cloth(), collisions=False), threads=1)
    for frames in (0, 1, 3, 7):
        list(sim.frames(duration=frames / 30.0, rate=30.0))
    # Durations of 9, 30, 240 and 3,000 frames of NTSC video, with rounded frame rates.
    for duration, rate in ((0.3003, 29.97), (1.001, 29.97), (10.01, 23.976), (100.1, 29.97)):
        warn_of_part_frame(duration, rate)
        assert frame_count(duration, rate) == round(duration * rate) + 1
    assert frame_count(0.3, 29.97) == 9  # 8.991 frames


@pytest.mark.parametrize("scheme", [ls.SymplecticEuler, ls.ExplicitEuler])
def test_given_steps_at_which_an_explicit_scheme_is_unstable_are_named(scheme):
    stable = ls.Simulation(scene(cloth())).stable_step()
    assert 1e-5 < stable < 1e-2
    with pytest.warns(
        ls.SceneWarning, match="longer than the longest stable step .*, so the cloth"
    ):
        ls.Simulation(scene(cloth()), integrator=scheme(step=1.1 * stable))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ls.Simulation(scene(cloth()), integrator=scheme(step=0.9 * stable))
        ls.Simulation(scene(cloth()), integrator=scheme())


def test_a_step_that_ends_just_before_a_frame_completes_it(tmp_path):
    euler = ls.SemiImplicitEuler(step=0.0099999995, accuracy=None)
    sims = [
        ls.Simulation(scene(cloth(), collisions=False), integrator=euler, threads=1)
        for _ in range(2)
    ]
    assert len(list(sims[0].frames(duration=1.0, rate=1.0))) == 2
    assert sims[1].run(out=tmp_path / "out", duration=1.0, rate=1.0)["frames"] == 2
