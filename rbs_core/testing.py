"""Contract conformance: does a relation do what it says? For any relation, without a word of physics.

Every check is a plain function that raises AssertionError (or the error of the kernel) with a sentence, and needs
nothing but the kernel; `check_contract` does them all. A plugin author's physics is checked by `rbs_plugins.testing`.
"""

from __future__ import annotations

import importlib
import inspect
import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from rbs_core.analysis import Analysis
from rbs_core.checkpoint import Checkpoint
from rbs_core.errors import BadInput
from rbs_core.fields import Field
from rbs_core.part import Host, Part
from rbs_core.plugins import Registry, use_registry
from rbs_core.relation import WORDS, Relation
from rbs_core.roles import Measure


@contextmanager
def isolated_registry(*plugins: Any) -> Iterator[Registry]:
    """For the length of a block, a registry that discovers nothing and holds only the given plugins.

    Args:
        *plugins: modules or objects with `@hookimpl` functions, or names of modules.
    """
    made = Registry(discover=False)
    for plugin in plugins:
        made.register(importlib.import_module(plugin) if isinstance(plugin, str) else plugin)
    before = use_registry(made)
    try:
        yield made
    finally:
        use_registry(before)


def make(relation_class: type[Relation], part: Part, **arguments: Any) -> Relation | None:
    """An instance from the `example` of a class.

    Args:
        relation_class: the class.
        part: discretized and connected.
        **arguments: instead of, or beside those of the example.

    Returns:
        The relation, or None if its example says that it is not made for such a part.
    """
    example: Any = relation_class.example
    assert example is not None, (
        f"{relation_class.__module__}.{relation_class.__name__} has no example, so nothing about it can be checked: "
        "add a class attribute such as example = {'E': 1e9} with the keyword arguments of a typical instance"
    )
    given = example(part) if callable(example) else example
    if given is None:
        return None
    assert isinstance(given, Mapping), f"the example of {relation_class.__name__} must be keyword arguments: {given!r}"
    first = next(iter(inspect.signature(relation_class).parameters))
    return relation_class(**{first: part, **given, **arguments})


def partners(relation: Relation) -> list[Relation]:
    """The relations among the arguments of a relation, and theirs, in the order in which they must run."""
    found: list[Relation] = []
    for feeder in relation.feeders:
        found += [*partners(feeder), feeder]
    for value in relation.parameters.values():
        for each in value if isinstance(value, list | tuple) else [value]:
            if isinstance(each, Relation) and not relation.owns:
                found += [*partners(each), each]
    return list(dict.fromkeys(found))


def furnish(relations: Sequence[Relation]) -> None:
    """Gives every field that is read and that nobody provides: scalars about 1, the initial value for the others.

    Scalars of nodes differ from node to node, so that a law that looks at one end of a bond only is found out.
    """
    changed = {key for relation in relations for key in relation.keys("writes", "updates", "adds", "offers")}
    for relation in relations:
        for part, field in relation.keys("reads"):
            if (part, field) not in changed and field not in part.store(field.at):
                part[field] = _typical(part, field)


def _typical(part: Host, field: Field) -> Any:
    """A value to work with, for a field whose meaning is unknown."""
    if field.shape != "scalar":
        return field.initial
    uneven = field.at == "node" and field.dtype.startswith("float")
    return 1.0 + 0.1 * np.sin(np.arange(len(part))) if uneven else 1


def check_contract(
    relation: Relation, scene: Sequence[Relation] | None = None, *, steps: int = 3, dt: float | None = None
) -> None:
    """Everything that can be said about one relation in one scene: description, words, honesty, arrays, state.

    Args:
        relation: the relation to check.
        scene: the relations of a step in order, with this one among them; the relations among its arguments and then
            itself if not given.
        steps: how many to run.
        dt: time step, s; half of the stable one if not given (1e-9 where nobody knows one).

    Fields that are read and that nobody provides are given (`furnish`). Files go to a folder that is removed.
    """
    relations = [*partners(relation), relation] if scene is None else list(scene)
    assert relation in relations, f"{relation!r} is not in the scene that is to show it"
    check_description(relation)
    check_words(relation)
    check_honesty(relation, relations, steps=steps, dt=dt)
    check_state(relation)


def check_description(relation: Relation) -> None:
    """It says what it is: a docstring of its own class, a repr that another process would print too."""
    name = type(relation).__name__
    assert type(relation).__doc__, f"{name} has no docstring: say what it does and what its arguments are"
    for text in (repr(relation), relation.label):
        assert name in text, f"{text!r} does not name the class {name}"
        assert " at 0x" not in text, f"{text!r} holds an address: give the argument a repr of its own"
    again = type(relation)(**relation._given_arguments)
    assert repr(again) == repr(relation), f"made again from its own arguments, {relation!r} is {again!r}"
    for word in WORDS:
        old, new = ([(host.name, field) for host, field in each.keys(word)] for each in (relation, again))
        assert new == old, f"{relation!r} made again has other {word}"


