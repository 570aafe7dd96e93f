"""Steps are done and timed the same way, whatever is told about them."""

from __future__ import annotations

import logging
import re

import numpy as np
import pytest

from rbs_core import Analysis, every
from rbs_core.report.levels import LEVELS, configure_logging, logging_of_a_command
from rbs_core.schedule import schedule
from rbs_core.steps import Steps
from rbs_core.trigger import Clock
from rbs_plugins.fields import displacement, force_density, velocity
from tests.scenes import bar, block
from tests.unit.core.toys import Toy, a, line, plus


def test_rows_count_calls_and_time():
    part = line()
    toys = [Toy(part, plus(a), updates=(a,)), Toy(part, when=every(2))]
    analysis = Analysis(toys)
    analysis.prepare()
    steps = Steps(schedule(toys, {}), Clock(dt=0.1))
    for _ in range(5):
        steps.do()
    assert [row.calls for row in steps.rows] == [5, 2]
    assert [row.nodes for row in steps.rows] == [4, 4]
    assert all(row.seconds > 0 for row in steps.rows)
    assert part[a][0] == 5.0


def test_debug_tells_every_step_with_the_time_of_every_call(caplog):
    caplog.set_level(logging.DEBUG, "rbs")
    part = line()
    Analysis([Toy(part), Toy(part, when=every(2))]).run(steps=3, dt=0.5, progress=False)
    lines = [record.getMessage() for record in caplog.records if record.getMessage().startswith("step ")]
    number = r"\d[\d.e-]* ms"
    assert len(lines) == 3
    for step, text in enumerate(lines, 1):
        second = rf", 1 Toy 'line' {number}" if step == 2 else ""
        expected = rf"step {step}, time {step / 2:g} s: {number} \(0 Toy 'line' {number}{second}\)"
        assert re.fullmatch(expected, text), text


@pytest.mark.parametrize("make", [bar, block])
def test_results_are_the_same_to_the_bit_at_every_level(make, tmp_path):
    results = []
    for level in LEVELS:
        with logging_of_a_command():
            configure_logging("off", tmp_path / "run.log", file_level=level)
            scene = make(n=8)
            scene.analysis().run(steps=12, progress=False)
        results.append([scene.part[field].tobytes() for field in (displacement, velocity, force_density)])
    assert all(result == results[0] for result in results)
    assert np.frombuffer(results[0][0]).any()
    text = (tmp_path / "run.log").read_text()
    assert text.count("debug    step ") == 12
    assert text.count("process  rbs: from step 0 to 12, dt ") == 3
    assert text.count("12 steps in ") == 2
