"""Relations that do the same on parts of their own are done together, and nothing else changes its place."""

from __future__ import annotations

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


def test_an_exporter_keeps_its_place():
    one, two = bodies(2)
    relations = [Alike(one, writes=(a,)), Toy(one, reads=(a,), role="exporter"), Alike(two, writes=(a,))]
    calls = schedule(relations, {})
    assert [call.relations for call in calls] == [[each] for each in relations]


def test_triggers_and_watches_keep_relations_alone():
    relations = [Alike(part, writes=(a,), when=every(2)) for part in bodies()]
    assert len(schedule(relations, {})) == 3
    relations = [Alike(part, writes=(a,)) for part in bodies()]
    assert len(schedule(relations, {}, batches=False)) == 3
    assert len(schedule(relations, {})) == 1
