"""What a list of relations needs, clears, carries and refuses."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import FieldClash, MissingField, every, hookimpl, once
from rbs_core.contract import plan
from rbs_plugins import Damage
from rbs_plugins.fields import (
    breakable,
    damage,
    density,
    displacement,
    dissipation_density,
    external_work,
    force_density,
    velocity,
)
from tests.scenes import plate
from tests.unit.core.toys import Toy, a, b, c, d, field, line, plus, strength, total


def names(keys):
    return [each.name for _, each in keys]


# -- allocation -----------------------------------------------------------------------------------------------------


def test_the_scene_allocates_the_union_of_what_is_declared_and_nothing_else():
    part = line(horizon=1.0)
    part[a] = 1.0
    relations = [Toy(part, reads=(a,), writes=(b,)), Toy(part, reads=(b, a), adds=(c,), updates=(strength, total))]
    assert names(plan(relations).fields) == ["a", "b", "strength", "total", "c"]
    rbs.Analysis(relations).prepare()
    assert {each.name for each in part.fields} == {"reference_position", "volume", "a", "b", "c", "strength", "total"}


def test_parts_do_not_share():
    one, two = line(name="one"), line(name="two")
    made = plan([Toy(one, writes=(a,)), Toy(two, writes=(b,))])
    assert [(part.name, each.name) for part, each in made.fields] == [("one", "a"), ("two", "b")]


def test_the_plate_holds_its_fields_and_no_more():
    scene = plate(n=10)
    scene.analysis().prepare()
    expected = {displacement, velocity, density, force_density, rbs.intact, breakable, damage}
    assert set(scene.part.fields) == expected | {rbs.reference_position, rbs.volume}


def test_offers_are_taken_only_if_read():
    part = line()
    giver = Toy(part, offers=(a, b))
    alone = plan([giver])
    assert (alone.fields, alone.offered, alone.changed) == ([], set(), set())
    taken = plan([giver, Toy(part, reads=(b,))])
    assert names(taken.fields) == names(taken.offered) == names(taken.changed) == ["b"]


def test_an_offer_for_another_part_is_not_taken():
    one, two = line(name="one"), line(name="two")
    two[a] = 1.0
    assert not plan([Toy(one, offers=(a,)), Toy(two, reads=(a,))]).offered


# -- clearing -------------------------------------------------------------------------------------------------------


def test_a_sum_is_cleared_before_its_first_adder():
    part = line()
    part[a] = 0.0
    relations = [Toy(part, reads=(a,)), Toy(part, adds=(b,)), Toy(part, adds=(b, c)), Toy(part, reads=(b, c))]
    made = plan(relations)
    assert {place: names(keys) for place, keys in made.clear.items()} == {1: ["b"], 2: ["c"]}


@pytest.mark.parametrize(("when", "expected"), [(rbs.always, [3.0, 3.0, 3.0, 3.0]), (every(2), [2.0, 3.0, 2.0, 3.0])])
def test_clearing_does_not_wait_for_the_trigger_of_the_first_adder(when, expected):
    part, seen = line(), []
    first, second = Toy(part, plus(a, 1.0), adds=(a,), when=when), Toy(part, plus(a, 2.0), adds=(a,))
    look = Toy(part, lambda self, clock: seen.append(self[a][0]), reads=(a,))
    rbs.Analysis([first, second, look]).run(steps=4, dt=1.0)
    assert seen == expected


def test_a_sum_that_nobody_makes_in_a_step_is_zero():
    part, seen = line(), []
    look = Toy(part, lambda self, clock: seen.append(self[a][0]), reads=(a,))
    rbs.Analysis([Toy(part, plus(a), adds=(a,), when=every(2)), look]).run(steps=4, dt=1.0)
    assert seen == [0.0, 1.0, 0.0, 1.0]


# -- gaps -----------------------------------------------------------------------------------------------------------


def test_a_gap_names_relation_part_field_and_who_could_fill_it():
    part = line(name="bar")
    with pytest.raises(MissingField) as caught:
        plan([Toy(part, writes=(b,)), Toy(part, reads=(a,))], providers=lambda each: ["Zebra", "Ant"])
    assert str(caught.value) == (
        "relation 1 (Toy 'bar') reads 'a' of part 'bar', and nothing provides it: assign part[a] = ..., or add a "
        "relation that writes it (Ant, Zebra)"
    )


def test_a_gap_that_no_known_relation_could_fill():
    with pytest.raises(MissingField) as caught:
        plan([Toy(line(name="bar"), reads=(a,))])
    assert str(caught.value) == (
        "relation 0 (Toy 'bar') reads 'a' of part 'bar', and nothing provides it: assign part[a] = ... (no known "
        "relation writes it)"
    )


def test_a_gap_of_a_real_scene_names_real_relations():
    part = line(name="bar")
    part[density] = 1.0
    wanted = r"relation 0 \(Toy 'bar'\) reads 'force_density'.*BondBased, (\w+, )*PairwiseForce"
    with pytest.raises(MissingField, match=wanted):
        rbs.Analysis([Toy(part, reads=(force_density,), updates=(velocity,))]).prepare()


def test_a_gap_names_the_relation_of_a_registered_stranger(empty_registry):
    class Granite(rbs.Relation):
        writes = (a,)

    class Unrelated(rbs.Relation):
        reads = (a,)

    class Plugin:
        @hookimpl
        def rbs_relations(self):
            return [Granite, Unrelated]

    empty_registry.register(Plugin(), "granite")
    with pytest.raises(MissingField, match=r"add a relation that writes it \(Granite\)"):
        rbs.Analysis([Toy(line(), reads=(a,))]).prepare()


def test_nothing_is_allocated_or_run_if_there_is_a_gap():
    part = line()
    writer = Toy(part, writes=(b,))
    with pytest.raises(MissingField):
        rbs.Analysis([writer, Toy(part, reads=(a,))]).run(steps=1, dt=1.0)
    assert b not in part
    assert writer.log == []


@pytest.mark.parametrize("word", ["writes", "updates", "adds", "offers"])
@pytest.mark.parametrize("order", [1, -1])
def test_any_relation_of_the_part_can_fill_a_gap_from_before_or_behind(word, order):
    part = line()
    relations = [Toy(part, reads=(a,)), Toy(part, **{word: (a,)})][::order]
    assert names(plan(relations).fields) == ["a"]


def test_the_script_can_fill_a_gap_but_not_for_another_part():
    one, two = line(name="one"), line(name="two")
    one[a] = 1.0
    plan([Toy(one, reads=(a,))])
    with pytest.raises(MissingField, match="part 'two'"):
        plan([Toy(one, writes=(a,)), Toy(two, reads=(a,))])


def test_bond_fields_need_bonds():
    with pytest.raises(MissingField, match=r"part 'line' has no bonds: call part.connect\(horizon=...\) first"):
        plan([Toy(line(), reads=(strength,))])


def test_the_state_of_bonds_is_no_gap():
    """Nobody has cut a bond yet, so `intact` has no array: bonds hold unless somebody breaks them."""
    part = line(horizon=1.0)
    damaged = Damage(part)
    assert rbs.intact not in part
    assert (part, rbs.intact) in plan([damaged]).fields
    rbs.Analysis([damaged]).run(steps=1, dt=1.0)
    assert part[rbs.intact].tolist() == [1] * 6
    assert part[damage].tolist() == [0.0] * 4


# -- clashes --------------------------------------------------------------------------------------------------------


def test_two_fields_of_one_name():
    part = line()
    with pytest.raises(FieldClash, match=r"part 'line': .*unit='1'.* and .*unit='K'.* share a name and differ"):
        plan([Toy(part, writes=(a,)), Toy(part, updates=(field("a", unit="K"),))])
    plan([Toy(part, writes=(a,)), Toy(line(name="other"), updates=(field("a", unit="K"),))])  # apart they may


def test_a_field_that_clashes_with_the_one_of_the_script():
    part = line()
    part[a] = 1.0
    with pytest.raises(FieldClash, match="has the same name but means something else"):
        rbs.Analysis([Toy(part, updates=(field("a", unit="K"),))]).prepare()


@pytest.mark.parametrize(("word", "order"), [("writes", 1), ("updates", 1), ("updates", -1)])
def test_a_field_is_either_set_or_summed(word, order):
    part = line()
    relations = [Toy(part, adds=(a,)), Toy(part, **{word: (a,)})][::order]
    with pytest.raises(FieldClash, match=r"relation \d \(Toy 'line'\) sets 'a'.*adds to it: .*either set or summed"):
        plan(relations)


def test_a_field_that_is_set_may_be_summed_anew_behind():
    part = line()
    made = plan([Toy(part, writes=(a,)), Toy(part, reads=(a,)), Toy(part, adds=(a,))])
    assert made.clear == {2: [(part, a)]}


def test_nobody_looks_at_half_a_sum():
    part = line()
    adders = [Toy(part, adds=(a,)), Toy(part, adds=(a,))]
    look = Toy(part, reads=(a,))
    plan([look, *adders, look])
    with pytest.raises(FieldClash, match=r"relation 1 .* reads 'a' .* between relations 0 and 2, which both add to it"):
        plan([adders[0], look, adders[1]])


def test_a_force_listed_twice_with_a_reader_in_between_is_half_a_sum_too():
    """Two force evaluations in one step would add up, as the sum is cleared once."""
    part = line()
    force, kick = Toy(part, adds=(a,)), Toy(part, reads=(a,), updates=(b,))
    with pytest.raises(FieldClash, match="half of the sum"):
        plan([force, kick, force, kick])


def test_two_writers_and_nobody_in_between():
    part = line()
    with pytest.raises(FieldClash, match=r"relations 0 .* and 2 .* both write 'a' .* the first one works for nothing"):
        plan([Toy(part, writes=(a,)), Toy(part, writes=(b,)), Toy(part, writes=(a,))])


@pytest.mark.parametrize(
    "between",
    [
        lambda part: [Toy(part, reads=(a,))],
        lambda part: [Toy(part, updates=(a,))],
    ],
)
def test_two_writers_with_somebody_in_between(between):
    part = line()
    plan([Toy(part, writes=(a,)), *between(part), Toy(part, writes=(a,))])


def test_two_writers_that_take_turns_or_are_one():
    part = line()
    plan([Toy(part, writes=(a,), when=every(2)), Toy(part, writes=(a,), when=~every(2))])
    again = Toy(part, writes=(a,))
    plan([again, again])


# -- carried fields -------------------------------------------------------------------------------------------------


def does(**contract):
    """The contract of one relation."""
    return contract


CASES = {
    "read, never changed": ([does(reads=(d,))], ""),
    "updated": ([does(updates=(a,))], "a"),
    "written, then read": ([does(writes=(a,)), does(reads=(a,))], ""),
    "read, then written": ([does(reads=(a,)), does(writes=(a,))], "a"),
    "written, then updated": ([does(writes=(a,)), does(updates=(a,))], ""),
    "read and written by one": ([does(reads=(a,), writes=(a,))], "a"),
    "summed, then read": ([does(adds=(a,)), does(reads=(a,))], ""),
    "read, then summed": ([does(reads=(a,)), does(adds=(a,))], "a"),
    "summed now and then": ([does(adds=(a,), when=every(5)), does(reads=(a,))], ""),  # cleared in every step
    "written now and then": ([does(writes=(a,), when=every(5)), does(reads=(a,))], "a"),
    "written and read together": ([does(writes=(a,), when=every(5)), does(reads=(a,), when=every(5))], ""),
    "written by turns": ([does(writes=(a,), when=every(5)), does(reads=(a,), when=every(10))], "a"),
    "written once": ([does(writes=(a,), when=once), does(reads=(a,))], "a"),
    "written only": ([does(writes=(a,))], ""),
    "offered and read": ([does(offers=(a,)), does(reads=(a,))], "a"),
    "written, then offered": ([does(writes=(a,)), does(offers=(a,)), does(reads=(a,))], ""),
    "offered, then written": ([does(offers=(a,)), does(writes=(a,)), does(reads=(a,))], "a"),
    "offered, not read": ([does(offers=(a,))], ""),
    "two": ([does(updates=(b,)), does(reads=(a,)), does(writes=(a,), updates=(c,)), does(reads=(c,))], "b a c"),
}


@pytest.mark.parametrize(("contracts", "expected"), CASES.values(), ids=CASES)
def test_carried_is_what_is_looked_at_before_it_is_set(contracts, expected):
    part = line()
    part[d] = 1.0
    assert sorted(names(plan([Toy(part, **contract) for contract in contracts]).carried)) == sorted(expected.split())


def test_setting_a_field_of_one_part_does_not_set_it_in_another():
    one, two = line(name="one"), line(name="two")
    made = plan([Toy(one, writes=(a,)), Toy(two, reads=(a,)), Toy(two, writes=(a,))])
    assert made.carried == [(two, a)]


FOUR = {velocity, displacement, force_density, rbs.intact}


def test_the_plate_carries_four_fields():
    scene = plate(n=10)
    assert {each for _, each in plan(scene.relations).carried} == FOUR


def test_energies_carry_what_their_offers_accumulate_and_no_more(tmp_path):
    scene = plate(n=10, energies=tmp_path / "energies.csv")
    assert {each for _, each in plan(scene.relations).carried} == FOUR | {external_work, dissipation_density}


# -- what a person reads --------------------------------------------------------------------------------------------


def test_a_plan_reads_as_one_line_for_each_field():
    one, two = line(name="one"), line(name="two", horizon=1.0)
    two[d] = 1.0
    relations = [
        Toy(one, writes=(a,)),
        Toy(one, reads=(b,), updates=(total,)),
        Toy(one, adds=(b,)),
        Toy(two, reads=(d, strength)),
        Toy(two, offers=(strength, c)),
    ]
    assert str(plan(relations)).splitlines() == [
        "one: a (node scalar) changed",
        "one: b (node scalar) changed, cleared, carried",
        "one: total (part scalar) changed, carried",
        "two: d (node scalar) only read",
        "two: strength (bond scalar) changed, carried, offer taken",
    ]
    assert str(plan([])) == ""
