"""The largest stable step of a scene, and the node that sets it."""

from __future__ import annotations

import pytest

from rbs_core import Analysis, BadInput, UnstableStep
from rbs_core.stability import Limit, largest_stable_step
from rbs_plugins import BondBased
from rbs_plugins.fields import density, displacement
from tests.scenes import RHO, E
from tests.unit.core.toys import Stiff, Toy, a, b, c, line


def test_the_stable_step_is_that_of_the_stiffest_node_of_all():
    one, two = line(name="one"), line(name="two")
    relations = [Stiff(one, squares=[1, 2, 3, 1]), Stiff(one, squares=[1, 7, 1, 1]), Stiff(two, squares=[4, 4, 4, 8])]
    # squares of one node add up: 1 + 1, 2 + 7, 3 + 1, 1 + 1 in the first part
    assert Analysis(relations).stable_dt() == pytest.approx(2 / 3, rel=1e-15)
    assert Analysis(relations[2:]).stable_dt() == pytest.approx(2 / 8**0.5, rel=1e-15)


def test_a_relation_listed_twice_is_as_stiff_as_once():
    stiff = Stiff(line(), squares=[4, 4, 4, 4])
    assert Analysis([stiff, stiff]).stable_dt() == 1.0


def test_the_limit_names_part_and_node():
    soft, hard = line(name="soft"), line(name="hard")
    relations = [Toy(soft), Stiff(soft, squares=[1, 1, 1, 1]), Stiff(hard, squares=[4, 4, 16, 4])]
    assert largest_stable_step(relations) == Limit(0.5, hard, 2)
    assert largest_stable_step(relations[::-1]) == Limit(0.5, hard, 2)


def test_relations_without_a_say_and_nodes_without_stiffness_set_no_limit():
    part = line()
    assert largest_stable_step([]) is None
    assert largest_stable_step([Toy(part)]) is None
    assert largest_stable_step([Toy(part), Stiff(part, squares=[0, 0, 0, 0])]) is None


def test_the_refusal_says_what_where_and_the_cure():
    refusal = Limit(0.5, line(), 3).refusal(0.6)
    assert isinstance(refusal, UnstableStep)
    assert str(refusal).startswith("dt=0.6 s is above the stable step 0.5 s, which node 3 of part 'line' at [3.5] sets")
    assert "Take dt=0.4 (or leave it out), or force_dt=True" in str(refusal)


def test_a_material_knows_its_stable_step_once_it_has_a_density():
    part = line(horizon=1.0)
    part[displacement] = 0.0
    steel = BondBased(part, E=E)
    with pytest.raises(BadInput, match="is a density missing"):
        Analysis([steel]).stable_dt()
    part[density] = RHO
    # two bonds of length h per inner node: c V / h = 2 E / h^2, so dt = sqrt(2 rho / (4 E / h^2)); h = 1 m
    assert Analysis([steel]).stable_dt() == pytest.approx((RHO / (2 * E)) ** 0.5, rel=1e-12)


@pytest.mark.parametrize(("factor", "grows"), [(0.99, False), (1.01, True)])
def test_oscillators_explode_above_the_stable_step_and_not_below(factor, grows):
    """Leapfrog of u'' = -w^2 u is stable up to dt = 2 / w: exact for single oscillators."""
    part, square = line(), 9.0
    part[a] = 1.0
    kick = Toy(part, lambda self, clock: self[b].__iadd__(clock.dt * self[c]), reads=(c,), updates=(b,))
    drift = Toy(part, lambda self, clock: self[a].__iadd__(clock.dt * self[b]), reads=(b,), updates=(a,))
    spring = Stiff(
        part, lambda self, clock: self[c].__isub__(square * self[a]), squares=[square] * 4, reads=(a,), adds=(c,)
    )
    analysis = Analysis([kick, drift, spring])
    limit = analysis.stable_dt()
    assert limit == pytest.approx(2.0 / 3.0, rel=1e-15)
    analysis.run(steps=200, dt=factor * limit, force_dt=True)
    # below, the amplitude is at most 1 / sqrt(1 - 0.99^2) = 7.1; above, it grows by 1.33 per step
    assert (abs(part[a]).max() > 1e6) == grows
    assert abs(part[a]).max() < 8.0 or grows
