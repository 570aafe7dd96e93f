"""The errors: one family, each also an error of Python's own kind."""

from __future__ import annotations

import inspect

import pytest

from rbs_core import errors

KINDS = {
    "BadInput": ValueError,
    "MissingField": LookupError,
    "UndeclaredField": LookupError,
    "DishonestRelation": RuntimeError,
    "FieldClash": ValueError,
    "BadLaw": ValueError,
    "BadCheckpoint": ValueError,
    "UnstableStep": ValueError,
    "NotConverged": ArithmeticError,
    "NotFinite": ArithmeticError,
}


def test_these_and_no_others():
    found = {name for name, value in vars(errors).items() if inspect.isclass(value)}
    assert found == {*KINDS, "RBSError"}


@pytest.mark.parametrize(("name", "kind"), KINDS.items())
def test_each_is_caught_by_either_name(name, kind):
    error = getattr(errors, name)
    for caught in (errors.RBSError, kind, error):
        with pytest.raises(caught, match="what, where, cure"):
            raise error("what, where, cure")
    assert error.__doc__.endswith(".")


def test_none_is_another_one():
    """`except BadInput` must not swallow an unstable step, although both are a ValueError."""
    for name in KINDS:
        assert getattr(errors, name).__bases__ == (errors.RBSError, KINDS[name])


@pytest.mark.parametrize(
    ("name", "known", "text"),
    [
        ("lft", ["right", "left"], "the nearest names are left"),
        ("xyz", ["right", "left"], "there are left, right"),
        ("xyz", [], "there are none"),
    ],
)
def test_misspelt_names_are_told_the_nearest(name, known, text):
    assert errors.nearest(name, known) == text
