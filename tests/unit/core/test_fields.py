"""Declarations of arrays, and the arrays of one place."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from rbs_core import BadInput, FieldClash, MissingField, intact, is_fictitious, reference_position, volume
from rbs_core.fields import KERNEL_FIELDS, FieldStore
from tests.unit.core.toys import field

heat = field("heat", unit="K")
flow = field("flow", shape="vector")
stress = field("stress", shape="tensor")


def store(count: int | None = 3, at: str = "node", dimension: int = 2) -> FieldStore:
    return FieldStore("part 'plate'", at, count, dimension)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "two words"}, "must be a Python identifier"),
        ({"at": "element"}, "at='element' must be one of node, bond, part"),
        ({"shape": "matrix"}, "shape='matrix' must be one of scalar, vector, tensor"),
        ({"doc": ""}, "say in one sentence"),
    ],
)
def test_a_bad_declaration_is_refused(change, message):
    with pytest.raises(BadInput, match=message):
        dataclasses.replace(heat, **change)


def test_a_declaration_is_a_value():
    assert heat == field("heat", unit="K")
    assert hash(heat) == hash(field("heat", unit="K"))
    assert heat != field("heat", unit="degC")
    with pytest.raises(dataclasses.FrozenInstanceError):
        heat.unit = "degC"
    assert repr(heat) == "Field('heat', at='node', shape='scalar', unit='K')"


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_the_shape_of_an_entry_follows_the_dimension(dimension):
    entries = [each.entry(dimension) for each in (heat, flow, stress)]
    assert entries == [(), (dimension,), (dimension, dimension)]
    assert store(5, dimension=dimension).shape(stress) == (5, dimension, dimension)
    assert store(None, "part", dimension).shape(field("g", "part", "vector")) == (dimension,)


def test_the_fields_of_the_kernel():
    assert (reference_position, volume, intact, is_fictitious) == KERNEL_FIELDS
    assert (intact.dtype, intact.initial) == ("uint8", 1)  # bonds hold until something breaks them


def test_allocation_gives_the_initial_value_once():
    held = store()
    array = held.allocate(field("share", initial=0.5))
    assert array.tolist() == [0.5, 0.5, 0.5]
    array[1] = 7.0
    assert held.allocate(field("share", initial=0.5)) is array
    assert held.allocate(flow).shape == (3, 2)
    assert held.nbytes == 3 * 8 + 6 * 8
    assert [each.name for each in held] == ["share", "flow"]


def test_a_name_means_one_thing():
    held = store()
    held.allocate(heat)
    with pytest.raises(FieldClash, match="has the same name but means something else"):
        held.allocate(field("heat", unit="degC"))
    with pytest.raises(FieldClash, match="lives at bonds, not at the nodes of part 'plate'"):
        held.allocate(field("pull", at="bond"))


def test_a_field_that_is_not_there_is_missed_with_the_cure():
    held = store()
    held.allocate(flow)
    with pytest.raises(MissingField, match=r"has no field 'heat': assign part\[heat\] = .*fields there now: flow"):
        held.get(heat)


@pytest.mark.parametrize(
    ("declared", "value", "expected"),
    [
        (heat, 2, [2.0, 2.0, 2.0]),
        (heat, np.array([1, 2, 3], np.int32), [1.0, 2.0, 3.0]),
        (heat, [True, False, True], [1.0, 0.0, 1.0]),
        (flow, (1.0, 2.0), [[1.0, 2.0]] * 3),
        (flow, 0.5, [[0.5, 0.5]] * 3),
        (flow, [[1, 2], [3, 4], [5, 6]], [[1, 2], [3, 4], [5, 6]]),
        (stress, np.eye(2), [np.eye(2).tolist()] * 3),
    ],
)
def test_values_are_set_by_number_by_entry_or_all(declared, value, expected):
    held = store()
    held.set(declared, value)
    assert held.get(declared).tolist() == expected
    assert held.get(declared).dtype == np.float64
    assert held.given == {declared}


def test_the_array_stays_the_same_and_the_given_one_is_copied():
    held, mine = store(), np.array([1.0, 2.0, 3.0])
    held.set(heat, mine)
    array = held.get(heat)
    held.set(heat, 4.0)
    assert held.get(heat) is array  # relations hold it
    assert mine.tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1.0, 2.0], r"'heat' needs shape \(3,\) \(or one entry\), got \(2,\)"),
        ([1.0, np.nan, 3.0], r"'heat' would be nan at node \[1\]: give finite numbers"),
        (np.inf, r"'heat' would be inf at node \[0\]"),
        ("steel", "does not hold real numbers"),
        (1j, "does not hold real numbers"),
        ([[1.0], [2.0, 3.0]], "is no array"),
    ],
)
def test_bad_values_are_refused_and_nothing_changes(value, message):
    held = store()
    held.set(heat, 1.0)
    with pytest.raises(BadInput, match=message):
        held.set(heat, value)
    assert held.get(heat).tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("value", [0.5, 300, -1, np.nan, [1, 0.25, 0], [1e300, 0, 0]])
def test_whole_numbers_are_never_rounded(value):
    """Half a bond would silently be a broken one."""
    held = store(3, "bond")
    with pytest.raises(BadInput, match="'intact' holds uint8 numbers, and some given ones are not"):
        held.set(intact, value)
    assert intact not in held


@pytest.mark.parametrize("value", [0, 1.0, True, [1, 0, 1], [True, False, True], [1.0, 0.0, 1.0]])
def test_whole_numbers_of_any_type_fit(value):
    held = store(3, "bond")
    held.set(intact, value)
    assert np.array_equal(held.get(intact), np.broadcast_to(value, 3))
    assert held.get(intact).dtype == np.uint8


def test_entries_are_dropped_from_every_field():
    held = store()
    held.set(heat, [1.0, 2.0, 3.0])
    held.set(flow, [[1, 2], [3, 4], [5, 6]])
    held.keep(np.array([True, False, True]))
    assert held.get(heat).tolist() == [1.0, 3.0]
    assert held.get(flow).tolist() == [[1, 2], [5, 6]]
    assert held.allocate(stress).shape == (2, 2, 2)
    assert heat in held.given


def test_one_value_for_the_whole_part():
    held = store(None, "part")
    energy = field("energy", at="part")
    held.set(energy, 3.0)
    assert held.get(energy).shape == ()
    held.get(energy)[...] += 1.0
    assert held.get(energy) == 4.0
    with pytest.raises(BadInput, match="'energy' would be nan"):
        held.set(energy, np.nan)
