"""Relations that own relations: one contract for all of them, one life, and a time that is the share of the loads."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import Analysis, MissingField
from tests.unit.core.toys import Toy, a, b, c, line


class Solver(rbs.Statics):
    """Applies what it owns twice in a step."""

    def __init__(self, part, owns, *, when=rbs.always):
        super().__init__(part, when=when)
        self.owns = tuple(owns)
        self.times = []

    def apply(self, clock):
        self.times.append(clock.time)
        for part, field in self.keys("writes"):
            part.raw(field)[...] = 0
        for each in (*self.owns, *self.owns):
            each.apply(clock)


def test_the_contract_of_an_owner_is_that_of_all():
    part = line()
    first, second = Toy(part, adds=(a,)), Toy(part, reads=(a, b), updates=(c,))
    owner = Solver(part, [first, second])
    assert owner.keys("reads") == [(part, b)], "what one makes for the other nobody else need give"
    assert owner.keys("writes") == [(part, a)], "sums are cleared by the owner"
    assert owner.keys("adds") == []
    assert owner.keys("updates") == [(part, c)]
    assert owner.household == [first, second, owner]


def test_what_an_owned_relation_reads_must_be_there():
    part = line()
    with pytest.raises(MissingField, match=r"relation 0 \(Solver 'line'\) reads 'a' of part 'line'"):
        Analysis([Solver(part, [Toy(part, reads=(a,))])], dt=1.0, steps=1).prepare()


def test_owned_relations_live_with_their_owner():
    part = line()
    own = Toy(part, adds=(a,))
    analysis = Analysis([Solver(part, [own])], dt=1.0, steps=2)
    assert analysis.unique[0] is own
    analysis.run(progress=False)
    assert own.log == ["attach", "begin", 1, 1, 2, 2, "close"]
    assert a in part, "fields of owned relations are allocated"


def test_parts_of_owned_relations_belong_to_the_scene():
    one, other = line(), line(name="other")
    assert Analysis([Solver(one, [Toy(other, adds=(a,))])]).parts == [one, other]


def test_the_time_of_statics_is_the_share_of_the_loads_unless_dt_is_given():
    part = line()
    solver = Solver(part, [Toy(part, adds=(a,))])
    Analysis([solver], steps=4).run(progress=False)
    assert solver.times == [0.25, 0.5, 0.75, 1.0]
    solver = Solver(part, [Toy(part, adds=(a,))])
    Analysis([solver], steps=2, dt=3.0).run(progress=False)
    assert solver.times == [3.0, 6.0]
