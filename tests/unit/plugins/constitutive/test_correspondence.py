"""Correspondence: exact for uniform deformations, zero-energy modes, plasticity, failure, and what is refused."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from scipy.optimize import brentq

import rbs_core as rbs
from rbs_plugins import (
    BondSoftening,
    Correspondence,
    CriticalStretch,
    CriticalVolumetricStrain,
    KineticEnergy,
    MaximumPrincipalStress,
    SillingControl,
    StrainEnergy,
    VelocityVerlet,
    WanControl,
)
from rbs_plugins import testing as suite
from rbs_plugins.constitutive import stress
from rbs_plugins.fields import (
    deformation_gradient,
    density,
    displacement,
    equivalent_plastic_strain,
    force_density,
    intact,
    kinetic_energy,
    plastic_strain,
    strain_energy,
    strain_energy_density,
    velocity,
)
from rbs_plugins.fields import stress as collapsed_stress

H, E, NU = 1e-3, 10e9, 0.3
SHAPES = {1: (30,), 2: (16, 15), 3: (9, 8, 8)}


class Gradients(rbs.Measure):
    """Wants deformation gradients and stresses."""

    reads = (deformation_gradient, collapsed_stress)


def body(d, storage="lattice"):
    across = {1: {"area": 2e-6}, 2: {"thickness": 2e-3}, 3: {}}[d]
    part = rbs.Part("body", rbs.Box(size=[n * H for n in SHAPES[d]])).discretize(H, **across)
    part.connect(3.015 * H, storage=storage)
    part[density] = 1000.0
    part[displacement] = 0.0
    return part


def apply(part, *relations):
    """One evaluation of everything at the present displacement."""
    analysis = rbs.Analysis(relations)
    analysis.prepare()
    part[force_density][...] = 0.0
    for relation in relations:
        relation.begin(analysis.clock)
        relation.apply(analysis.clock)
    return relations[0]


def deform(part, F):
    part[displacement] = part.positions @ (np.asarray(F) - np.eye(part.dimension)).T


def classical(law, F, case, moduli):
    """F, P and W of the solid, with the stretch across found by bisection."""
    d = len(F)

    def at(t):
        whole = np.diag([1.0, t if d < 2 else 1.0, t if d < 3 else 1.0])
        whole[:d, :d] = F
        nested = tuple(map(tuple, whole.tolist()))
        energy = stress.LAWS[law].potential(nested, moduli.lame, moduli.G)
        return np.array(law(nested, moduli.lame, moduli.G)), energy

    free = case in ("1-D", "stress")
    return at(brentq(lambda t: at(t)[0][2, 2], 0.7, 1.3, xtol=1e-15) if free else 1.0)


CASES = [
    (1, None, "list", stress.saint_venant_kirchhoff),
    (2, "stress", "lattice", stress.neo_hookean),
    (2, "stress", "list", stress.saint_venant_kirchhoff),
    (2, "strain", "lattice", stress.hencky),
    (3, None, "lattice", stress.hencky),
    (3, None, "list", stress.linear_elastic),
]


@pytest.mark.parametrize(("d", "plane", "storage", "law"), CASES)
def test_uniform_deformation_is_exact(d, plane, storage, law, rng):
    """F, P, energy and, far from the surface, the vanishing force: for whatever influence function and control."""
    part = body(d, storage)
    control = WanControl() if storage == "list" else SillingControl()
    force = Correspondence(part, law, E=E, nu=NU, plane=plane, influence="gaussian", stabilization=control)
    energy = StrainEnergy(part, force)
    inside = (np.abs(part.positions - part.positions.mean(axis=0)) < (np.array(SHAPES[d]) / 2 - 6.1) * H).all(axis=1)
    for _ in range(5):
        F = np.eye(d) + 0.05 * rng.standard_normal((d, d))
        deform(part, F)
        apply(part, force, energy, Gradients(part))
        P, W = classical(law, F, force.case, force.moduli)
        np.testing.assert_allclose(part[deformation_gradient], np.broadcast_to(F, (len(part), d, d)), atol=1e-13)
        np.testing.assert_allclose(part[strain_energy_density], W, rtol=1e-11)
        stresses = np.broadcast_to(P[:d, :d], (len(part), d, d))
        np.testing.assert_allclose(part[collapsed_stress], stresses, atol=1e-11 * np.abs(P).max())
        assert np.abs(part[force_density][inside]).max(initial=0.0) <= 1e-12 * np.abs(P).max() / H
        if d == 1:  # through a cut in the middle goes the classical stress
            left = part.positions[:, 0] < 0
            assert part[force_density][left, 0].sum() * H == pytest.approx(P[0, 0], rel=1e-11)


@pytest.mark.parametrize("control", [None, SillingControl(), WanControl()], ids=["none", "silling", "wan"])
@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_checkerboard_is_resisted_by_a_control_only(control, storage):
    part = body(2, storage)
    force = Correspondence(part, stress.saint_venant_kirchhoff, E=E, nu=NU, stabilization=control)
    cells = np.round(part.positions / H - 0.5).astype(int)
    u = np.zeros_like(part.positions)
    u[:, 0] = 1e-4 * H * (1 - 2 * (cells.sum(axis=1) % 2))
    part[displacement] = u
    apply(part, force)
    inside = (np.abs(part.positions) < (np.array(SHAPES[2]) / 2 - 6.1) * H).all(axis=1)
    assert inside.any()
    resisting = -(part[force_density] * u).sum(axis=1)[inside] / (u**2).sum(axis=1)[inside] * H**2 / E
    if control is None:
        assert np.abs(resisting).max() < 1e-12
    else:
        assert resisting.min() > 0.05


def test_bar_yields_as_the_closed_form_says():
    """Loading beyond yield, unloading: σ = σy + E h/(E + h) (ε − σy/E), α = (σ − σy)/h."""
    part = body(1)
    limit, h = 50e6, 2e9
    force = Correspondence(part, stress.j2_plasticity, E=E, nu=NU, yield_stress=limit, hardening=h)
    energy = StrainEnergy(part, force)
    half = part.positions[:, 0] < part.positions[:, 0].mean()
    highest = 0.0
    for strain in (0.002, 0.004, 0.006, 0.01, 0.02, 0.019, 0.0185):
        deform(part, [[1 + strain]])
        apply(part, force, energy)
        highest = max(highest, strain)
        top = limit + E * h / (E + h) * (highest - limit / E) if highest > limit / E else E * strain
        expected = top - E * (highest - strain) if highest > limit / E else top
        found = part[force_density][half, 0].sum() * H
        assert found == pytest.approx(expected, rel=1e-9)
        alpha = max(top - limit, 0.0) / h
        np.testing.assert_allclose(part[equivalent_plastic_strain], alpha, rtol=1e-9)
        np.testing.assert_allclose(part[plastic_strain][:, 0, 0], alpha, rtol=1e-9)
        stored = expected**2 / (2 * E) + h * alpha**2 / 2
        np.testing.assert_allclose(part[strain_energy_density], stored, rtol=1e-8)


def test_plastic_strains_are_carried_through_a_checkpoint():
    arguments = {"law": stress.j2_plasticity, "yield_stress": 1e4, "hardening": 1e8}
    suite.check_going_on(Correspondence, 2, "lattice", **arguments)


def test_energy_is_kept_in_motion(rng):
    """Kinetic, elastic and control energy together, over many periods; the step is the stable one."""
    part = body(2)
    part[velocity] = 5.0 * rng.standard_normal(part.positions.shape)
    force = Correspondence(part, stress.saint_venant_kirchhoff, E=E, nu=NU)
    analysis = rbs.Analysis([*VelocityVerlet(part).step([force]), KineticEnergy(part), StrainEnergy(part, force)])
    dt = 0.1 * analysis.stable_dt()
    analysis.run(steps=1, dt=dt, progress=False)
    first = part[kinetic_energy] + part[strain_energy]
    totals = []
    for steps in range(20, 401, 20):
        analysis.run(steps=steps, dt=dt, progress=False)
        totals.append(float(part[kinetic_energy] + part[strain_energy]))
    assert part[strain_energy] > 0.1 * first
    np.testing.assert_allclose(totals, first, rtol=2e-3)  # the error of the scheme, (ω dt)²/8


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_strain_and_stress_break_bonds_of_a_uniform_body(storage):
    for criterion, stretch in (
        (CriticalVolumetricStrain(0.01), 1.0099),
        (CriticalVolumetricStrain(0.01), 1.011),
        (MaximumPrincipalStress(1e8), 1.0075),
        (MaximumPrincipalStress(1e8), 1.0085),
    ):
        part = body(2, storage)
        force = Correspondence(part, stress.hencky, criterion, E=E, nu=NU, plane="strain")
        deform(part, np.diag([stretch, 1.0]))
        apply(part, force)
        nu_stiff = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))  # plane strain: σ1 = D ln λ / λ of a Hencky solid
        if isinstance(criterion, MaximumPrincipalStress):
            breaks = nu_stiff * np.log(stretch) / stretch > 1e8
        else:
            breaks = (stretch**2 - 1) / 2 > 0.01
        assert (part[intact] == (0 if breaks else 1)).all()
        assert np.isfinite(part[force_density]).all()


def test_nodes_that_lose_their_gradient_are_reported_and_finite(caplog):
    part = body(2)
    force = Correspondence(part, stress.neo_hookean, CriticalStretch(0.02), E=E, nu=NU, plane="strain")
    corner = int(np.argmin(part.positions.sum(axis=1)))
    u = np.zeros_like(part.positions)
    u[corner] = -3 * H
    part[displacement] = u
    with caplog.at_level(logging.WARNING, logger="rbs"):
        apply(part, force)
    assert force.singular_nodes.tolist() == [corner]
    assert "no deformation gradient any more" in caplog.text
    assert np.isfinite(part[force_density]).all()
    np.testing.assert_array_equal(part[force_density][corner], 0.0)


def test_softened_bonds_carry_what_the_formula_says():
    """A uniformly stretched bar: all bonds have the same stretch, also after unloading."""
    part = body(1, None)
    low, high = 0.01, 0.03
    force = Correspondence(part, stress.linear_elastic, BondSoftening(low, high), E=E)
    half = part.positions[:, 0] < part.positions[:, 0].mean()
    highest = 0.0
    for strain in (0.005, 0.015, 0.025, 0.01):
        deform(part, [[1 + strain]])
        apply(part, force)
        highest = max(highest, strain)
        share = 0.5 * (1 - np.tanh(3 * (low + high - 2 * highest) / (low - high))) if highest > low else 1.0
        assert part[force_density][half, 0].sum() * H == pytest.approx(share * E * strain, rel=1e-9)
    assert part.bonds.storage == "list"
    deform(part, [[1.031]])
    apply(part, force)
    assert not part[intact].any()


def test_a_law_of_ones_own_with_a_field_of_the_node():
    def spring(F, stiffness, density):
        pull = stiffness * density * (F[0][0] - 1.0)
        return ((pull, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))

    part = body(1)
    force = Correspondence(part, spring, E=E, stiffness=2e6, stabilization=None)
    deform(part, [[1.01]])
    apply(part, force)
    half = part.positions[:, 0] < part.positions[:, 0].mean()
    assert part[force_density][half, 0].sum() * H == pytest.approx(2e7, rel=1e-9)
    with pytest.raises(rbs.BadInput, match="energy of law 'spring' is not known: give potential="):
        apply(part, force, StrainEnergy(part, force))


def test_singular_shape_tensor_of_an_intact_node_is_refused():
    flat = rbs.Part("wire", rbs.Everywhere(), dimension=2)
    flat.place([[k * H, 0.0] for k in range(6)], H**3, spacing=H, thickness=H).connect(3.015 * H)
    flat[displacement] = 0.0
    force = Correspondence(flat, stress.linear_elastic, E=E, nu=NU)
    with pytest.raises(rbs.BadInput, match=r"shape tensor of 6 nodes is singular, first of node 0 .* larger horizon"):
        rbs.Analysis([force]).prepare()


def test_refusals():
    part = body(2)
    law = stress.linear_elastic
    for words, arguments in {
        "exactly two of E, nu, K and G, got E": {"E": E},
        "Poisson's ratio of 0.7": {"E": E, "nu": 0.7},
        "nobody asks for speed": {"E": E, "nu": NU, "speed": 1.0},
        "must be SillingControl": {"E": E, "nu": NU, "stabilization": "strong"},
        "must be a criterion": {"E": E, "nu": NU, "fracture": 0.1},
        "must be 'stress' or 'strain'": {"E": E, "nu": NU, "plane": "air"},
    }.items():
        with pytest.raises(rbs.BadInput, match=words):
            Correspondence(part, law, **arguments)
    with pytest.raises(rbs.BadLaw, match="asks for 'stretch', which nobody knows at a node"):
        Correspondence(part, lambda F, stretch: F, E=E, nu=NU)
    with pytest.raises(rbs.BadLaw, match="must be a function, or one of constant"):
        Correspondence(part, law, E=E, nu=NU, influence="bell")
    with pytest.raises(rbs.BadInput, match="must be positive"):
        SillingControl(0.0)
    with pytest.raises(rbs.BadInput, match="0 < s_min < s0"):
        BondSoftening(0.02, 0.01)
    other = rbs.Part("other", rbs.Box(size=(4 * H, 4 * H), center=(12.5 * H, 0.0))).discretize(H, thickness=2e-3)
    joint = rbs.Connection(part, other, 6 * H)
    with pytest.raises(rbs.BadInput, match="a connection has only"):
        Correspondence(joint, law, E=E, nu=NU)
