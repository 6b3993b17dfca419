"""Obstacles with the same default name get numbers; names that the user gives must differ."""

import signal

import loomstone as ls
import pytest
from loomstone.runs.signals import Interrupted

SHEET = ls.Cloth(name="sheet", mesh=ls.grid(size=(0.2, 0.2), cells=(4, 4)))


def balls(n, **fields):
    return [ls.sphere(radius=0.02, centre=(0.1 * k, 0, -0.1), **fields) for k in range(n)]


def names(*obstacles, cloths=(SHEET,), **fields):
    scene = ls.Scene(cloths=list(cloths), obstacles=list(obstacles), **fields)
    return [obstacle.name for obstacle in scene.obstacles]


def test_obstacles_with_default_names_get_numbers():
    assert names(*balls(3)) == ["sphere", "sphere_2", "sphere_3"]
    assert names(*balls(1)) == ["sphere"] == [balls(1)[0].name]
    floor, box = ls.floor(height=-1.0), ls.obstacles.box(size=(0.1, 0.1, 0.1), centre=(0, 0, -0.5))
    mixed = [floor, *balls(1), box, *balls(1), floor]
    assert names(*mixed) == ["floor", "sphere", "box", "sphere_2", "floor_2"]


def test_every_shape_has_a_default_name_that_gets_a_number():
    at = {"centre": (0, 0, -1)}
    shapes = [
        lambda: ls.sphere(radius=0.1, **at),
        lambda: ls.obstacles.box(size=(0.1, 0.1, 0.1), **at),
        lambda: ls.obstacles.capsule(radius=0.1, length=0.2, **at),
        lambda: ls.obstacles.funnel(
            top_radius=0.2, bottom_radius=0.1, height=0.1, tube_length=0.1, wall=0.02, **at
        ),
        lambda: ls.obstacles.wave_bar(
            length=0.2, radius=0.02, amplitude=0.01, wavelength=0.1, **at
        ),
        lambda: ls.floor(height=-1.0),
    ]
    for shape, name in zip(
        shapes, ("sphere", "box", "capsule", "funnel", "bar", "floor"), strict=True
    ):
        assert names(shape(), shape()) == [name, f"{name}_2"]


def test_given_names_stay_and_must_differ():
    given = ls.sphere(radius=0.02, centre=(0, 0, -0.3), name="sphere")
    assert names(*balls(2), given) == ["sphere_2", "sphere_3", "sphere"]
    named = ls.Cloth(name="sphere", mesh=SHEET.mesh)
    assert names(*balls(1), cloths=[named]) == ["sphere_2"]
    taken = ls.sphere(radius=0.02, centre=(0, 0, -0.3), name="sphere_2")
    assert names(*balls(2), taken) == ["sphere", "sphere_3", "sphere_2"]
    with pytest.raises(ls.InvalidInput, match='unique, got "sphere" twice; rename one'):
        ls.Simulation(ls.Scene(cloths=[SHEET], obstacles=[given, given]))
    with pytest.raises(ls.InvalidInput, match='unique, got "ball" twice'):
        ls.Simulation(ls.Scene(cloths=[SHEET], obstacles=balls(2, name="ball")))


def test_numbers_are_stable_when_scenes_are_made_from_scenes():
    scene = ls.Scene(cloths=[SHEET], obstacles=balls(2))
    assert ls.Scene(cloths=[SHEET], obstacles=scene.obstacles) == scene
    assert scene.replace(gravity=(0, 0, 0)).obstacles == scene.obstacles
    more = scene.replace(obstacles=[*scene.obstacles, *balls(1)])
    assert [each.name for each in more.obstacles] == ["sphere", "sphere_2", "sphere_3"]
    twice = scene.replace(obstacles=[scene.obstacles[1], scene.obstacles[1]])
    assert len({each.name for each in twice.obstacles}) == 2


def test_an_obstacle_of_any_mesh_may_be_numbered():
    peg = ls.Obstacle(
        name="peg", mesh=ls.meshes.sphere(radius=0.01).moved((0, 0, -1)), numbered=True
    )
    assert names(peg, peg) == ["peg", "peg_2"]


def test_numbered_obstacles_are_found_by_their_names():
    magnet = ls.magnetics.cuboid(size=(0.01, 0.01, 0.01), polarization=(0, 0, 1))
    ball = ls.RigidBody(
        name="coin", mesh=ls.meshes.box(size=(0.01, 0.01, 0.01)), position=(0.1, 0, 0.1)
    )

    def with_magnet_on(name):
        there = magnet.moved((0.1, 0, -0.1))  # the obstacle's frame is that of the world
        magnets = [ls.Magnet(body="coin", source=magnet), ls.Magnet(body=name, source=there)]
        scene = ls.Scene(bodies=[ball], obstacles=balls(2), magnets=magnets)
        return ls.Simulation(scene, threads=1)

    assert with_magnet_on("sphere_2").topology.body_names == ["coin", "sphere", "sphere_2"]
    with pytest.raises(ls.InvalidInput, match="sphere_3"):
        with_magnet_on("sphere_3")


def test_a_run_with_numbered_obstacles_resumes_with_equal_bits(tmp_path):
    class Stopped(ls.Simulation):
        def step(self):
            super().step()
            if self.step_index == 5:
                signal.raise_signal(signal.SIGTERM)

    def made(kind=ls.Simulation):
        scene = ls.Scene(cloths=[SHEET.replace(friction=0.1)], obstacles=balls(2))
        return kind(scene, integrator=ls.SemiImplicitEuler(step=0.01), threads=1)

    whole = made().run(out=tmp_path / "whole", duration=0.2)
    with pytest.raises(Interrupted):
        made(Stopped).run(out=tmp_path / "stopped", duration=0.2)
    resumed = made().run(out=tmp_path / "stopped", duration=0.2, resume=True)
    assert resumed["digest"] == whole["digest"]
    assert ls.Run(tmp_path / "stopped").topology.body_names == ["sphere", "sphere_2"]
