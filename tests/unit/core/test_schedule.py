"""Relations that do the same on parts of their own are done together, and nothing else changes its place."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import Clock, every
from rbs_core.schedule import schedule
from tests.unit.core.toys import Toy, a, b, line

CLOCK = Clock(dt=0.1, step=1)


class Alike(Toy):
    """A toy that can be done with others of its kind; they write one entry into a common log."""

    def batch_key(self):
        return "alike", self.writes, self.reads

    def batch(self, relations):
        def together(clock):
            LOG.append([relation.part.name for relation in relations])

        return together


LOG: list[list[str]] = []


def bodies(count=3):
    return [line(name=f"line{number}") for number in range(count)]


def test_without_common_keys_the_list_is_kept():
    part = line()
    relations = [Toy(part, writes=(a,)), Toy(part, reads=(a,), writes=(b,))]
    calls = schedule(relations, {1: [(part, b)]})
    assert [call.relations for call in calls] == [[relations[0]], [relations[1]]]
    assert [call.clear for call in calls] == [[], [(part, b)]]
    assert [call.position for call in calls] == [0, 1]


def test_part_by_part_is_done_kind_by_kind():
    relations = []
    for part in bodies():
        relations += [Alike(part, writes=(a,)), Alike(part, reads=(a,), writes=(b,))]
    calls = schedule(relations, {1: [(relations[1].part, b)], 3: [(relations[3].part, b)]})
    assert [len(call.relations) for call in calls] == [3, 3]
    assert [call.relations[0].writes for call in calls] == [(a,), (b,)]
    assert len(calls[1].clear) == 2
    assert calls[0].label == "Alike, 3 parts"
    LOG.clear()
    for call in calls:
        assert call.due(CLOCK)
        call.apply(CLOCK)
    assert LOG == [["line0", "line1", "line2"]] * 2


def test_what_depends_on_each_other_stays_apart():
    part, other = bodies(2)
    relations = [Alike(part, writes=(a,)), Alike(part, writes=(a,)), Alike(other, writes=(a,))]
    calls = schedule(relations, {})
    assert [[relations.index(each) for each in call.relations] for call in calls] == [[0, 2], [1]]


class Staying(Toy):
    """Sees more of a scene than it can say, as an exporter does."""

    stays = True


def test_nothing_is_moved_across_what_stays():
    one, two = bodies(2)
    relations = [Alike(one, writes=(a,)), Staying(one, reads=(a,)), Alike(two, writes=(a,))]
    calls = schedule(relations, {})
    assert [call.relations for call in calls] == [[each] for each in relations]


def test_triggers_and_watches_keep_relations_alone():
    relations = [Alike(part, writes=(a,), when=every(2)) for part in bodies()]
    assert len(schedule(relations, {})) == 3
    relations = [Alike(part, writes=(a,)) for part in bodies()]
    assert len(schedule(relations, {}, batches=False)) == 3
    assert len(schedule(relations, {})) == 1


# -- sums that need no clearing ------------------------------------------------------------------------------------


class Starter(Toy):
    """Adds 1 to a, or sets it to 1 where it is the first."""

    def can_start(self, key):
        return True

    def apply(self, clock):
        self.log.append((clock.step, bool(self.starts)))
        self[a][...] = 1.0 + (0.0 if self.starts else self[a])


def adder(part):
    return Toy(part, lambda toy, clock: toy[a].__iadd__(1.0), adds=(a,))


def test_the_first_that_adds_sets_the_sum_if_it_can():
    part = line()
    first, second = Starter(part, adds=(a,)), Starter(part, adds=(a,))
    (one, two) = schedule([first, second], {0: [(part, a)]})
    assert (one.clear, two.clear) == ([], [])
    assert (first.starts, second.starts) == ({(part, a)}, frozenset())


def test_a_sum_is_cleared_for_who_cannot_start_it():
    part = line()
    relations = [adder(part), Starter(part, adds=(a,))]
    assert schedule(relations, {0: [(part, a)]})[0].clear == [(part, a)]
    assert not relations[1].starts
    paused = Starter(part, adds=(a,), when=every(2))
    assert schedule([paused], {0: [(part, a)]})[0].clear == [(part, a)]  # cleared also when it pauses
    twice = Starter(part, adds=(a,))
    assert schedule([twice, twice], {0: [(part, a)]})[0].clear == [(part, a)]  # in its second place it must add


def test_in_a_run_sums_are_right_and_afterwards_nobody_starts():
    part = line()
    part[a] = 7.0
    starter = Starter(part, adds=(a,))
    rbs.Analysis([starter, adder(part)]).run(steps=3, dt=1.0, progress=False)
    assert part[a].tolist() == [2.0] * 4
    assert starter.log[-2:] == [(3, True), "close"]
    assert not starter.starts


def test_debug_finds_who_adds_where_it_should_set():
    class Liar(Starter):
        def apply(self, clock):
            self[a] += 1.0

    part = line()
    part[a] = 0.0
    with pytest.raises(
        rbs.DishonestRelation, match=r"it says that it can start 'a' of part 'line' and left entry \[0\]"
    ):
        rbs.Analysis([Liar(part, adds=(a,))]).run(steps=1, dt=1.0, progress=False, debug=True)
