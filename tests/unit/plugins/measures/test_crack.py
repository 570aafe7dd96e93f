"""Tips of cracks that are known."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Field
from rbs_plugins import CrackTip, Damage
from rbs_plugins.fields import crack_tip, crack_tip_speed, damage, displacement, reference_position

upper_tip = Field("upper_tip", "part", "vector", "m", "x", "Tip of the upper branch.")
upper_speed = Field("upper_speed", "part", "scalar", "m/s", "v", "Speed of the upper branch.")


class Front(rbs.Measure):
    """Damage that runs along two lines, one faster than the other."""

    reads = (reference_position,)
    writes = (damage,)

    def apply(self, clock):
        x, y = self[reference_position].T
        upper = (np.abs(y - 2.0) < 0.6) & (x < 3.0 * clock.time)
        lower = (np.abs(y + 2.0) < 0.6) & (x < 5.0 * clock.time)
        self[damage][...] = 0.5 * (upper | lower)


def plate():
    part = rbs.Part("plate", rbs.Box(size=(40.0, 8.0))).discretize(1.0)
    return part.connect(3.015)


def test_a_cut():
    """The tip of a cut lies on it, in the last column of nodes that have lost more than the threshold."""
    part = plate()
    part.bonds.cut(rbs.Segment((-30.0, 0.0), (4.9, 0.0)))
    rbs.Analysis([Damage(part), CrackTip(part, (2, 0))]).run(steps=1, dt=1.0, progress=False)
    x, y = part[crack_tip]
    assert y == 0
    assert 0 <= 4.9 - x <= 1.5
    assert part[crack_tip_speed] == 0


def test_branches_have_tips_and_speeds_of_their_own():
    part = plate()
    relations = [
        Front(part),
        CrackTip(part, (1, 0), window=12),
        CrackTip(part, (1, 0), window=12, within=rbs.HalfSpace((0, 0), normal=(0, 1)), position=upper_tip,
                 speed=upper_speed),
    ]  # fmt: skip
    rbs.Analysis(relations).run(steps=12, dt=0.3, progress=False)
    # nodes at half spacings: the foremost one in front of x = 18 is at 17.5, in front of 10.8 at 10.5
    np.testing.assert_allclose(part[crack_tip], [17.5, -2.0])
    np.testing.assert_allclose(part[upper_tip], [10.5, 2.0])
    assert part[crack_tip_speed] == pytest.approx(5.0, rel=0.05)
    assert part[upper_speed] == pytest.approx(3.0, rel=0.05)


def test_before_there_is_a_crack_the_tip_is_where_it_starts():
    part = plate()
    part[damage] = 0.0
    rbs.Analysis([CrackTip(part, (1, 0), start=(-20.0, 1.0))]).run(steps=2, dt=1.0, progress=False)
    np.testing.assert_array_equal(part[crack_tip], [-20.0, 1.0])
    assert part[crack_tip_speed] == 0


def test_bad_input_is_refused():
    part = plate()
    for given, why in [
        ({"direction": (0, 0)}, "has no length"),
        ({"direction": (1, 0, 0)}, "must be 2 finite numbers"),
        ({"direction": (1, 0), "threshold": 1.0}, "threshold=1.0 must be a damage"),
        ({"direction": (1, 0), "window": 1}, "window=1 must be"),
        ({"direction": (1, 0), "within": rbs.Nowhere()}, "no node lies in"),
        ({"direction": (1, 0), "start": "left"}, "start='left' must be"),
        ({"direction": (1, 0), "position": displacement}, "must be a field like"),
    ]:
        with pytest.raises(BadInput, match=why):
            CrackTip(part, **given)


def test_layers_belong_to_no_crack():
    """A cut through the body and the layer behind it ends in the body; a region may name the layer."""
    part = rbs.Part("plate", rbs.Box(size=(10.0, 8.0))).discretize(1.0)
    layer = part.extend("grip", "+x", 4.0)
    part.connect(3.015)
    part.bonds.cut(rbs.Segment((-30.0, 0.0), (30.0, 0.0)))
    there = Field("there", "part", "vector", "m", "x", "Tip in the layer.")
    fast = Field("fast", "part", "scalar", "m/s", "v", "Speed of the tip in the layer.")
    within = CrackTip(part, (1, 0), within=layer, position=there, speed=fast)
    rbs.Analysis([Damage(part), CrackTip(part, (1, 0)), within]).run(steps=1, dt=1.0, progress=False)
    assert part[crack_tip].tolist() == [4.5, 0.0]
    assert part[there].tolist() == [8.5, 0.0]
