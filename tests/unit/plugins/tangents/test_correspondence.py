"""The tangent of correspondence models against central differences of their forces."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondSoftening, Correspondence, SillingControl, WanControl
from rbs_plugins.constitutive import stress
from rbs_plugins.fields import displacement, force_density, intact, largest_stretch, volume

H, E, NU = 1e-3, 1e9, 0.3
SHAPES = {1: (9,), 2: (6, 5), 3: (4, 4, 3)}
SVK = stress.saint_venant_kirchhoff
PLASTIC = {"yield_stress": 2e6, "hardening": 1e8}


class Body:
    """A small body of one material, with the force as a function of the displacement."""

    def __init__(self, d, law=SVK, broken=False, storage="list", **arguments):
        across = {1: {"area": 2e-6}, 2: {"thickness": 2e-3}, 3: {}}[d]
        self.part = rbs.Part("body", rbs.Box(size=[n * H for n in SHAPES[d]])).discretize(H, **across)
        self.part.connect(2.015 * H, storage=storage)
        self.part[volume][...] *= 1 + 0.3 * np.sin(np.arange(len(self.part)))
        self.part[displacement] = np.zeros_like(self.part.positions)
        if broken:  # all bonds of a corner but those in one line with it, and a row in the middle
            x, y = self.part.positions.min(axis=0)
            self.part.bonds.cut(rbs.Segment((x - 0.5 * H, y + 0.5 * H), (x + 0.9 * H, y + 0.5 * H)))
            self.part.bonds.cut(rbs.Segment((-H, 0.2 * H), (0.2 * H, 0.2 * H)))
        more = PLASTIC if law is stress.j2_plasticity else {}
        arguments = {"influence": "gaussian", "E": E, "nu": NU, **more, **arguments}
        self.force = Correspondence(self.part, law, **arguments)
        analysis = rbs.Analysis([self.force])
        analysis.prepare()
        self.clock = analysis.clock
        self.force.begin(self.clock)

    def pull(self, u):
        """V f of a displacement."""
        self.part[displacement] = u.reshape(self.part.positions.shape)
        self.part[force_density][...] = 0.0
        self.force.apply(self.clock)
        return (self.part[force_density] * self.part[volume][:, None]).ravel()

    def bent(self, rng, size=0.02):
        """A displacement without any symmetry."""
        points = self.part.positions
        gradient = size * rng.standard_normal((points.shape[1],) * 2)
        return (points @ gradient.T + 0.1 * size * H * rng.standard_normal(points.shape)).ravel()

    def differences(self, u, step=1e-6 * H):
        """−d(V f)/du, column by column, of trials about u."""
        self.force.hold = True
        columns = []
        for k in range(len(u)):
            ahead, back = u.copy(), u.copy()
            ahead[k] += step
            back[k] -= step
            columns.append((self.pull(back) - self.pull(ahead)) / (2 * step))
        self.part[displacement] = u.reshape(self.part.positions.shape)
        return np.array(columns).T


def check(body, rng, size=0.02):
    """The matrix is the derivative, and product, diagonal and symmetry agree with it."""
    u = body.bent(rng, size)
    expected = body.differences(u)
    tangent = body.force.tangent()
    tangent.update()
    matrix = tangent.matrix()
    dense = matrix.toarray()
    scale = np.abs(dense).max()
    assert np.abs(dense - expected).max() < 1e-6 * np.abs(expected).max()
    v, out, diagonal = rng.standard_normal(len(u)), np.ones(len(u)), np.ones(len(u))
    tangent.multiply(v, out)
    tangent.diagonal(diagonal)
    np.testing.assert_allclose(out - 1, dense @ v, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(diagonal - 1, np.diag(dense), rtol=0, atol=1e-12 * scale)
    if tangent.symmetric:
        assert np.abs(dense - dense.T).max() < 1e-14 * scale
    return tangent, dense


def test_tangent_of_a_plate_with_broken_bonds(rng):
    body = Body(2, broken=True, plane="strain")
    tangent, bent = check(body, rng)
    assert tangent.symmetric
    assert list(body.force.singular_nodes) == [0]
    assert tangent.nbytes > 0
    before = tangent.matrix().indices
    body.part[displacement] = np.zeros_like(body.part.positions)
    tangent.update()
    rest = tangent.matrix()
    assert rest.indices is before
    assert np.abs(rest.toarray() - bent).max() > 0.01 * np.abs(bent).max()
    x, y = body.part.positions.T
    scale = np.abs(rest).max()
    for mode in ((x * 0 + H, x * 0), (x * 0, x * 0 + H), (-y, x)):
        np.testing.assert_allclose(rest @ np.stack(mode, axis=1).ravel(), 0, atol=1e-12 * scale * H)
    assert np.linalg.eigvalsh(rest.toarray()).min() > -1e-12 * scale


@pytest.mark.parametrize("release", ["at once", pytest.param("next step", marks=pytest.mark.verify)])
def test_bonds_that_soften(release, rng):
    """T_s changes with the present stretch, or with the largest of the steps before."""
    body = Body(2, plane="strain", fracture=BondSoftening(0.003, 0.03, release=release))
    body.pull(body.bent(rng))
    kept = body.part[largest_stretch].copy()
    tangent, dense = check(body, rng)
    np.testing.assert_array_equal(body.part[largest_stretch], kept)
    assert (body.part[intact] != 0).all()
    assert not tangent.symmetric
    assert np.abs(dense - dense.T).max() > 1e-3 * np.abs(dense).max()


CONTROLS = (None, SillingControl(), WanControl(), SillingControl(1e-8, by_family=True))
KINDS = ((1, None, False), (2, "stress", True), (2, "strain", False), (3, None, False))
EVERY = [(*kind, law, CONTROLS[n % 4])
         for n, (kind, law) in enumerate(itertools.product(KINDS, stress.LAWS))]  # fmt: skip


@pytest.mark.verify
@pytest.mark.parametrize(("d", "plane", "broken", "law", "control"), EVERY)
def test_every_law(d, plane, broken, law, control, rng):
    body = Body(d, law, broken, plane=plane, stabilization=control)
    body.pull(body.bent(rng))  # a plastic body has then yielded
    tangent, dense = check(body, rng)
    assert tangent.symmetric
    assert tangent.constant == (law is stress.linear_elastic)
    assert (dense != 0).any()


@pytest.mark.verify
def test_law_without_potential(rng):
    """Nothing is taken for symmetric that need not be."""

    def skewed(F, G):
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = F
        return ((G * (xx * xx - 1), G * xy, G * xz), (G * (yx + xx - 1), G * (yy - 1), G * yz),
                (G * zx, G * zy, G * (zz - 1)))  # fmt: skip

    tangent, dense = check(Body(2, skewed, plane="strain"), rng)
    assert not tangent.symmetric
    assert np.abs(dense - dense.T).max() > 1e-3 * np.abs(dense).max()


def test_failure_of_bonds_is_seen_at_the_next_update(rng):
    body = Body(2, plane="strain", fracture=BondSoftening(0.003, 0.03))
    u = body.bent(rng, 0.01) + 0.025 * body.part.positions.ravel()
    tangent = body.force.tangent()
    body.pull(u)
    assert 0 < body.part[intact].mean() < 1
    u *= 1.01  # not where bonds begin to load
    expected = body.differences(u)
    tangent.update()
    assert np.abs(tangent.matrix().toarray() - expected).max() < 1e-6 * np.abs(expected).max()


def test_what_cannot_have_one():
    for storage, match in (("lattice", "storage='list'"), ("list", "list of relations")):
        part = (
            rbs.Part("body", rbs.Box(size=[5 * H] * 2)).discretize(H, thickness=H).connect(2.015 * H, storage=storage)
        )
        with pytest.raises(rbs.BadInput, match=match):
            Correspondence(part, SVK, E=E, nu=NU).tangent()
