"""The contract suite must be able to fail: honest relations pass, and each lie about a contract is caught."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import DishonestRelation, Field, UndeclaredField
from rbs_core.testing import check_contract, check_resume
from rbs_plugins import Drift
from rbs_plugins import testing as suite
from rbs_plugins.fields import displacement, velocity, volume

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
