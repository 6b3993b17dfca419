"""Moments of magnetisable cylinders and rings agree with an independent solver and with closed
forms. Forces in scenes agree with those of loomstone.magnetics.
"""

import loomstone as ls
import numpy as np
import pytest
from loomstone import magnetics as M
from scipy.special import ellipe, ellipk, ellipkm1


def polarizability(body, volume, axis):
    """Returns the moment that a field along an axis induces, per volume and field strength [1]."""
    (induced,) = M.induce(body, field=M.MU0 * np.eye(3)[axis]).bodies
    across = np.delete(induced.moment, axis)
    assert np.abs(across).max() < 1e-12 * np.abs(induced.moment[axis]), "by symmetry"
    return induced.moment[axis] / volume


def conductor(radius, inner, height, axis, segments=80):
    """Polarizability [1] of a cylinder or ring of ideal iron, along z (axis=2) or x (axis=0).

    In a uniform field of 1 A/m, the surface of the body is an equipotential. Collocation solves the
    integral equation of the first kind for the surface charge. The charge consists of rings, along
    which it is uniform (axis=2) or proportional to the cosine of the azimuth (axis=0). Each side of
    the cross-section is divided into `segments` segments, which become shorter towards its ends.
    """
    half = 0.5 * height
    corners = [(inner, -half), (radius, -half), (radius, half), (inner, half)] + (
        [(inner, -half)] if inner > 0 else []
    )
    t = 0.5 * (1 - np.cos(np.linspace(0, np.pi, segments + 1)))
    start = np.vstack(
        [
            np.add(a, np.outer(t[:-1], np.subtract(b, a)))
            for a, b in zip(corners, corners[1:], strict=False)
        ]
    )
    end = np.vstack(
        [
            np.add(a, np.outer(t[1:], np.subtract(b, a)))
            for a, b in zip(corners, corners[1:], strict=False)
        ]
    )
    middle, length = 0.5 * (start + end), np.linalg.norm(end - start, axis=1)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    s, w = 0.5 * (1 + nodes), 0.5 * weights
    # The quadrature nodes of a segment are graded quadratically towards its middle. There, the
    # integrand of the potential of the segment's own charge has a logarithmic singularity.
    places = np.concatenate([0.5 - 0.5 * s**2, 0.5 + 0.5 * s**2])
    shares = np.concatenate([s * w, s * w])
    matrix = np.zeros((len(middle), len(middle)))
    for place, share in zip(places, shares, strict=True):
        ring = start + place * (end - start)
        d2 = (middle[:, None, 0] + ring[None, :, 0]) ** 2 + (
            middle[:, None, 1] - ring[None, :, 1]
        ) ** 2
        rest = (
            (middle[:, None, 0] - ring[None, :, 0]) ** 2
            + (middle[:, None, 1] - ring[None, :, 1]) ** 2
        ) / d2
        around, m = ellipkm1(rest), 1 - rest
        if axis != 2:  # the same integral, weighted by the cosine of the azimuth
            around = (2 / m - 1) * around - 2 / m * ellipe(m)
        matrix += share * length * ring[:, 0] * around / (np.pi * np.sqrt(d2))
    along = middle[:, 1] if axis == 2 else middle[:, 0]
    mean = 2 if axis == 2 else 1  # twice the azimuthal mean of 1 or of cos^2
    charge = np.linalg.solve(matrix, along)
    return (charge * mean * np.pi * middle[:, 0] * length * along).sum() / (
        np.pi * (radius**2 - inner**2) * height
    )


