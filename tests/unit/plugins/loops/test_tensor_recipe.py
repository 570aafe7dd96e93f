"""What the texts of correspondence loops depend on."""

from __future__ import annotations

import pytest

from rbs_plugins.constitutive import stress
from rbs_plugins.constitutive.fracture import beyond_tension
from rbs_plugins.loops import tensor_lattice_text, tensor_rows_text
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.tensor_recipe import TensorRecipe

F = (Argument("F", "given"), Argument("lame", "parameter"), Argument("G", "parameter"))
LIMIT = (Argument("stretch", "kinematic"), Argument("s0", "parameter"))


@pytest.mark.parametrize("texts", [tensor_rows_text, tensor_lattice_text])
def test_what_calls_no_law_is_the_same_for_all_laws(texts):
    plain = TensorRecipe(2, stress.hencky, F, intact=True)
    other = TensorRecipe(2, stress.neo_hookean, F, beyond_tension, LIMIT, intact=True)
    for name in ("shape", "force", "reach", "bound"):
        assert texts.text(name, plain) == texts.text(name, other)
        assert not texts.text(name, plain).laws
    assert texts.text("stress", plain).laws == (stress.hencky,)
    assert texts.text("stress", other).laws == (stress.neo_hookean,)
    assert texts.text("failure", other).laws == (beyond_tension,)
