"""How loops are run and compiled, and what is said when a law cannot be."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadLaw
from rbs_plugins import Criterion, PairwiseForce, loops
from rbs_plugins.fields import displacement
from rbs_plugins.loops import Loop, Text


def double(begin, end, thread, out, a, factor):
    """Out = factor a, and how many entries that were."""
    for i in range(begin, end):
        out[i] = factor * a[i]
    return end - begin


def loop_over(count: int, factor: float = 2.0) -> tuple[Loop, np.ndarray]:
    out = np.zeros(count)
    return Loop(Text.of(double), "double", {"out": out, "a": np.arange(float(count)), "factor": factor}, count), out


@pytest.mark.parametrize("count", [0, 1, 4096, 4097, 100_000])
def test_every_item_is_visited_once(count):
    loop, out = loop_over(count)
    assert not out.any()  # compiling does not run
    assert loop().sum() == count
    assert np.array_equal(out, 2.0 * np.arange(count))


def test_numbers_and_arrays_are_exchanged():
    loop, out = loop_over(5)
    other = np.full(5, 7.0)
    loop.set(factor=3.0, a=other, nobody=1.0)
    loop()
    assert out.tolist() == [21.0] * 5
    with pytest.raises(AssertionError):
        loop.set(a=np.ones(4))


def test_some_tasks_only():
    loop, out = loop_over(10_000)
    assert loop(loop.tasks[1:2]).tolist() == [4096]
    assert not out[:4096].any()
    assert out[4096:8192].all()
    assert not out[8192:].any()


def test_loops_of_one_kind_are_merged():
    loops = [loop_over(count, factor) for count, factor in ((10, 2.0), (5000, 3.0), (1, 4.0))]
    assert len({loop.kind for loop, _ in loops}) == 1
    merged = loops[0][0].merged([loop for loop, _ in loops[1:]])
    merged()
    for (_, out), factor in zip(loops, (2.0, 3.0, 4.0), strict=True):
        assert np.array_equal(out, factor * np.arange(len(out)))
    merged.set(factor=np.array([1.0, 2.0, 3.0]))
    merged()
    assert [out[-1] for _, out in loops] == [9.0, 9998.0, 0.0]


def test_single_and_whole_numbers():
    def three(begin, end, thread, out, real, whole):
        out[0] = real
        out[1] = whole // 2
        return 0

    out = np.zeros(2, np.float32)
    Loop(Text.of(three), "three", {"out": out, "real": np.float32(0.1), "whole": 7}, 1)()
    assert out.tolist() == [np.float32(0.1), 3.0]


def test_flat_is_the_same_memory():
    array = np.zeros((3, 2))
    loops.flat(array)[3] = 7.0
    assert array[1, 1] == 7.0


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


@pytest.fixture(params=["list", "lattice"])
def pair(request):
    part = rbs.Part("pair", rbs.Box(size=2.0)).discretize(1.0).connect(1.5, storage=request.param)
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
