"""The fixtures of all tests do what they say."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import plugins


def test_numpy_errors_are_raised_and_underflow_is_none():
    for wrong in (lambda: np.zeros(1) / 0.0, lambda: np.array([1e300]) * 1e300, lambda: np.log(np.zeros(1))):
        with pytest.raises(FloatingPointError):
            wrong()
    assert np.array([1e-300]) * 1e-300 == 0.0


def test_warnings_are_errors():
    with pytest.raises(UserWarning, match="on purpose"):
        __import__("warnings").warn("on purpose", stacklevel=1)


@pytest.mark.parametrize("_", range(2))
def test_each_test_has_an_analysis_of_its_own(analysis, _):
    assert rbs.Analysis.current() is analysis
    assert analysis.relations == []
    analysis.append(rbs.Relation(rbs.Part("p", rbs.Everywhere(), dimension=1)))


@pytest.mark.parametrize("_", range(2))
def test_random_numbers_are_the_same_in_every_test(rng, _):
    assert rng.integers(2**32) == np.random.default_rng(20140305).integers(2**32)


def test_an_empty_registry_stands_in_for_the_one_of_the_process(empty_registry):
    assert plugins.registry() is empty_registry
    assert empty_registry.relations() == {}


@pytest.mark.verify
def test_verify_is_asked_for(request):
    assert request.config.getoption("--verify")


@pytest.mark.bench
def test_bench_is_asked_for(request):
    assert request.config.getoption("--bench")
