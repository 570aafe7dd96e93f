"""A relation remembers its arguments: what help shows, what a copy keeps, and what makes it the same one."""

from __future__ import annotations

import copy
import inspect

import pytest

import rbs_core as rbs
from rbs_core import Relation
from rbs_core.checkpoint import fingerprint
from rbs_plugins import BondBased, Criterion, CriticalStretch, Damage, Drift, PairwiseForce, VelocityVerlet
from rbs_plugins.fields import density, displacement, force_density
from tests.unit.core.toys import Toy, line

ALL = sorted(rbs.registry().relations().items())


def without_self(function):
    return list(inspect.signature(function).parameters.values())[1:]


@pytest.mark.parametrize(("name", "kind"), ALL, ids=[name for name, _ in ALL])
def test_a_class_shows_the_arguments_of_its_constructor(name, kind):
    """Not `(*args, **kwargs)`, which is what `__new__` takes: help and editors look here."""
    assert list(inspect.signature(kind).parameters.values()) == without_self(kind.__init__)


def test_constructors_that_are_inherited_or_overridden():
    class Inherits(BondBased):
        pass

    class Overrides(BondBased):
        def __init__(self, part, strength, **options):
            super().__init__(part, E=strength, **options)

    assert list(inspect.signature(Drift).parameters) == ["part", "when"]
    assert inspect.signature(Inherits) == inspect.signature(BondBased)
    assert list(inspect.signature(Overrides).parameters) == ["part", "strength", "options"]
    assert list(inspect.signature(rbs.Checkpoint).parameters) == ["path", "when"]


def test_missing_and_unknown_arguments_are_told_by_the_constructor():
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'law'"):
        PairwiseForce(line(horizon=1.0))
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'part'"):
        Damage()
    with pytest.raises(TypeError, match="colour"):
        Drift(line(), colour="red")


def test_a_copy_is_the_same_relation_in_another_object():
    part = line(horizon=1.0)
    steel = BondBased(part, E=2.0, fracture=CriticalStretch(0.1))
    twin = copy.copy(steel)
    assert twin is not steel
    assert twin.part is part
    assert repr(twin) == repr(steel) == "BondBased(line, E=2.0, fracture=CriticalStretch(0.1, mode='tension'))"
    assert twin.parameters == steel.parameters
    part[density] = 1.0
    part[displacement] = lambda X: 0.01 * X
    for force in (steel, twin):
        part[force_density] = 0.0
        rbs.Analysis([force]).run(steps=1, dt=1e-3)
        assert part[force_density][0, 0] == pytest.approx(steel.c * 0.01)


# -- identity -------------------------------------------------------------------------------------------------------


def test_a_relation_is_known_by_its_parameters():
    relation = Toy(line(), depth=3.0)
    assert relation.identity() == relation.parameters == {"depth": 3.0}


def linear(stretch, c):
    return c * stretch


def stiffening(stretch, c):
    return c * stretch * (1.0 + stretch * stretch)


def energy(stretch, reference_length, c):
    return 0.5 * c * stretch * stretch * reference_length


def half(stretch, reference_length, c):
    return 0.25 * c * stretch * stretch * reference_length


def late(stretch, s0):
    return stretch > 2.0 * s0


def granite(law=linear, potential=energy, function=None) -> type[Relation]:
    """A class of this name that fixes its functions: what a new version of a plugin may change."""

    class Granite(BondBased):
        def __init__(self, part, E, s_break):
            fracture = CriticalStretch(s_break) if function is None else Criterion(function, s0=s_break)
            super().__init__(part, E, fracture)

    Granite.law, Granite.potential = staticmethod(law), staticmethod(potential)
    return Granite


def printed(kind, **more) -> str:
    return fingerprint(rbs.Analysis([kind(line(horizon=1.0), E=2.0, s_break=0.1, **more)]), 0.1)["relation 0"]


def test_functions_that_a_class_fixes_count():
    assert printed(granite()) == printed(granite())
    assert printed(granite()) != printed(granite(law=stiffening))
    assert printed(granite()) != printed(granite(potential=half))
    assert printed(granite()) != printed(granite(function=late))


def test_a_checkpoint_of_the_same_class_with_another_law_is_refused(tmp_path):
    def scene(law):
        part = line(horizon=1.0)
        part[density] = 1.0
        stone = granite(law)(part, E=2.0, s_break=0.1)
        step = VelocityVerlet(part).step([stone])
        return rbs.Analysis([*step, rbs.Checkpoint(tmp_path / "state.npz")], dt=1e-3)

    scene(linear).run(steps=2)
    with pytest.raises(rbs.BadCheckpoint, match=r"differs in relation 2: Granite 'line'.*linear.*stiffening"):
        scene(stiffening).run(steps=4, resume=tmp_path / "state.npz")
    assert scene(linear).run(steps=4, resume=tmp_path / "state.npz").steps == 2
