"""Bodies that magnetic forces press together come to rest, whatever their restitution."""

import loomstone as ls
import pytest


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
def test_magnets_that_bounce_come_to_rest_on_each_other(restitution):
    size = (0.01, 0.01, 0.01)
    source = ls.magnetics.cuboid(size=size, polarization=(0, 0, 1.0))
    bodies = [
        ls.RigidBody(
            name=name,
            mesh=ls.meshes.box(size=size),
            shape="box",
            density=7500,
            restitution=restitution,
            position=(0, 0, height),
        )
        for name, height in (("lower", 0), ("upper", 0.012))
    ]
    magnets = [ls.Magnet(body=body.name, source=source) for body in bodies]
    scene = ls.Scene(bodies=bodies, magnets=magnets, gravity=(0, 0, 0))
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=1e-3), threads=1)
    farthest, gain = 0.0, 0.0
    for _ in range(100):
        sim.step()
        gain = max(gain, sim.report.account.balance)
        if sim.time > 0.08:
            gap = sim.body_centres[1, 2] - sim.body_centres[0, 2] - 0.01
            farthest = max(farthest, abs(gap))
    assert farthest < 1e-6, "they touch; a restitution of the attraction would keep 20 um and more"
    assert gain < 0.02, "the account never rises"
