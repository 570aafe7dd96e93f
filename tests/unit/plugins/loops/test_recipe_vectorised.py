"""The hot loops must stay vectorised: a scalar square root and division cost four to eight times as much."""

from __future__ import annotations

import platform
import re

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, CriticalStretch, PairwiseForce
from rbs_plugins.fields import displacement
from rbs_plugins.loops import machine

pytestmark = pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads x86-64 assembly")


def bilinear(stretch, c, s_yield):
    """A user's law with a branch: it must become a select, not a jump."""
    if stretch < s_yield:
        return c * stretch
    return c * s_yield


def part(dimension: int, storage: str, *, uneven: bool = False, precision: str = "double") -> rbs.Part:
    made = rbs.Part("part", rbs.Box(size=(8e-3,) * dimension), precision=precision).discretize(1e-3)
    if uneven:
        made[rbs.volume] = np.linspace(1, 2, len(made)) * made[rbs.volume]
    return made.connect(3.015e-3, storage=storage)


def brittle(dimension: int, storage: str) -> PairwiseForce:
    return BondBased(part(dimension, storage), E=1e9, fracture=CriticalStretch(0.01))


SCENES = {
    "1-D breaking": lambda storage: brittle(1, storage),
    "2-D breaking": lambda storage: brittle(2, storage),
    "3-D breaking": lambda storage: brittle(3, storage),
    "2-D elastic": lambda storage: BondBased(part(2, storage), E=1e9),
    "2-D no-fail zone": lambda storage: BondBased(
        part(2, storage), E=1e9, fracture=CriticalStretch(0.01, within=rbs.Box(size=(4e-3, 4e-3)))
    ),
    "3-D partial volume": lambda storage: BondBased(
        part(3, storage), E=1e9, fracture=CriticalStretch(0.01), partial_volume="linear"
    ),
    "2-D uneven volumes": lambda storage: BondBased(
        part(2, storage, uneven=True), E=1e9, fracture=CriticalStretch(0.01)
    ),
    "3-D user's law": lambda storage: PairwiseForce(
        part(3, storage), bilinear, CriticalStretch(0.01), c=1e20, s_yield=0.005
    ),
}


def assembly_of(force: PairwiseForce) -> str:
    """What the machine runs for the force loop; numba shows none of code from its cache."""
    with rbs.Analysis([force]) as analysis:
        force.part[displacement] = 0.0
        analysis.prepare()
    return force._loops._sum._keep.entry._library.get_asm_str()


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("RBS_CACHE", "off")


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("scene", SCENES)
def test_the_force_loop_takes_roots_and_quotients_of_many_bonds_at_once(scene, storage, monkeypatch):
    monkeypatch.setenv("RBS_ROOTS", "hardware")
    force = SCENES[scene](storage)
    assembly = assembly_of(force)
    # packed double instructions, of any width: sqrtpd (SSE2) or vsqrtpd on xmm, ymm or zmm registers
    if force.part.dimension > 1 or storage == "lattice":  # in a list in 1-D the root of a square is an absolute value
        assert re.search(r"\bv?sqrtpd\b", assembly), "no packed square root: the loop over bonds is scalar"
    assert re.search(r"\bv?divpd\b", assembly), "no packed division: the loop over bonds is scalar"
    assert not re.search(r"\bcall\w*\s+\S*(law|criterion|kinematics)", assembly), "the law is not inlined"
    if storage == "lattice":
        assert not re.search(r"\bvgather", assembly), "neighbors ahead and back of a lattice need no gathers"


@pytest.mark.parametrize("scene", ["2-D breaking", "3-D user's law"])
def test_by_newton_the_force_loop_multiplies_many_bonds_at_once(scene, monkeypatch):
    monkeypatch.setenv("RBS_ROOTS", "newton")
    assembly = assembly_of(SCENES[scene]("lattice"))
    assert not re.search(r"\bv?(sqrt|div)[ps]d\b", assembly)
    assert re.search(r"\bv?psrlq\b", assembly), "no packed shift: the loop over bonds is scalar"
    assert not re.search(r"\bcall\w*\s+\S*(fused|root_guess|law)", assembly)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_the_widest_vectors_are_used_where_they_are_slow_to_be_chosen(storage):
    if machine.processor() != "intel512":
        pytest.skip("LLVM itself uses the widest vectors of this processor")
    assert "%zmm" in assembly_of(brittle(3, storage))


def test_on_amd_a_list_is_read_without_gathers(monkeypatch):
    if "+avx2" not in machine._features():
        pytest.skip("this processor has no gather instructions")
    monkeypatch.setattr(machine, "processor", lambda: "amd")
    assembly = assembly_of(brittle(3, "list"))
    assert re.search(r"\bv?sqrtpd\b", assembly)
    assert not re.search(r"\bvgather", assembly)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_single_precision_is_computed_in_single_precision(dimension, monkeypatch):
    """Twice as many bonds at once, as long as no number of a law or a loop widens what it meets."""
    monkeypatch.setenv("RBS_ROOTS", "hardware")
    assembly = assembly_of(
        PairwiseForce(
            part(dimension, "lattice", precision="single"), bilinear, CriticalStretch(0.01), c=1e20, s_yield=0.005
        )
    )
    assert re.search(r"\bv?sqrtps\b", assembly), "no packed square root: the loop over bonds is scalar"
    assert re.search(r"\bv?divps\b", assembly), "no packed division: the loop over bonds is scalar"
    assert not re.search(r"\bv?(sqrt|div|mul|add|sub)[ps]d\b", assembly), "arithmetic in double precision"
    assert not re.search(r"\bv?cvtps2pd\b", assembly), "something is widened"
    assert not re.search(r"\bvgather", assembly), "neighbors ahead and back of a lattice need no gathers"
