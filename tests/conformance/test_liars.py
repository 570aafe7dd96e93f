"""The suite must be able to fail: an honest relation passes every check, and each lie is caught by the check for it."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import DishonestRelation, Field, UndeclaredField
from rbs_core.testing import check_contract, check_resume, isolated_registry, make, partners
from rbs_plugins import BondBased, Criterion, Drift, Kick, PairwiseForce, StrainEnergy, SymplecticEuler
from rbs_plugins import testing as suite
from rbs_plugins.fields import displacement, force_density, intact, reference_position, velocity, volume

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


for liar in (OneSided,):
    liar.example = {}

LIES = [
    (Strained, suite.check_rest, 1, "force at rest"),
    (Strained, suite.check_rest, 2, "force at rest"),
    (Growing, suite.check_momentum, 1, "total force"),
    (Growing, suite.check_momentum, 3, "total force"),
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
    with pytest.raises(AssertionError, match="claims order 2 and shows 0.99"):
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


# -- lies about contracts ------------------------------------------------------------------------------------------

heat = Field("heat", "node", "scalar", "J", "Q", "Made up for these tests.")


class Base(rbs.Measure):
    """Sets the heat."""

    example = {}
    reads = (volume,)
    writes = (heat,)

    def apply(self, clock):
        self[heat][...] = self[volume] * clock.step


class Bare(Base):
    pass


class Lists(Base):
    """Has a list for a contract."""

    writes = [heat]


class Doubled(Base):
    """Says one thing twice."""

    updates = (heat,)


class Partial(Base):
    """Leaves a gap."""

    def apply(self, clock):
        self[heat][1:] = 1.0


class Sneaky(Base):
    """Writes what it does not name."""

    def apply(self, clock):
        super().apply(clock)
        self.part[volume][0] *= 1.01


class Hidden(Base):
    """Fetches what it does not name."""

    def attach(self):
        self[velocity]


class Unnamed(Base):
    """Has an argument without a name."""

    def __init__(self, part, thing=None):
        super().__init__(part)


class Forgetful(Base):
    """Does not say what it keeps."""

    def __init__(self, part):
        super().__init__(part)
        self._sum = 0.0

    def apply(self, clock):
        self._sum += clock.step
        self[heat][...] = self._sum


class Unwritable(Forgetful):
    """Keeps what no checkpoint can hold."""

    def state(self):
        return {"sum": {self._sum}}


class Remembering(Forgetful):
    """Says what it keeps."""

    def state(self):
        return {"sum": self._sum}

    def restore(self, state):
        self._sum = state["sum"]


class Late(Remembering):
    """Takes back something else."""

    def restore(self, state):
        self._sum = state["sum"] + 1.0


@pytest.mark.parametrize(
    ("liar", "error", "words"),
    [
        (Bare, AssertionError, "no docstring"),
        (Lists, AssertionError, "tuple of fields"),
        (Doubled, AssertionError, "both writes and updates"),
        (Partial, DishonestRelation, "unset"),
        (Sneaky, DishonestRelation, "changed 'volume'"),
        (Hidden, UndeclaredField, "velocity"),
        (Unwritable, AssertionError, "no checkpoint can"),
        (Late, AssertionError, r"restore\(state\(\)\)"),
    ],
)
def test_lie_about_a_contract_is_caught(liar, error, words):
    relation = liar(suite.body(1))
    with pytest.raises(error, match=words):
        check_contract(relation)


def test_address_in_repr_is_caught():
    with pytest.raises(AssertionError, match="address"):
        check_contract(Unnamed(suite.body(1), object()))


def test_honest_contracts_pass():
    for relation_class in (Base, Remembering, Forgetful):
        check_contract(relation_class(suite.body(1)))


def test_private_memory_is_caught_by_resuming():
    check_resume(lambda: [Base(suite.body(1))])
    check_resume(lambda: [Remembering(suite.body(1))])
    with pytest.raises(AssertionError, match="'heat' of part 'specimen' of the resumed run differs"):
        check_resume(lambda: [Forgetful(suite.body(1))])


def test_a_contract_that_forgets_what_is_carried_is_caught_by_resuming():
    class Blind(Drift):
        """Says that it sets the displacement, and adds to it."""

        updates = ()
        writes = (displacement,)

    part = suite.body(1)
    part[velocity] = 1.0
    with pytest.raises(DishonestRelation, match="unset"):
        check_contract(Blind(part))


# -- what the suite is built from ----------------------------------------------------------------------------------


def test_isolated_registry_holds_only_what_it_is_given():
    before = rbs.registry()
    with isolated_registry() as empty:
        assert rbs.registry() is empty
        assert empty.relations() == {}
    with isolated_registry("rbs_plugins") as found:
        assert found.relations()["BondBased"] is BondBased
    assert rbs.registry() is before
    with pytest.raises(RuntimeError), isolated_registry():
        raise RuntimeError
    assert rbs.registry() is before


def test_make_takes_arguments_beside_the_example():
    part = suite.body(2)
    assert make(BondBased, part, partial_volume="linear").parameters == {"E": 1e9, "partial_volume": "linear"}
    energy = make(StrainEnergy, part)
    assert [type(each) for each in partners(energy)] == [BondBased]


def test_copy_of_a_body_has_the_same_bonds():
    part = suite.body(3)
    order = np.random.default_rng(0).permutation(len(part))
    copy = suite.again(part, order=order)
    i, j = suite.ends(part)
    k, m = suite.ends(copy)
    broken = {(a, b) for a, b, holds in zip(i, j, part.bonds.intact, strict=True) if not holds}
    assert broken
    assert broken == {(order[a], order[b]) for a, b, holds in zip(k, m, copy.bonds.intact, strict=True) if not holds}
    np.testing.assert_array_equal(copy[volume], part[volume][order])


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("cloud", suite.CLOUDS)
def test_body_has_what_the_checks_need(dimension, cloud):
    part = suite.body(dimension, cloud)
    broken = ~part.bonds.intact
    assert 0 < np.count_nonzero(broken) < len(broken) / 2
    i, j = suite.ends(part)
    assert {(a, b) for a, b in zip(i[broken], j[broken], strict=True)} == {
        (b, a) for a, b in zip(i[broken], j[broken], strict=True)
    }
    assert (np.ptp(part[volume]) > 0) == (cloud == "jittered")
    assert np.bincount(i[~broken], minlength=len(part)).min() >= 1
    turn = suite.rotation(dimension)
    np.testing.assert_allclose(turn @ turn.T, np.eye(dimension), atol=1e-15)
    assert np.linalg.det(turn) == pytest.approx(1.0, abs=1e-14)
