"""What a static solver takes: parts, forces, boundaries and supports that make a problem."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput
from rbs_plugins import BondBased, BoundaryDomain, Newton, Pressure, StrainEnergy
from rbs_plugins.fields import displacement
from tests.unit.plugins.statics.test_newton import LENGTH, SPACING, E, bar, ends


def test_a_missing_support_is_named_before_anything_is_solved():
    part = bar()
    x = part.positions[:, 0]
    roller = BoundaryDomain(part, x < SPACING, displacement=[0.0, None])
    pull = BoundaryDomain(part, x > LENGTH - SPACING, force=[1e6, 0.0])
    with pytest.raises(BadInput, match=r"40 nodes that hang together can move along y \(among them .* part 'bar'"):
        Analysis([Newton(part, BondBased(part, E), [roller, pull])], steps=1).run(progress=False)
    pin = BoundaryDomain(part, [0], displacement=[0.0, 0.0])
    with pytest.raises(BadInput, match="can turn"):
        Analysis([Newton(part, BondBased(part, E), [pin, pull])], steps=1).run(progress=False)


def test_a_force_of_another_part_is_refused():
    part, other = bar(), bar("other")
    with pytest.raises(BadInput, match="acts on part 'other', which is not among its parts"):
        Newton(part, BondBased(other, E))
    for parts, message in (
        ([], "give a part"),
        ([part, part], "part 'bar' is given twice"),
        ([part, "x"], "'x' is no Part"),
    ):
        with pytest.raises(BadInput, match=message):
            Newton(parts, BondBased(part, E))
    force, load = BondBased(part, E), BoundaryDomain(part, [0], force=[1.0, 0.0])
    with pytest.raises(BadInput, match="forces= is empty"):
        Newton(part, [])
    with pytest.raises(BadInput, match="no constitutive relation"):
        Newton(part, load)
    with pytest.raises(BadInput, match=r"BoundaryDomain\(bar.* is listed twice"):
        Newton(part, force, [load, load])
    with pytest.raises(BadInput, match="3 is no relation"):
        Newton(part, force, [3])
    solid = rbs.Part("solid", rbs.Box([0.4, 0.4, 0.4])).discretize(SPACING)
    with pytest.raises(BadInput, match="part 'bar' has dimension 2, 'solid' has 3"):
        Newton([part, solid], force)
    with pytest.raises(BadInput, match="adds nothing to the force density"):
        Newton(part, BondBased(part, E), [StrainEnergy(part, [BondBased(part, E)])])


def test_the_stiffness_is_that_of_what_acts():
    """A second force and a pressure come in the middle of the path."""
    part = bar()
    late = rbs.between(0.6, 1.0)
    x = part.positions[:, 0]
    forces = [BondBased(part, E), BondBased(part, E, when=late)]
    loads = [*ends(part, force=[0.0, -1e6]), Pressure(part, x > LENGTH - SPACING, 1e5, normal=(1.0, 0.0), when=late)]
    newton = Newton(part, forces, loads)
    Analysis([newton], steps=2).run(progress=False)
    assert max(len(each.residuals) for each in newton.history) <= 4
    assert not newton._K.constant


def test_nodes_on_a_line_in_space_need_not_be_held_against_turns_that_move_none():
    line = rbs.Part("line", rbs.Everywhere(), dimension=3)
    line.place(0.1 * np.arange(4)[:, None] * np.ones(3), np.full(4, 1e-3), spacing=0.18).connect(0.2)
    newton = Newton(line, BondBased(line, E), BoundaryDomain(line, rbs.Everywhere(), displacement=[0.1, 0.0, 0.0]))
    Analysis([newton], steps=1).run(progress=False)
    assert np.array_equal(line[displacement], np.tile([0.1, 0.0, 0.0], (4, 1)))


def test_the_number_of_load_steps_is_asked_for():
    part = bar()
    with pytest.raises(BadInput, match="say how many load steps"):
        Analysis([Newton(part, BondBased(part, E), ends(part, force=[1.0, 0.0]))], until=1.0).run(progress=False)
