"""What a law's argument names mean."""

from __future__ import annotations

import math

import numba
import pytest

import rbs_core as rbs
from rbs_core import BadLaw, Field
from rbs_plugins.fields import breakable, density, volume_fraction
from rbs_plugins.loops.arguments import Argument, fields, names_of, resolve

temperature = Field("temperature", "node", "scalar", "K", "T", "Made up for these tests.")
age = Field("age", "bond", "scalar", "s", "a", "Made up for these tests.")


@pytest.fixture
def part():
    made = rbs.Part("rod", rbs.Box(size=4.0)).discretize(1.0).connect(1.0)
    made[temperature] = 300.0
    made[age] = 1.0
    return made


def test_each_kind(part):
    def law(stretch, extension, length, reference_length, time, dt, c, age, volume_fraction, temperature_i, density_j):
        """Asks for everything there is."""
        return stretch

    found = resolve(law, part, {"c": 2})
    assert found == [
        Argument("stretch", "kinematic"),
        Argument("extension", "kinematic"),
        Argument("length", "kinematic"),
        Argument("reference_length", "kinematic"),
        Argument("time", "clock"),
        Argument("dt", "clock"),
        Argument("c", "parameter", value=2.0),
        Argument("age", "bond", age),
        Argument("volume_fraction", "bond", volume_fraction),
        Argument("temperature_i", "node", temperature),
        Argument("density_j", "node", density),
    ]
    assert [argument.array for argument in found[-4:]] == [
        "field_age", "field_volume_fraction", "field_temperature", "field_density",
    ]  # fmt: skip
    assert found[0].array == ""


def test_fields_are_named_once(part):
    def law(temperature_i, temperature_j, breakable, stretch):
        """Asks twice for one field."""
        return stretch

    assert fields(resolve(law, part, {})) == [temperature, breakable]


def test_a_parameter_goes_before_a_field_of_its_name(part):
    found = resolve(lambda age: age, part, {"age": 3.0})
    assert found == [Argument("age", "parameter", value=3.0)]


def test_defaults_are_parameters_that_keywords_replace(part):
    def law(stretch, c=1.0, *, k=2):
        """Has defaults."""
        return stretch

    assert [argument.value for argument in resolve(law, part, {"k": 5.0})] == [None, 1.0, 5.0]


def test_unknown_name_lists_what_is_known(part):
    def law(stretch, temprature_i, c):
        """Is misspelt."""
        return stretch

    with pytest.raises(BadLaw) as caught:
        resolve(law, part, {"c": 1.0, "s0": 2.0})
    message = str(caught.value)
    for word in (
        "law 'law'", __file__, "part 'rod'", "'temprature_i'", "stretch, extension, length, reference_length",
        "time, dt", "(c, s0)", "age, bond_energy, bond_extension, bond_force, breakable",
        "contact_distance, influence, intact", "density", "temperature",
        "_i or _j",
    ):  # fmt: skip
        assert word in message, word
    assert message.endswith(". A field of your own counts once a plugin declares it or part[field] = ... has set it")


def test_a_field_of_ones_own_counts_once_the_part_has_it(part):
    warmth = Field("warmth", "node", "scalar", "J", "Q", "Made up for these tests.")
    with pytest.raises(BadLaw, match="A field of your own counts once"):
        resolve(lambda warmth_i: warmth_i, part, {})
    part[warmth] = 1.0
    assert fields(resolve(lambda warmth_i: warmth_i, part, {})) == [warmth]


@pytest.mark.parametrize("name", ["temperature", "age_i", "displacement_i", "stretch_i", "temperature_k"])
def test_what_is_no_argument(part, name):
    """A node field without an end, a bond field with one, a vector (once it is there), a kinematic with an end."""
    from rbs_plugins.fields import displacement

    part[displacement] = 0.0
    with pytest.raises(BadLaw, match=name.removesuffix("_i") if name == "displacement_i" else name):
        resolve(eval(f"lambda {name}: 0.0"), part, {})


def test_vectors_are_refused_by_name(part):
    with pytest.raises(BadLaw, match="'velocity', which is a vector"):
        resolve(lambda velocity_i: 0.0, part, {})


@pytest.mark.parametrize("value", [math.nan, math.inf, "much", None, [1.0, 2.0]])
def test_parameters_must_be_finite_numbers(part, value):
    with pytest.raises(BadLaw, match=r"parameter c=.* must be a finite number"):
        resolve(lambda stretch, c: c * stretch, part, {"c": value})


def test_names_of_a_law():
    @numba.njit
    def jitted(stretch, c):
        return c * stretch

    assert names_of(jitted) == ["stretch", "c"]
    assert names_of(lambda a, *, b: a) == ["a", "b"]
    with pytest.raises(BadLaw, match=r"takes \*rest"):
        names_of(lambda a, *rest: a)
    with pytest.raises(BadLaw, match=r"takes \*options"):
        names_of(lambda a, **options: a)
    with pytest.raises(BadLaw, match="no plain function"):
        names_of(3.0)
