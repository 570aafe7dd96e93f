"""The analysis: what it runs, in which order, how long and with which time step."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput, Checkpoint, UnstableStep, every
from rbs_plugins.fields import displacement, velocity
from tests.scenes import bar
from tests.unit.core.toys import Stiff, Toy, a, b, c, d, field, line, plus

e = field("e")

# -- the object -----------------------------------------------------------------------------------------------------


def test_one_analysis_is_the_current_one(analysis):
    assert Analysis.current() is analysis
    with Analysis() as inner:
        assert Analysis.current() is inner
        with Analysis() as innermost:
            assert Analysis.current() is innermost
        assert Analysis.current() is inner
    assert Analysis.current() is analysis


def test_an_error_inside_of_the_block_leaves_nothing_behind(analysis):
    with pytest.raises(ZeroDivisionError), Analysis():
        raise ZeroDivisionError
    assert Analysis.current() is analysis


def test_relations_are_relations(analysis):
    with pytest.raises(BadInput, match=r"relation 1 is <function .*, which is no Relation"):
        analysis.relations = [Toy(line()), plus]
    with pytest.raises(BadInput, match="relation 0 is None"):
        analysis.append(None)
    assert analysis.relations == []


def test_relations_may_be_appended_and_repeated(analysis):
    one, two = Toy(line()), Toy(line(name="two"))
    analysis.append(one)
    analysis.append(two, one)
    assert analysis.relations == [one, two, one]
    assert analysis.unique == [one, two]
    assert analysis.parts == [one.part, two.part]
    assert repr(analysis) == "<Analysis, 3 relations, step 0>\n  0 Toy(line)\n  1 Toy(two)\n  2 Toy(line)"


def test_parts_need_names_of_their_own():
    with pytest.raises(BadInput, match=r"2 parts \(or connections\) are called 'line'"):
        Analysis([Toy(line()), Toy(line())]).prepare()


def test_checkpoints_are_no_part_of_the_scene(tmp_path):
    """Two of them, beside a part that is called like theirs."""
    part = line(name="scene")
    analysis = Analysis([Toy(part), Checkpoint(tmp_path / "a.npz"), Checkpoint(tmp_path / "b.npz", when=every(2))])
    assert analysis.parts == [part]
    analysis.run(steps=2, dt=1.0)


# -- order ----------------------------------------------------------------------------------------------------------


def test_relations_run_in_the_order_of_the_list_when_their_triggers_say_so():
    part, calls = line(), []
    one, two, three = (
        Toy(part, lambda self, clock, name=name: calls.append((clock.step, name)), when=when)
        for name, when in (("one", rbs.always), ("two", every(2)), ("three", rbs.last))
    )
    report = Analysis([one, two, one, three]).run(steps=3, dt=0.5)
    assert calls == [
        (1, "one"), (1, "one"),
        (2, "one"), (2, "two"), (2, "one"),
        (3, "one"), (3, "one"), (3, "three"),
    ]  # fmt: skip
    assert [row.calls for row in report.rows] == [3, 1, 3, 1]
    assert (report.steps, report.step, report.time, report.stopped) == (3, 3, 1.5, "finished")


def test_the_life_of_a_relation():
    toy = Toy(line())
    Analysis([toy, toy]).run(steps=2, dt=1.0)
    assert toy.log == ["attach", "begin", 1, 1, 2, 2, "close"]


def test_arrays_are_there_when_a_relation_attaches():
    class Early(Toy):
        def attach(self):
            self.array = self[a]

    part = line()
    relation = Early(part, lambda self, clock: self.array.__iadd__(1.0), updates=(a,))
    Analysis([relation]).run(steps=3, dt=1.0)
    assert part[a].tolist() == [3.0] * 4


def test_a_run_in_two_pieces_is_the_same_run():
    """The second piece attaches again, goes on from where the first stopped, and counts its own steps."""
    part = line()
    analysis = Analysis([Toy(part, lambda self, clock: self[a].__iadd__(clock.time), updates=(a,))])
    analysis.run(steps=3, dt=0.1)
    report = analysis.run(steps=5, dt=0.1)
    assert (report.steps, report.step) == (2, 5)
    assert part[a][0] == sum(k * 0.1 for k in range(1, 6))


def test_a_bar_in_two_pieces_is_the_same_bar_to_the_bit():
    whole, pieces = bar(n=20), bar(n=20)
    whole.analysis().run(steps=40)
    analysis = pieces.analysis()
    analysis.run(steps=15)
    analysis.run(steps=40)
    assert np.array_equal(whole.part[displacement], pieces.part[displacement])
    assert np.array_equal(whole.part[velocity], pieces.part[velocity])
    assert whole.part[displacement].max() > 0.0


# -- the first forces -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("start", "expected"), [(rbs.always, 7.0), (every(5), 7.0), (rbs.once, 0.0)])
def test_sums_taken_over_from_the_step_before_are_made_for_the_initial_state(start, expected):
    """Velocity Verlet: the first half kick needs the forces of the initial displacement."""
    part, seen = line(), []
    part[b] = 7.0
    kick = Toy(part, lambda self, clock: seen.append(self[a][0]), reads=(a,))
    force = Toy(part, lambda self, clock: self[a].__iadd__(self[b]), reads=(b,), adds=(a,), when=start)
    Analysis([kick, force]).run(steps=1, dt=1.0)
    assert seen == [expected]


def test_what_the_first_sums_are_made_from_is_written_first():
    """A state-based force: the dilatation of the initial displacement, a sum over the weights, then the force."""
    part, seen = line(), []
    part[b] = 3.0
    kick = Toy(part, lambda self, clock: seen.append(self[a][0]), reads=(a,))
    weigh = Toy(part, plus(d, 2.0), adds=(d,))
    dilate = Toy(part, lambda self, clock: np.multiply(self[b], self[d], out=self[c]), reads=(b, d), writes=(c,))
    force = Toy(part, lambda self, clock: self[a].__iadd__(self[c]), reads=(c,), adds=(a,))
    unrelated = Toy(part, writes=(e,))
    Analysis([kick, unrelated, weigh, dilate, force]).run(steps=2, dt=1.0)
    assert seen == [6.0, 6.0]
    assert [relation.steps for relation in (dilate, unrelated)] == [[0, 1, 2], [1, 2]]


def test_sums_that_nobody_takes_over_are_not_made_before_the_first_step():
    part = line()
    force = Toy(part, plus(a), adds=(a,))
    Analysis([force, Toy(part, reads=(a,))]).run(steps=2, dt=1.0)
    assert force.steps == [1, 2]


# -- how long -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "last"),
    [
        ({"steps": 4}, 4),
        ({"until": 0.3}, 3),
        ({"until": 3 * 0.1}, 3),  # (3 * 0.1) / 0.1 is above 3 by rounding
        ({"until": 0.31}, 4),
        ({"steps": 2, "until": 0.5}, 2),
        ({"steps": 9, "until": 0.5}, 5),
        ({"steps": 0}, 0),
        ({"until": 0.0}, 0),
    ],
)
def test_steps_and_time(arguments, last):
    toy = Toy(line())
    report = Analysis([toy]).run(dt=0.1, **arguments)
    assert toy.steps == list(range(1, last + 1))
    assert report.step == last


def test_defaults_of_the_analysis_and_arguments_of_the_run():
    part = line()
    assert Analysis([Toy(part)], dt=0.1, steps=3).run().time == 3 * 0.1
    assert Analysis([Toy(part)], dt=0.1, until=0.2).run().step == 2
    assert Analysis([Toy(part)], dt=0.1, steps=3).run(until=0.5, dt=0.25).step == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"dt": 0.1}, "say how long to run: steps=... or until=..."),
        ({"dt": 0.1, "steps": -1}, "steps=-1 must be a whole number, not negative"),
        ({"dt": 0.1, "steps": 2.5}, "steps=2.5 must be a whole number"),
        ({"dt": 0.1, "until": -1.0}, "until=-1.0 must be a time in s"),
        ({"dt": 0.1, "until": math.nan}, "until=nan must be a time in s"),
        ({"steps": 1}, "no relation of this scene knows a stable time step .* give dt"),
        ({"steps": 1, "dt": 0.0}, "dt=0.0 must be positive and finite"),
        ({"steps": 1, "dt": math.inf}, "dt=inf must be positive and finite"),
    ],
)
def test_bad_arguments_run_nothing(arguments, message):
    toy = Toy(line())
    with pytest.raises(BadInput, match=message):
        Analysis([toy]).run(**arguments)
    assert toy.steps == []


# -- the time step --------------------------------------------------------------------------------------------------


def test_nobody_knows_a_stable_step():
    with pytest.raises(BadInput, match=r"no relation .* knows a stable time step \(is a density missing\?\): give dt"):
        Analysis([Toy(line())]).stable_dt()


def test_a_step_above_the_stable_one_is_refused_and_can_be_forced():
    stiff = Stiff(line(), squares=[0, 1, 4, 1])  # node 2: 2 / sqrt(4)
    with pytest.raises(UnstableStep) as caught:
        Analysis([stiff]).run(steps=1, dt=1.01)
    assert "dt=1.01 s is above the stable step 1 s, which node 2 of part 'line' at [2.5] sets" in str(caught.value)
    assert "Take dt=0.8" in str(caught.value)
    assert stiff.steps == []
    Analysis([stiff]).run(steps=1, dt=1.0)
    assert Analysis([stiff]).run(steps=1, dt=1.01, force_dt=True).time == 1.01


def test_the_step_is_chosen_if_nobody_gives_one():
    assert Analysis([Stiff(line(), squares=[0, 1, 4, 1])]).run(steps=2).time == 1.6


def test_the_step_stays_the_same_through_a_run():
    analysis = Analysis([Toy(line())], dt=0.1)
    analysis.run(steps=2)
    with pytest.raises(BadInput, match=r"has run 2 steps of dt=0.1: dt cannot change"):
        analysis.run(steps=4, dt=0.2)
