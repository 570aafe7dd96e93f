"""Pressure: what turns with the body, and by how much it changes."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput
from rbs_plugins import BondBased, BoundaryDomain, Newton, Pressure
from rbs_plugins.fields import displacement, force_density, volume

SPACING = 0.25


def block(d=2):
    part = rbs.Part("block", rbs.Box([1.5, *[1.0] * (d - 1)])).discretize(SPACING)
    return part.connect(horizon=2.015 * SPACING)


def top(part):
    return part.positions[:, -1] > part.positions[:, -1].max() - 0.1


def applied(part, load):
    analysis = Analysis([load], dt=1.0, steps=1)
    analysis.prepare()
    load.begin(analysis.clock)
    part[force_density] = 0.0
    load.apply(rbs.Clock(1.0, 1, 1.0))
    return part[force_density] * part[volume][:, None]


def stretched(part, F):
    part[displacement] = part.positions @ (np.asarray(F) - np.eye(part.dimension)).T


@pytest.mark.parametrize("d", [2, 3])
def test_it_follows_nansons_formula(d):
    part = block(d)
    load = Pressure(part, top(part), 2e3, normal=np.eye(d)[-1])
    F = np.eye(d) + np.random.default_rng(3).uniform(-0.3, 0.3, (d, d))
    stretched(part, F)
    force = applied(part, load)
    area = 1.5 if d == 3 else 1.5 * (part.thickness or 1.0)
    normal = np.eye(d)[-1]
    wanted = -2e3 * area * np.linalg.det(F) * np.linalg.inv(F).T @ normal
    assert force.sum(axis=0) == pytest.approx(wanted, rel=1e-12)
    assert (force[~top(part)] == 0).all()


@pytest.mark.parametrize("d", [2, 3])
def test_its_tangent_is_its_derivative(d):
    part = block(d)
    load = Pressure(part, top(part), 2e3)
    rng = np.random.default_rng(4)
    stretched(part, np.eye(d) + rng.uniform(-0.2, 0.2, (d, d)))
    part[displacement] += rng.uniform(-0.02, 0.02, part.positions.shape)
    tangent, u = load.tangent(), part[displacement].copy()
    applied(part, load)
    tangent.update()
    v, h = rng.normal(size=u.shape), 1e-6
    forces = []
    for sign in (1, -1):
        part[displacement] = u + sign * h * v
        forces.append(applied(part, load).ravel())
    out = np.zeros(u.size)
    tangent.multiply(v.ravel(), out)
    assert out == pytest.approx(-(forces[0] - forces[1]) / (2 * h), rel=1e-6, abs=1e-6 * np.abs(out).max())
    assert tangent.matrix() @ v.ravel() == pytest.approx(out, rel=1e-12)


def test_a_bent_strip_finds_quadratic_equilibrium():
    part = rbs.Part("strip", rbs.Box([2.0, 0.4])).discretize(0.1).connect(horizon=0.2015)
    x = part.positions[:, 0]
    force = BondBased(part, 1e6)
    load = Pressure(part, part.positions[:, 1] > 0.1, lambda time: 1500.0 * time, normal=(0.0, 1.0))
    newton = Newton(part, force, [BoundaryDomain(part, x < -0.8, displacement=[0.0, 0.0]), load], tolerance=1e-11)
    Analysis([newton], steps=2).run(progress=False)
    r = [each for each in newton.history[-1].residuals if each > 1e-13]
    assert r[-1] < 100 * r[-2] ** 1.9, r
    assert np.abs(part[displacement]).max() > 0.3, "far from small displacements"


def test_the_normal_is_that_of_the_nearest_surface():
    part = block()
    part[displacement] = 0.0
    load = Pressure(part, top(part) & (np.abs(part.positions[:, 0]) < 0.5), 1.0)
    force = applied(part, load)
    assert np.abs(force[:, 0]).max() < 1e-12
    assert (force[load.nodes, 1] < 0).all()


def test_what_it_cannot_do_is_refused():
    part = block()
    with pytest.raises(BadInput, match="no node lies in"):
        Pressure(part, rbs.Box([0.1, 0.1], center=[9.0, 9.0]), 1.0)
    with pytest.raises(BadInput, match="has no direction: give normal="):
        Pressure(part, top(part), 1.0, normal=(0.0, 0.0))
    with pytest.raises(BadInput, match=r"area=-1 must be positive"):
        Pressure(part, top(part), 1.0, area=-1)
    loose = rbs.Part("loose", rbs.Everywhere(), dimension=2).place(part.positions, part[rbs.volume], thickness=1.0)
    with pytest.raises(BadInput, match="has no spacing that gives the area of a node: give area="):
        Pressure(loose.connect(horizon=2.015 * SPACING), [0], 1.0, normal=(0.0, 1.0))
    thin = rbs.Part("row", rbs.Box([2.0, 0.25])).discretize(SPACING).connect(horizon=2.015 * SPACING)
    with pytest.raises(BadInput, match="lies in a plane or line"):
        Pressure(thin, top(thin), 1.0)
