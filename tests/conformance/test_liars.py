"""The suite must be able to fail: an honest relation passes every check, and each lie is caught by the check for it."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, Criterion, Kick, PairwiseForce, SymplecticEuler
from rbs_plugins import testing as suite
from rbs_plugins.fields import displacement, force_density, intact, reference_position, volume

# -- an honest relation, in plain numpy: nothing of the compiled loops ---------------------------------------------


class Honest(rbs.Constitutive):
    """Springs along the bonds, f = c (|Y| − |ξ|) / |ξ|."""

    example = {}
    reads = (displacement, reference_position, volume, intact)
    adds = (force_density,)

    def attach(self):
        self._i, self._j = suite.ends(self.part)

    def pull(self, xi, y):
        """(m, d) force on the nodes of the bonds, N/m^6."""
        length, rest = np.linalg.norm(y, axis=1), np.linalg.norm(xi, axis=1)
        return (1e18 * (length / rest - 1) / length)[:, None] * y

    def apply(self, clock):
        X, u = self[reference_position], self[displacement]
        xi = X[self._j] - X[self._i]
        force = self.pull(xi, xi + u[self._j] - u[self._i])
        force = force * (self[volume][self._j] * self[intact])[:, None]
        np.add.at(self[force_density], self._i, force)


test_honest = suite.conformance([Honest])


# -- lies about physics --------------------------------------------------------------------------------------------


class Strained(Honest):
    """Pulls at rest."""

    def pull(self, xi, y):
        return super().pull(xi * (1 - 1e-12), y)


class Foundation(Honest):
    """Is tied to the ground."""

    def apply(self, clock):
        super().apply(clock)
        self[force_density][...] -= 1e18 * self[volume].sum() * self[displacement]


class Linearized(Honest):
    """Pulls along the reference bond: small rotations only."""

    def pull(self, xi, y):
        rest = np.linalg.norm(xi, axis=1)
        return (1e18 * ((y - xi) * xi).sum(axis=1) / rest**3)[:, None] * xi


class Handed(Honest):
    """Pushes a little to the left of the bond."""

    def pull(self, xi, y):
        straight = super().pull(xi, y)
        aside = np.zeros_like(straight)
        aside[:, 0], aside[:, 1] = -straight[:, 1], straight[:, 0]
        return straight + 1e-6 * aside


class Counting(Honest):
    """Is stiffer between nodes with even numbers."""

    def pull(self, xi, y):
        return super().pull(xi, y) * (1 + 1e-9 * ((self._i + self._j) % 2 == 0))[:, None]


class Threaded(Honest):
    """Depends on the number of threads."""

    def pull(self, xi, y):
        return super().pull(xi, y) * (1 + 1e-15 * numba.get_num_threads())


class Growing(Honest):
    """Is stiffer on the side with more numbers: action is not reaction."""

    def pull(self, xi, y):
        return super().pull(xi, y) * (1 + 1e-10 * (self._i > self._j))[:, None]


def twice(stretch, reference_length, c):
    return c * stretch * stretch * reference_length


class Wasteful(BondBased):
    """Has a potential twice as high."""

    potential = staticmethod(twice)


def nearly(stretch, reference_length, c):
    return 0.50002 * c * stretch * stretch * reference_length


class Careless(BondBased):
    """Has a potential that is off by 4e-5."""

    potential = staticmethod(nearly)


class Hasty(BondBased):
    """Claims a larger stable step than it has."""

    def squared_frequency(self):
        return 0.2 * super().squared_frequency()


def lopsided(stretch, s0, density_i, density_j):
    return (stretch > s0) & (density_i > density_j)


class OneSided(BondBased):
    """Breaks bonds from the heavier end only."""

    example = {}

    def __init__(self, part, **options):
        super().__init__(part, 1e9, Criterion(lopsided, s0=0.05), **options)


class Healing(BondBased):
    """Mends its bonds before every step."""

    def apply(self, clock):
        if self._fracture is not None:
            self[intact][...] = 1
        super().apply(clock)


class Weightless(PairwiseForce):
    """Has no example."""

    example = None


wear = rbs.Field("wear", "node", "scalar", "1", "w", "How much a node has suffered.")


def worn_here(stretch, c, wear_i):
    """Looks at one end of the bond only."""
    return c * stretch * (1.0 - 0.5 * wear_i)


class Lopsided(PairwiseForce):
    """Pulls its two nodes with different forces, where they are worn differently."""

    @staticmethod
    def example(part):
        part[wear] = np.linspace(0.0, 1.0, len(part))
        return {"law": worn_here, "c": 1e18}


LIES = [
    (Strained, suite.check_rest, 1, "force at rest"),
    (Strained, suite.check_rest, 2, "force at rest"),
    (Growing, suite.check_momentum, 1, "total force"),
    (Growing, suite.check_momentum, 3, "total force"),
    (Lopsided, suite.check_momentum, 2, "total force"),
    (Handed, suite.check_angular_momentum, 2, "total torque"),
    (Linearized, suite.check_angular_momentum, 3, "total torque"),
    (Foundation, suite.check_rigid_motion, 1, "force of a translation"),
    (Linearized, suite.check_rigid_motion, 2, "force of a rotation"),
    (Linearized, suite.check_objectivity, 3, "force of the turned body"),
    (Handed, suite.check_mirror, 2, "force of the mirror image"),
    (Counting, suite.check_permutation, 2, "force in another order"),
    (Threaded, suite.check_threads, 2, "the forces differ"),
    (Wasteful, suite.check_energy, 2, r"f V \+ dU/du"),
    (Careless, suite.check_energy, 1, r"f V \+ dU/du"),
    (Hasty, suite.check_stable_step, 2, "the bound is"),
    (OneSided, suite.check_breaking, 2, "broke from one end only"),
    (Healing, suite.check_breaking, 2, "healed at rest|with bonds that broke before|has healed"),
    (Weightless, suite.check_momentum, 2, "has no example"),
]


@pytest.mark.parametrize(("liar", "check", "dimension", "words"), LIES, ids=lambda x: getattr(x, "__name__", None))
def test_lie_about_physics_is_caught(liar, check, dimension, words):
    with pytest.raises(AssertionError, match=words):
        check(liar, dimension, "jittered")


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")
def test_threads_are_given_back():
    before = numba.get_num_threads()
    suite.check_threads(Honest, 1, "grid")
    assert numba.get_num_threads() == before


class TooProud(SymplecticEuler):
    order = 2


def test_wrong_order_is_caught():
    with pytest.raises(AssertionError, match=r"claims order 2 and shows 0\.99"):
        suite.check_order(TooProud)


def test_what_a_check_cannot_see_is_said():
    class Elastic(Honest):
        """Knows no energy and breaks no bonds."""

    for check in (suite.check_energy, suite.check_stable_step, suite.check_breaking):
        with pytest.raises(suite.NotApplicable):
            check(Elastic, 2, "grid")
    with pytest.raises(suite.NotApplicable, match="adds no force"):
        suite.check_rest(Kick, 2, "grid")


def test_example_may_refuse_a_part():
    class Flat(BondBased):
        """For plates."""

        @staticmethod
        def example(part):
            return {"E": 1e9} if part.dimension == 2 else None

    suite.check_rest(Flat, 2, "grid")
    for check in (suite.check_rest, suite.check_scene, suite.check_going_on):
        with pytest.raises(suite.NotApplicable, match="not made for 3-D"):
            check(Flat, 3, "grid")
