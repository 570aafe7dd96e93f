"""Sums, means and extremes of nodes: by hand, on every kind of region, in every precision."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Field
from rbs_plugins import largest, mean, smallest, total
from rbs_plugins.exporters.reductions import Reduced, nodes_of
from rbs_plugins.fields import damage, displacement, force_density, intact, kinetic_energy, velocity, volume

stress = Field("stress", "node", "tensor", "Pa", "σ", "Made up for these tests.")
flag = Field("flag", "node", "scalar", "1", "k", "Made up for these tests.", "uint8")


@pytest.fixture
def part(rng):
    made = rbs.Part("plate", rbs.Box(size=(4.0, 2.0))).discretize(1.0, thickness=0.25)
    made[damage] = rng.uniform(size=8)
    made[displacement] = rng.normal(size=(8, 2))
    made[stress] = rng.normal(size=(8, 2, 2))
    made[volume] = rng.uniform(0.5, 1.0, size=8)
    made[flag] = [1, 0, 1, 1, 0, 1, 1, 1]
    made.node_sets["left_edge"], made.node_sets["right_edge"] = [0, 4], [3, 7]
    return made


def numbers(reduction, part):
    """The numbers by the names of their columns."""
    reduced = Reduced("test", reduction, part)
    values = reduced(part.__getitem__)
    assert len(values) == len(reduced.names)
    return dict(zip(reduced.names, values, strict=True))


def test_scalars(part):
    assert numbers(total(damage), part) == {"total_damage": pytest.approx(part[damage].sum())}
    assert numbers(mean(damage), part) == {"mean_damage": pytest.approx(part[damage].mean())}
    assert numbers(largest(damage), part) == {"largest_damage": part[damage].max()}
    assert numbers(smallest(damage), part) == {"smallest_damage": part[damage].min()}
    assert numbers(total(flag), part) == {"total_flag": 6.0}


def test_weights(part):
    q, w = part[damage], part[volume]
    assert numbers(total(damage, weights=volume), part)["total_damage"] == pytest.approx((q * w).sum())
    assert numbers(mean(damage, weights=volume), part)["mean_damage"] == pytest.approx((q * w).sum() / w.sum())
    part[flag] = 0
    with pytest.raises(BadInput, match=r"test: mean\(damage, weights=flag\): the weights add up to nothing"):
        numbers(mean(damage, weights=flag), part)


def test_components(part):
    u, s = part[displacement], part[stress]
    assert numbers(total(displacement), part) == pytest.approx(
        {"total_displacement_x": u[:, 0].sum(), "total_displacement_y": u[:, 1].sum()}
    )
    for component in ("y", 1, np.int64(1)):
        found = numbers(largest(displacement, component=component), part)
        assert found == {"largest_displacement_y": u[:, 1].max()}
    length = np.hypot(u[:, 0], u[:, 1])
    assert numbers(mean(displacement, component="magnitude"), part) == {
        "mean_displacement_magnitude": pytest.approx(length.mean())
    }
    assert list(numbers(smallest(stress), part)) == [f"smallest_stress_{pair}" for pair in ("xx", "xy", "yx", "yy")]
    for component in ("xy", (0, 1)):
        assert numbers(smallest(stress, component=component), part) == {"smallest_stress_xy": s[:, 0, 1].min()}
    norm = np.sqrt((s**2).sum(axis=(1, 2)))
    assert numbers(largest(stress, component="magnitude"), part) == {
        "largest_stress_magnitude": pytest.approx(norm.max())
    }


@pytest.mark.parametrize(
    "where",
    [
        rbs.HalfSpace((0.0, 0.0), normal=(1.0, 0.0)),
        lambda points: points[:, 0] > 0,
        [2, 3, 6, 7],
        np.array([0, 0, 1, 1, 0, 0, 1, 1], bool),
    ],
    ids=["geometry", "function", "indices", "mask"],
)
def test_regions(part, where):
    right = part.positions[:, 0] > 0
    assert numbers(total(damage, where), part) == {"total_damage": pytest.approx(part[damage][right].sum())}
    weighted = (part[damage] * part[volume])[right].sum() / part[volume][right].sum()
    assert numbers(mean(damage, where, weights=volume), part) == {"mean_damage": pytest.approx(weighted)}


def test_node_sets(part):
    found = numbers(mean(displacement, "left_edge"), part)
    assert list(found) == ["mean_displacement_x_left_edge", "mean_displacement_y_left_edge"]
    assert list(found.values()) == pytest.approx(part[displacement][[0, 4]].mean(axis=0))
    assert nodes_of("test", part, "right_edge").tolist() == [3, 7]
    with pytest.raises(BadInput, match="part 'plate' has no node set 'left_egde': the nearest names are left_edge"):
        numbers(mean(damage, "left_egde"), part)
    bare = rbs.Part("bare", rbs.Box(size=2.0)).discretize(1.0)
    with pytest.raises(BadInput, match="part 'bare' has no node set 'left': there are none"):
        nodes_of("test", bare, "left")


def test_names_of_columns(part):
    assert list(numbers(mean(damage, "left_edge", name="left"), part)) == ["left"]
    assert list(numbers(mean(displacement, "left_edge", name="left"), part)) == ["left_x", "left_y"]
    assert list(numbers(mean(displacement, component="x", name="left"), part)) == ["left"]


@pytest.mark.parametrize(
    ("reduction", "unit"),
    [
        (total(force_density, weights=volume), "N"),
        (total(damage, weights=volume), "m^3"),
        (total(velocity, weights=volume), "m/s m^3"),
        (total(velocity, weights=damage), "m/s"),
        (mean(velocity, weights=volume), "m/s"),
        (largest(stress), "Pa"),
    ],
)
def test_units(reduction, unit):
    assert reduction.unit == unit


def test_they_say_what_they_are():
    left = rbs.Box(size=1.0)
    assert repr(total(force_density, "upper", component="y", weights=volume)) == (
        "total(force_density, 'upper', component='y', weights=volume)"
    )
    assert repr(mean(damage, left, name="here")) == f"mean(damage, {left!r}, name='here')"
    assert repr(largest(damage, np.arange(9))) == "largest(damage, <array (9,)>)"
    assert repr(smallest(damage, lambda X: X[:, 0] > 0)) == "smallest(damage, <lambda>)"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: total("damag"), "total: 'damag' is no node field: .*nearest names are damage"),
        (lambda: mean(kinetic_energy), "mean: .*'kinetic_energy'.* is no node field"),
        (lambda: largest(intact), "largest: .* is no node field"),
        (lambda: total(damage, weights="volume"), "total, weights: 'volume' is no node field"),
        (lambda: mean(damage, weights=displacement), "must be a scalar"),
    ],
)
def test_what_is_no_node_field_is_refused_at_once(make, message):
    with pytest.raises(BadInput, match=message):
        make()


@pytest.mark.parametrize(
    ("reduction", "message"),
    [
        (total(damage, component="x"), "component='x' must be left out for a scalar"),
        (total(damage, component="magnitude"), "component='magnitude' must be left out for a scalar"),
        (total(displacement, component="z"), "component='z' must be one of x, y, magnitude"),
        (total(displacement, component=2), "component=2 must be one of x, y, magnitude"),
        (total(stress, component="x"), "component='x' must be one of xx, xy, yx, yy, magnitude"),
        (total(damage, rbs.Box(size=(0.1, 0.1), center=(9.0, 9.0))), "no node of part 'plate' lies in Box"),
        (total(damage, []), "a region is a geometry, a mask, indices, a function or the name of a node set"),
        (total(damage, [99]), "node indices must lie in"),
    ],
    ids=str,
)
def test_what_the_part_does_not_have_is_refused(part, reduction, message):
    with pytest.raises(BadInput, match=message):
        Reduced("test", reduction, part)


@pytest.mark.parametrize("precision", ["double", "single"])
def test_sums_are_as_good_as_double_precision(precision, rng):
    """Round-off of a pairwise sum grows with the logarithm of the number of nodes: 20 epsilon of the sum of sizes."""
    many = rbs.Part("many", rbs.Box(size=(1000.0, 300.0)), precision=precision).discretize(1.0)
    many[displacement] = rng.normal(size=(len(many), 2))
    exact = math.fsum(many[displacement][:, 1].tolist())
    found = numbers(total(displacement, component="y"), many)["total_displacement_y"]
    assert abs(found - exact) <= 20 * 2.2e-16 * float(np.abs(many[displacement][:, 1]).sum(dtype=float))


def test_layers_are_left_out_unless_they_are_named():
    part = rbs.Part("bar", rbs.Box(size=3.0)).discretize(1.0)
    layer = part.extend("grip", "+x", 1.0)
    part[damage] = [0.25, 0.5, 0.75, 1.0]
    for reduction, value in [
        (total(damage), 1.5),
        (mean(damage, weights=volume), 0.5),
        (largest(damage), 0.75),
        (largest(damage, layer), 1.0),
        (total(damage, "grip"), 1.0),
        (total(damage, rbs.Everywhere()), 2.5),
    ]:
        assert list(numbers(reduction, part).values()) == [value]