# Each row: radius, inner radius and height [m], `cells` of soft_cylinder(), and a bound on the
# relative error.
@pytest.mark.parametrize(
    ("radius", "inner", "height", "cells", "error"),
    [
        (1.0, 0.0, 2.0, 8, 2e-4),
        (1.0, 0.0, 2.0, 12, 4e-5),
        (1.0, 0.0, 20.0, 8, 1e-3),
        (1.0, 0.0, 0.2, 8, 1e-3),
        (1.0, 0.5, 1.0, 8, 2e-3),
        (1.0, 0.5, 1.0, 12, 2e-4),
    ],
)
def test_ideal_iron_is_polarised_as_a_conductor_is(radius, inner, height, cells, error):
    body = M.soft_cylinder(
        radius=radius, height=height, inner_radius=inner, susceptibility=np.inf, cells=cells
    )
    for axis in (2, 0):
        found = polarizability(body, np.pi * (radius**2 - inner**2) * height, axis)
        assert found == pytest.approx(conductor(radius, inner, height, axis), rel=error), axis


@pytest.mark.parametrize("slenderness", [0.3, 1.0, 4.0])
def test_weak_magnetisation_has_the_demagnetising_factors_of_uniform_cylinders(slenderness):
    # The axial demagnetising factor is that of [Joseph1966]. The factors along the three axes add
    # up to 1.
    t = slenderness
    m = 1 / (1 + t * t)
    axial = 1 - 4 / (3 * np.pi * t) * (
        np.sqrt(1 + t * t) * (t * t * ellipk(m) + (1 - t * t) * ellipe(m)) - 1
    )
    chi, volume = 0.01, np.pi * 2 * t
    for axis, factor in ((2, axial), (0, 0.5 * (1 - axial))):
        both = [
            polarizability(M.soft_cylinder(radius=1, height=2 * t, susceptibility=c), volume, axis)
            for c in (chi, -chi)
        ]
        # The polarizability is chi (1 - N chi + ...) with the demagnetising factor N. In the sum
        # over both signs of chi, the odd orders cancel. The term of second order is -2 N chi^2, and
        # higher orders are negligible.
        assert -sum(both) / (2 * chi * chi) == pytest.approx(factor, rel=2e-3)


def test_a_scene_pulls_an_iron_rod_as_the_functions_do():
    rod = ls.RigidBody(
        name="rod",
        mesh=ls.meshes.box(size=(0.005, 0.005, 0.02)),
        position=(0, 0, 0.03),
        density=7800,
    )
    by = M.cylinder(radius=0.01, height=0.01, polarization=(0, 0, 1.2))
    alone = M.soft_cylinder(radius=0.004, height=0.02, susceptibility=500.0)
    magnets = [ls.Magnet(body="rod", source=alone), ls.Magnet(body="base", source=by)]
    base = ls.obstacles.mesh(ls.meshes.box(size=(0.014, 0.014, 0.01)), name="base")
    sim = ls.Simulation(
        ls.Scene(bodies=[rod], obstacles=[base], magnets=magnets, gravity=(0, 0, 0))
    )
    (induced,) = M.induce(alone.moved((0, 0, 0.03)), by=by).bodies
    wanted = M.force(on=induced, by=by).force
    assert wanted[2] < -0.3, "towards the magnet [N]"
    assert np.allclose(sim.magnetic_forces()[0][0], wanted, rtol=1e-3, atol=1e-4 * abs(wanted[2]))


def test_what_is_no_cylinder_is_refused():
    good = {"radius": 0.01, "height": 0.01, "susceptibility": 100.0}
    for change, message in (
        ({"cells": 10}, "cells of a cylinder must be a multiple of 4 from 8 to 24, got 10"),
        ({"cells": 28}, "cells of a cylinder must be a multiple of 4 from 8 to 24, got 28"),
        ({"cells": 24, "height": 1.0}, "must have at most 8000 panels.*take fewer"),
        ({"radius": 0.0}, "radius"),
        ({"inner_radius": 0.02}, "inner_radius"),
        ({"susceptibility": -2.0}, "susceptibility must be >= -1"),
    ):
        with pytest.raises(ls.InvalidInput, match=message):
            M.soft_cylinder(**{**good, **change})
    for thin in ({"height": 1e-4}, {"inner_radius": 0.00999}):
        with pytest.raises(ls.Unsupported, match="a fiftieth of the radius"):
            M.soft_cylinder(**{**good, **thin})
