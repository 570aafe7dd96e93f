"""When are two functions, given to a relation, the same? The fingerprint in a checkpoint must know."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, Checkpoint
from rbs_core.checkpoint import fingerprint
from rbs_plugins import CSVExporter, KineticEnergy, VTKExporter
from rbs_plugins.fields import displacement, kinetic_energy
from tests.scenes import bar
from tests.unit.core.toys import Toy, a, b, c, held, line, plus, refused

SPEED = 20.0
TABLE = np.array([1.0, 2.0])


def helper(time):
    return 2.0 * time


def printed(**parameters) -> str:
    """What a checkpoint says about a relation with these parameters."""
    return fingerprint(rbs.Analysis([Toy(line(), updates=(a,), **parameters)]), 0.1)["relation 0"]


def scaled(factor):
    def law(stretch):
        return factor * stretch

    return law


PAIRS = {
    "constant": (lambda time: 2.0 * time, lambda time: 3.0 * time),
    "operation": (lambda time: 2.0 * time, lambda time: 2.0 + time),
    "name": (lambda time: math.sin(time), lambda time: math.cos(time)),
    "captured value": (scaled(1.0), scaled(2.0)),
    "captured function": (scaled(helper), scaled(scaled(1.0))),
    "default": (lambda time, k=1.0: k * time, lambda time, k=2.0: k * time),
    "keyword default": (lambda time, *, k=1.0: k * time, lambda time, *, k=2.0: k * time),
    "inner function": (lambda time: [t + 1.0 for t in time], lambda time: [t + 2.0 for t in time]),
    "number": (1.0, 2.0),
    "array": (np.zeros(3), np.ones(3)),
    "entry of a list": ([None, 1.0], [None, 2.0]),
    "entry of a dict": ({"x": scaled(1.0)}, {"x": scaled(2.0)}),
    "geometry": (rbs.Box(size=(1.0, 2.0)), rbs.Box(size=(1.0, 3.0))),
    "trigger": (rbs.every(2), rbs.every(3)),
    "jitted": (numba.njit(scaled(1.0)), numba.njit(scaled(2.0))),
}


@pytest.mark.parametrize(("one", "other"), PAIRS.values(), ids=PAIRS)
def test_what_computes_something_else_is_told_apart(one, other):
    assert printed(law=one) == printed(law=one)
    assert printed(law=one) != printed(law=other)


def test_a_global_number_belongs_to_the_function(monkeypatch):
    def law(time):
        return SPEED * time + TABLE[0]

    before = printed(law=law)
    monkeypatch.setitem(globals(), "SPEED", 30.0)
    changed = printed(law=law)
    assert before != changed
    monkeypatch.setitem(globals(), "TABLE", np.array([5.0, 2.0]))
    assert printed(law=law) != changed


def test_the_same_function_made_twice_is_the_same():
    assert printed(law=scaled(1.0)) == printed(law=scaled(1.0))
    assert printed(law=numba.njit(scaled(1.0))) == printed(law=numba.njit(scaled(1.0)))


def test_a_function_that_calls_itself():
    def factorial(n):
        return 1 if n < 2 else n * factorial(n - 1)

    assert printed(law=factorial) == printed(law=factorial)


def test_objects_without_a_text_of_their_own_have_no_address():
    assert "0x" not in printed(law=object())


SCRIPT = """
import rbs_core as rbs
from rbs_core.checkpoint import fingerprint
from rbs_plugins import BoundaryDomain
part = rbs.Part("bar", rbs.Box(size=1.0)).discretize(0.25)
names = {"x", "y", "z"}
def speed(time): return 2.0 if "x" in {"x", "y", "z", "w"} else len(names)
analysis = rbs.Analysis([BoundaryDomain(part, rbs.Everywhere(), velocity=speed)])
print(sorted(fingerprint(analysis, 0.1).items()))
"""


def test_the_fingerprint_is_the_same_in_every_process():
    """Sets of texts are stored in another order in every process."""
    runs = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        for seed in ("1", "2")
    ]
    assert runs[0].stdout == runs[1].stdout
    assert "BoundaryDomain 'bar'" in runs[0].stdout


# -- measures -------------------------------------------------------------------------------------------------------


def measured(part, value=1.0, **contract) -> Toy:
    return Toy(part, role="measure", value=value, **contract)


def test_a_measure_that_only_exporters_look_at_does_not_count():
    def scene(*more):
        part = line()
        part[b] = 1.0
        relations = [Toy(part, reads=(b,), updates=(a,)), *(make(part) for make in more)]
        return fingerprint(Analysis(relations), 0.1)

    def look(part):
        return Toy(part, role="exporter", reads=(c,))

    alone = scene()
    assert scene(lambda part: measured(part, writes=(c,))) == alone
    assert scene(lambda part: measured(part, writes=(c,)), look) == alone
    assert scene(lambda part: measured(part, reads=(a,))) == alone


@pytest.mark.parametrize("word", ["writes", "updates"])
def test_a_measure_that_moves_something_counts(word):
    """E.g. the dilatation that a force depends on, whatever the role of the relation that computes it."""

    def scene(value):
        part = line()
        return fingerprint(Analysis([measured(part, value, **{word: (b,)}), Toy(part, reads=(b,), updates=(a,))]), 0.1)

    assert scene(1.0) == scene(1.0)
    assert scene(1.0) != scene(2.0)
    assert scene(1.0)["number of relations"] == "2"


def test_a_field_of_another_part_is_another_field():
    one, two = line(name="one"), line(name="two")
    relations = [measured(one, writes=(b,)), Toy(two, reads=(b,)), Toy(two, writes=(b,))]
    assert fingerprint(Analysis(relations), 0.1)["number of relations"] == "2"


def test_what_is_looked_at_may_change_from_run_to_run(tmp_path):
    """A bar, saved half way, goes on with an energy, a table and frames that the first run did not have."""
    save = tmp_path / "save.npz"

    def scene(*more):
        made = bar(n=20)
        return made, made.analysis(*(make(made.part) for make in more), Checkpoint(save, when=rbs.every(10)))

    def energy(part):
        return KineticEnergy(part)

    def table(part):
        return CSVExporter(part, [kinetic_energy], tmp_path / "energy.csv")

    def frames(part):
        return VTKExporter(part, [displacement], tmp_path / "frames")

    whole, analysis = scene()
    analysis.run(steps=30)
    scene()[1].run(steps=10)
    _, analysis = scene(frames, energy, table)
    assert analysis.run(steps=20, resume=save).steps == 10
    less, analysis = scene()
    assert analysis.run(steps=30, resume=save).steps == 10
    assert held(less.part) == held(whole.part)
    lines = (tmp_path / "energy.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in lines] == ["step", *(str(step) for step in range(11, 21))]
    assert len(list(tmp_path.glob("frames_*.vtu"))) == 10


def test_exporters_of_one_part_are_told_apart_by_their_files(tmp_path):
    """A second table in front of the first one does not take over its rows."""
    save = tmp_path / "save.npz"

    def scene(*names):
        made = bar(n=20)
        tables = [CSVExporter(made.part, [kinetic_energy], tmp_path / name) for name in names]
        return made.analysis(KineticEnergy(made.part), *tables, Checkpoint(save))

    scene("old.csv").run(steps=3)
    scene("new.csv", "old.csv").run(steps=5, resume=save)
    steps = {name: (tmp_path / name).read_text().splitlines()[1:] for name in ("old.csv", "new.csv")}
    assert {name: len(rows) for name, rows in steps.items()} == {"old.csv": 5, "new.csv": 2}


def test_a_measure_of_what_must_have_been_summed_up_from_the_start_is_refused(tmp_path):
    """Its past is missing in the file: the measure itself does not count, but what it makes others carry does."""
    save = tmp_path / "save.npz"

    def scene(*more):
        part = line()
        giver = Toy(part, plus(a), updates=(a,), offers=(b,))
        return part, Analysis([giver, *(make(part) for make in more), Checkpoint(save)], dt=0.1)

    scene()[1].run(steps=2)
    part, analysis = scene(lambda part: measured(part, reads=(b,), writes=(c,)))
    refused(analysis, [part], save, r"differs in carried fields \['field/line/b'\]")
