"""How a run of the analysis ends: interrupted, in an error, or well."""

from __future__ import annotations

import os
import signal
import threading

import numpy as np
import pytest

from rbs_core import Analysis, Checkpoint, NotFinite, every, hookimpl
from rbs_plugins.fields import displacement
from tests.scenes import bar
from tests.unit.core.toys import Toy, a, b, line, plus

# -- interruption ---------------------------------------------------------------------------------------------------


def interrupt(step):
    def work(relation, clock):
        if clock.step == step:
            os.kill(os.getpid(), signal.SIGINT)

    return work


def test_ctrl_c_finishes_the_step_and_writes_the_checkpoint(tmp_path):
    part, before = line(), signal.getsignal(signal.SIGINT)
    first, behind = Toy(part, interrupt(3)), Toy(part, plus(a), updates=(a,))
    never = Checkpoint(tmp_path / "state.npz", when=every(1000))
    report = Analysis([first, behind, never]).run(steps=10, dt=0.1)
    assert (report.stopped, report.step, report.steps) == ("interrupted", 3, 3)
    assert behind.log == ["attach", "begin", 1, 2, 3, "close"]
    assert signal.getsignal(signal.SIGINT) is before
    again = line()
    analysis = Analysis([Toy(again, interrupt(3)), Toy(again, plus(a), updates=(a,))])
    assert analysis.run(steps=4, dt=0.1, resume=tmp_path / "state.npz").steps == 1
    assert again[a][0] == 4.0


def test_a_second_ctrl_c_breaks_off():
    def twice(relation, clock):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    analysis = Analysis([Toy(line(), twice)])
    with pytest.raises(KeyboardInterrupt):
        analysis.run(steps=10, dt=0.1)
    assert (analysis.report.stopped, analysis.report.step) == ("failed", 1)


def test_an_interrupted_run_goes_on():
    toy = Toy(line(), interrupt(2))
    analysis = Analysis([toy])
    assert analysis.run(steps=4, dt=0.1).stopped == "interrupted"
    assert analysis.run(steps=4, dt=0.1).stopped == "finished"
    assert toy.steps == [1, 2, 3, 4]


def test_a_run_in_another_thread_leaves_signals_alone():
    reports = []
    thread = threading.Thread(target=lambda: reports.append(Analysis([Toy(line())]).run(steps=3, dt=0.1)))
    thread.start()
    thread.join(20)
    assert reports[0].step == 3


# -- errors ---------------------------------------------------------------------------------------------------------


def test_an_exporter_refuses_what_is_not_finite():
    part = line()

    def spoil(relation, clock):
        if clock.step == 3:
            relation[a][2] = np.nan

    exporter = Toy(part, reads=(b, a), role="exporter")
    part[b] = 1.0
    with pytest.raises(NotFinite) as caught:
        Analysis([Toy(part, spoil, updates=(a,)), exporter]).run(steps=5, dt=0.5)
    assert str(caught.value).startswith(
        "step 3 (time 1.5 s), relation 1 (Toy 'line'): 'a' of node 2 at [2.5] in part 'line' is nan"
    )
    assert exporter.steps == [1, 2]  # the last file is good


def test_forces_that_are_not_finite_stop_the_run_where_they_appear():
    scene = bar(n=20)

    def spoil(relation, clock):
        relation[displacement][7] = np.inf if clock.step == 3 else relation[displacement][7]

    spoiler = Toy(scene.part, spoil, updates=(displacement,))
    force = scene.relations.index(scene.force)
    scene.relations.insert(force, spoiler)
    message = rf"^step 3 \(.*\), relation {force + 1} \(BondBased 'bar'\): 'displacement' of node 7 at \[0.375\]"
    with pytest.raises(NotFinite, match=message):
        scene.analysis().run(steps=5)


@pytest.mark.parametrize("place", ["begin", "apply", "started"])
def test_relations_are_closed_and_hooks_told_whatever_happens(empty_registry, place):
    told = []

    class Plugin:
        @hookimpl
        def rbs_analysis_started(self, analysis):
            told.append("started")
            if place == "started":
                raise RuntimeError("on purpose")

        @hookimpl
        def rbs_analysis_finished(self, analysis, report):
            told.append((report.stopped, report.step))

    class Failing(Toy):
        def begin(self, clock):
            if place == "begin":
                raise RuntimeError("on purpose")

        def apply(self, clock):
            if place == "apply":
                raise RuntimeError("on purpose")

    empty_registry.register(Plugin())
    part = line()
    other = Toy(part)
    with pytest.raises(RuntimeError, match="on purpose"):
        Analysis([other, Failing(part)]).run(steps=3, dt=0.1)
    assert other.log[-1] == "close"
    assert told == ["started", ("failed", 1 if place == "apply" else 0)]


def test_hooks_stand_around_the_run(empty_registry):
    told = []
    toy = Toy(line())

    class Plugin:
        @hookimpl
        def rbs_analysis_started(self, analysis):
            told.append((list(toy.log), analysis.clock.step))

        @hookimpl
        def rbs_analysis_finished(self, report):
            told.append((list(toy.log), report.step))

    empty_registry.register(Plugin())
    Analysis([toy]).run(steps=2, dt=0.1)
    assert told == [(["attach"], 0), (["attach", "begin", 1, 2, "close"], 2)]


def test_the_report_stays_with_the_analysis():
    part = line()
    analysis = Analysis([Toy(part, updates=(a,))])
    assert analysis.report is None
    report = analysis.run(steps=2, dt=0.1)
    assert analysis.report is report
    assert report.nbytes == 3 * 4 * 8  # positions, volumes and a
    assert report.rows[0].name == "Toy 'line'"
