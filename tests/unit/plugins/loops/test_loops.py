"""How loops are run and compiled, and what is said when a law cannot be."""

from __future__ import annotations

import inspect

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadLaw
from rbs_plugins import Criterion, PairwiseForce, loops
from rbs_plugins.fields import displacement
from rbs_plugins.loops.nodes import add_scaled


def test_little_work_runs_on_one_thread():
    seen = []
    before = numba.get_num_threads()
    if before < 2:
        pytest.skip("one core")
    loops.run(lambda: seen.append(numba.get_num_threads()), loops.SERIAL_BELOW - 1)
    loops.run(lambda: seen.append(numba.get_num_threads()), loops.SERIAL_BELOW)
    assert seen == [1, before]
    assert numba.get_num_threads() == before


def test_threads_are_given_back_after_an_error():
    before = numba.get_num_threads()
    with pytest.raises(ZeroDivisionError):
        loops.run(lambda: 1 // 0, 1)
    assert numba.get_num_threads() == before


def test_run_passes_arguments_and_result():
    assert loops.run(lambda a, b: a - b, 10, 5, 3) == 2
    assert loops.run(lambda a, b: a - b, 10**9, 5, 3) == 2


def test_flat_is_the_same_memory():
    array = np.zeros((3, 2))
    loops.flat(array)[3] = 7.0
    assert array[1, 1] == 7.0


def test_loop_without_compiler_is_left_alone():
    loops.compile_loop(lambda: None, (), [])


def test_compiling_does_not_run():
    array = np.ones(4)
    loops.compile_loop(add_scaled, (array, array, 1.0), [])
    assert array.tolist() == [1.0] * 4


# -- laws that cannot be compiled ----------------------------------------------------------------------------------


def calls_nobody(stretch, c):
    force = c * stretch
    return force + nobody(stretch)  # noqa: F821


def makes_text(stretch, c):
    if stretch > 0:
        return c * stretch
    return "slack"


def adds_text(stretch, c):
    two = "2"
    force = c * stretch
    return force + two


def helper_with_text(x):
    return x + "no number"


def calls_a_bad_helper(stretch, c):
    return helper_with_text(c * stretch)


def good(stretch, c):
    return c * stretch


def bad_criterion(stretch, s0):
    return stretch > s0.limit


@pytest.fixture
def pair():
    part = rbs.Part("pair", rbs.Everywhere(), dimension=1)
    part.place([[0.0], [1.0]], [1.0, 1.0], spacing=1.0).connect(1.5)
    part[displacement] = 0.0
    return part


def line_of(function, text):
    lines, first = inspect.getsourcelines(function)
    return first + next(i for i, line in enumerate(lines) if text in line)


@pytest.mark.parametrize(
    ("law", "text", "reason"),
    [
        (calls_nobody, None, "name 'nobody' is not defined"),  # numba does not say where: the line of the def
        (makes_text, None, "Can't unify return type"),
        (adds_text, "+ two", "No implementation of function"),
    ],
)
def test_message_names_the_file_and_line_of_the_user(pair, law, text, reason):
    force = PairwiseForce(pair, law, c=1.0)
    with pytest.raises(BadLaw) as caught:
        rbs.Analysis([force]).prepare()
    message = str(caught.value)
    assert message.startswith(f"law '{law.__name__}' cannot be compiled: {__file__}, line ")
    assert reason in message
    line = int(message.split(", line ")[1].split(":")[0])
    lines, first = inspect.getsourcelines(law)
    assert first <= line < first + len(lines)
    if text is not None:
        assert text in lines[line - first]
    assert "laws may use numbers" in message


def test_message_about_a_helper_names_its_line(pair):
    with pytest.raises(BadLaw) as caught:
        rbs.Analysis([PairwiseForce(pair, calls_a_bad_helper, c=1.0)]).prepare()
    message = str(caught.value)
    assert "law 'calls_a_bad_helper' cannot be compiled" in message
    assert f"{__file__}, line {line_of(helper_with_text, 'no number')}:" in message


def test_message_about_a_criterion_names_the_criterion(pair):
    force = PairwiseForce(pair, good, Criterion(bad_criterion, s0=0.1), c=1.0)
    with pytest.raises(BadLaw) as caught:
        rbs.Analysis([force]).prepare()
    assert "law 'bad_criterion' cannot be compiled" in str(caught.value)
    assert f"line {line_of(bad_criterion, 's0.limit')}:" in str(caught.value)