def check_words(relation: Relation) -> None:
    """The contract is data: tuples of fields, and no field under two words that exclude each other."""
    for word in WORDS:
        fields = getattr(relation, word)
        assert isinstance(fields, tuple), f"{relation.label}: {word} must be a tuple of fields, got {fields!r}"
        for field in fields:
            each = field[1] if isinstance(field, tuple) and len(field) == 2 else field
            assert isinstance(each, Field), f"{relation.label}: {word} holds {field!r}, which is no Field"
        assert len(set(fields)) == len(fields), f"{relation.label}: {word} names a field twice: {fields}"
    for one, other in (("writes", "updates"), ("writes", "adds"), ("updates", "adds"), ("writes", "offers")):
        both = set(relation.keys(one)) & set(relation.keys(other))
        assert not both, f"{relation.label} both {one} and {other} {sorted(field.name for _, field in both)}"


def check_honesty(
    relation: Relation, scene: Sequence[Relation], *, steps: int = 3, dt: float | None = None
) -> Analysis:
    """Runs the scene with debug=True, offers taken up, and looks at what the relation has left behind.

    Raises:
        DishonestRelation, UndeclaredField: if it does something else than its contract says.
    """
    relations = [*scene, *([_Reader(relation)] if relation.keys("offers") else [])]
    furnish(relations)
    analysis = Analysis(relations)
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        report = analysis.run(
            steps=steps, dt=_time_step(analysis) if dt is None else dt, debug=True, force_dt=True, progress=False
        )
        assert report.steps == steps
        for part, field in relation.keys("writes", "updates", "adds", "offers"):
            array = part[field]
            wanted = part.store(field.at).shape(field)
            assert array.shape == wanted, f"{relation.label} left '{field.name}' with shape {array.shape}, not {wanted}"
            assert array.dtype == np.dtype(field.dtype), f"{relation.label} left '{field.name}' as {array.dtype}"
        bound = relation.squared_frequency()
    if bound is not None:
        assert bound.shape == (len(relation.part),), f"{relation.label}: squared_frequency has shape {bound.shape}"
        assert np.isfinite(bound).all(), f"{relation.label}: squared_frequency is not finite"
        assert (bound >= 0).all(), f"{relation.label}: squared_frequency is negative"
    assert relation.items() == int(relation.items()) >= 0, f"{relation.label}: items() is {relation.items()}"
    return analysis


def check_state(relation: Relation) -> None:
    """What it keeps privately can be written to a checkpoint and taken back."""
    kept = relation.state()
    plain = {name: value for name, value in kept.items() if not isinstance(value, np.ndarray)}
    try:
        again = json.loads(json.dumps(plain))
    except TypeError as error:
        raise AssertionError(f"{relation.label}: state() holds what no checkpoint can ({error}): {plain!r}") from None
    relation.restore({**kept, **again})
    _check_equal(f"{relation.label}: restore(state())", relation.state(), kept)


def check_resume(build: Callable[[], Sequence[Relation]], *, steps: int = 3, dt: float | None = None) -> None:
    """A run that is stopped and resumed in new objects equals the uninterrupted one to the bit.

    Args:
        build: makes the scene anew: fresh parts, fresh relations.
        steps: half of the steps of the whole run.
        dt: as in `check_contract`.

    Compared are all fields that a relation changes, and what relations keep privately. A relation that keeps something
    from step to step and tells neither its contract nor `state` fails here.
    """
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        path = Path(folder) / "checkpoint.npz"
        whole = _scene(build())
        dt = _time_step(whole) if dt is None else dt
        whole.run(steps=2 * steps, dt=dt, force_dt=True, progress=False)
        first = _scene([*build(), Checkpoint(path)])
        first.run(steps=steps, dt=dt, force_dt=True, progress=False)
        second = _scene([*build(), Checkpoint(path)])
        report = second.run(steps=2 * steps, dt=dt, force_dt=True, progress=False, resume=path)
        assert report.steps == steps, f"the resumed run did {report.steps} steps instead of {steps}"
    resumed = {(part.name, field.name): part[field] for part, field in second.plan.changed}
    for part, field in whole.plan.changed:
        other = resumed[part.name, field.name]
        assert np.array_equal(part[field], other, equal_nan=field.dtype.startswith("f")), (
            f"'{field.name}' of part '{part.name}' of the resumed run differs from the uninterrupted one by up to "
            f"{np.max(np.abs(part[field] - other))}"
        )
    for old, new in zip(whole.unique, second.unique, strict=False):  # the second has a checkpoint more
        _check_equal(f"{old.label}: state() of the resumed run", new.state(), old.state())


class _Reader(Measure):
    """Looks at what a relation offers, so that it has to deliver."""

    example = None

    def __init__(self, relation: Relation) -> None:
        super().__init__(relation.part)
        self.reads = tuple(relation.keys("offers"))


def _scene(relations: Sequence[Relation]) -> Analysis:
    furnish(relations)
    return Analysis(relations)


def _time_step(analysis: Analysis) -> float:
    try:
        return 0.5 * analysis.stable_dt()
    except BadInput:
        return 1e-9


def _check_equal(what: str, new: Mapping[str, Any], old: Mapping[str, Any]) -> None:
    assert new.keys() == old.keys(), f"{what} has {sorted(new)} instead of {sorted(old)}"
    for name, value in old.items():
        same = np.array_equal(new[name], value) if isinstance(value, np.ndarray) else _plain(new[name]) == _plain(value)
        assert same, f"{what}: {name} is {new[name]!r} instead of {value!r}"


def _plain(value: Any) -> Any:
    return json.loads(json.dumps(value))
