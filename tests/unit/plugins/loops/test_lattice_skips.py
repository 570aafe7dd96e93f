"""What is left out because nothing has reached it, and that margins, holes and threads leave no trace."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, Criterion, CriticalStretch, FractureDissipation, PairwiseForce, StrainEnergy
from rbs_plugins.fields import displacement, dissipation_density, force_density, intact, strain_energy_density
from rbs_plugins.loops.lattice_text import CHUNK
from rbs_plugins.loops.ranges import Cells
from tests.unit.plugins.loops.doubles import body


def linear(stretch, c):
    return c * stretch


def long(cells=6 * CHUNK):
    """A rod of six ranges, from each of which bonds lead to the next one."""
    return rbs.Part("rod", rbs.Box(size=float(cells))).discretize(1.0).connect(3.0, storage="lattice")


def once(part, force, steps=1):
    rbs.Analysis([force]).run(steps=steps, dt=0.1, force_dt=True, progress=False)
    return part[force_density].copy()


@pytest.mark.parametrize(
    ("moved", "ranges"),
    [([], 0), ([0], 1), ([3 * CHUNK + 500], 2), ([10, 5 * CHUNK + 9], 3), ([2 * CHUNK, 3 * CHUNK], 3)],
)
def test_ranges_that_something_has_reached_are_visited(moved, ranges):
    part = long()
    part[displacement] = 0.0
    part[displacement][moved] = 0.25
    force = PairwiseForce(part, linear, c=1.0, active=True)
    found = once(part, force)
    assert force.visited() == len(part.bonds) * ranges // 6
    everything = PairwiseForce(part, linear, c=1.0, active=False)
    part[force_density] = 0.0
    assert np.array_equal(once(part, everything), found)
    assert everything.visited() == len(part.bonds)


def test_what_has_come_to_rest_again_is_left_out_again():
    part = long()
    part[displacement] = 0.0
    part[displacement][5] = 0.25
    force = PairwiseForce(part, linear, c=1.0)  # by itself, wherever it can be done
    analysis = rbs.Analysis([force])
    visited = []
    for step, value in enumerate((0.25, 0.0, 0.25), 1):
        part[displacement][5] = value
        analysis.run(steps=step, dt=0.1, force_dt=True, progress=False)
        visited.append(force.visited() > 0)
        assert part[force_density].any() == (value > 0)
    assert visited == [True, False, True]


def test_ranges_without_bonds_are_left_out_once_the_last_one_breaks():
    part = long()
    part[displacement] = np.where(np.arange(len(part)) < CHUNK, 1.0, 1.01)[:, None] * part.positions
    force = PairwiseForce(part, linear, CriticalStretch(1.005), c=1.0)
    rbs.Analysis([force]).run(steps=2, dt=0.1, force_dt=True, progress=False)  # in one run: each looks at all bonds
    # bonds of the first range hold; those of the others have failed, but for some that lead to the first one
    assert 0 < force.visited() <= len(part.bonds) // 3
    assert 0 < np.count_nonzero(part.bonds.intact) < len(part.bonds) / 5


@pytest.mark.parametrize("steps", [1, 1023, CHUNK, CHUNK + 1, 2 * CHUNK + 1])
def test_reach_is_that_of_the_longest_step(steps):
    """Any bond ends in a range that counts as ahead of the one where it begins, which counts as behind the other."""
    part = rbs.Part("sheet", rbs.Box(size=(float(steps), 8.0))).discretize(1.0)
    cells = Cells(part.connect(1.0, storage="lattice").bonds.stored)
    first = (cells.stored.cells - cells.stored.margin) // CHUNK
    for number in range(len(cells.ranges)):
        moved = np.zeros(len(cells.ranges), bool)
        moved[number] = True
        ahead, behind = {number}, {number}
        for node in np.flatnonzero(first == number)[[0, -1]]:
            neighbors = part.bonds.neighbors(int(node))
            ahead |= set(first[neighbors[neighbors > node]].tolist())
            behind |= set(first[neighbors[neighbors < node]].tolist())
        assert ahead <= set(np.flatnonzero(cells.ahead(moved)).tolist()) <= set(range(number, len(moved)))
        assert behind <= set(np.flatnonzero(cells.behind(moved)).tolist()) <= set(range(number + 1))


@pytest.mark.parametrize(
    ("shape", "horizon"), [((20_000,), 3.0), ((300, 200), 3.015), ((30, 30, 60), 3.015), ((9,), 2.0)]
)
def test_bonds_of_a_stripe_end_in_it_or_in_the_next_one(shape, horizon):
    part = rbs.Part("body", rbs.Box(size=[float(n) for n in shape])).discretize(1.0).connect(horizon, storage="lattice")
    cells = Cells(part.bonds.stored)
    assert cells.stripes[:, 0].tolist() == [0, *cells.stripes[:-1, 1]]
    assert cells.stripes[-1, 1] == len(cells.ranges)
    assert (np.diff(cells.stripes) > 0).all()
    assert cells.color.tolist() == [k % 2 for k in range(len(cells.stripes))]
    lengths = np.diff(cells.stripes, axis=1)[:, 0] * CHUNK
    assert (lengths[:-1] >= cells.stored.steps.max()).all() or len(lengths) == 1
    chosen = np.zeros(len(cells.ranges), bool)
    chosen[-1] = True
    assert cells.in_stripes(chosen).tolist() == [False] * (len(lengths) - 1) + [True]


# -- to the bit ----------------------------------------------------------------------------------------------------


def wave(active, release="next step", mode="both", dimension=2):
    """A corner moves further and further into a body at rest, and breaks it."""
    size = {2: (80.0, 60.0), 3: (14.0, 12.0, 60.0)}[dimension]
    part = rbs.Part("plate", rbs.Box(size=size)).discretize(1.0)
    part.connect(3.015 if dimension == 2 else 1.8, storage="lattice")
    part[displacement] = 0.0
    force = BondBased(part, E=1.0, fracture=CriticalStretch(0.02, mode=mode, release=release), active=active)
    measures = [StrainEnergy(part, [force]), FractureDissipation(part)]
    analysis, visited = rbs.Analysis([force, *measures]), []
    distance = np.linalg.norm(part.positions - part.positions[0], axis=1)
    for step in range(1, 9):
        front = 9.0 * step
        part[displacement] = np.where(distance < front, 0.02 * (front - distance), 0.0)[:, None] * np.sin(
            part.positions + 0.1 * step
        )
        analysis.run(steps=step, dt=0.1, force_dt=True, progress=False)
        visited.append(force.visited())
    fields = (force_density, strain_energy_density, dissipation_density)
    return visited, [*(part[field].copy() for field in fields), part.raw(intact).copy()], part


@pytest.mark.parametrize(("release", "dimension"), [("at once", 2), ("next step", 2), ("at once", 3)])
def test_skipping_leaves_energies_and_late_failures_as_they_are(release, dimension):
    results = [wave(active, release, dimension=dimension) for active in (False, True, None)]
    (all_of_it, wanted, part), *others = results
    assert all_of_it[0] == len(part.bonds)
    assert part.bonds.has_broken
    for visited, found, _ in others:
        assert 0 < visited[0] < len(part.bonds)
        assert all(np.array_equal(one, two) for one, two in zip(found, wanted, strict=True))


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")
@pytest.mark.parametrize("release", ["at once", "next step"])
def test_threads_leave_no_trace(release):
    before, found = numba.get_num_threads(), []
    for threads in (1, 2, 2):
        numba.set_num_threads(threads)
        found.append(wave(None, release)[:2])
    numba.set_num_threads(before)
    for visited, values in found[1:]:
        assert visited == found[0][0]
        assert all(np.array_equal(one, two) for one, two in zip(values, found[0][1], strict=True))


def poisoned(part, *arrays):
    """Writes NaN to every cell without a node."""
    empty = np.ones(part.bonds.stored.size, bool)
    empty[part.bonds.stored.cells] = False
    for array in arrays:
        array[..., empty] = np.nan
    return np.count_nonzero(empty) - 2 * part.bonds.stored.margin


@pytest.mark.parametrize("release", ["at once", "next step"])
@pytest.mark.parametrize("hole", [False, True])
def test_cells_without_nodes_have_no_say_in_energies_and_failures(release, hole):
    results = []
    for poison in (False, True):
        part = body("lattice", (31, 28), hole=hole, uneven=True)
        start = part[displacement].copy()
        force = PairwiseForce(part, linear, CriticalStretch(0.012, release=release), c=2.0)
        analysis = rbs.Analysis([force, StrainEnergy(part, [force]), FractureDissipation(part)])
        for step, share in enumerate((0.5, 1.0, 1.4), 1):
            part[displacement] = share * start
            if poison and step > 1:
                held = [loop._held[0] for loop in (force._loops._sum, force._loops._energy[1])]
                targets = [each[name] for each in held for name in ("u", "volume")]
                assert (poisoned(part, *targets, force._loops._inputs["before"]) > 0) == hole
            analysis.run(steps=step, dt=0.1, force_dt=True, progress=False)
        fields = (force_density, strain_energy_density, dissipation_density)
        results.append([*(part[field].copy() for field in fields), part.raw(intact).copy(), part.bonds.has_broken])
    assert results[0][-1]
    assert all(np.array_equal(one, two) for one, two in zip(*results, strict=True))


# -- what cannot be left out ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "criterion", "why"),
    [
        (lambda stretch, c, time: c * stretch * time, None, "its law depends on more than the bond's own deformation"),
        (lambda length, reference_length, c: c * length / reference_length, None, r"its law is 2\.0 at rest"),
        (linear, lambda stretch, time: stretch > time, "its criterion depends on more than the bond's own deformation"),
        (linear, lambda stretch: stretch > -1.0, "its criterion is True at rest"),
    ],
)
def test_laws_that_act_at_rest_are_never_left_out(law, criterion, why):
    failure = None if criterion is None else Criterion(criterion)
    part = body("lattice", (9, 8))
    force = PairwiseForce(part, law, failure, active=True, c=2.0)
    with pytest.raises(BadInput, match=rf"active=True skips nodes that nothing has reached, but {why}: leave it out"):
        rbs.Analysis([force]).prepare()
    part[displacement] = 0.0
    free = PairwiseForce(part, law, failure, c=2.0)
    once(part, free)
    assert free.visited() == len(part.bonds)


def test_a_list_is_always_visited_in_full():
    part = body("list", (9, 8))
    part[displacement] = 0.0
    force = PairwiseForce(part, linear, c=2.0)
    once(part, force)
    assert force.visited() == force.items() == len(part.bonds)
    with pytest.raises(BadInput, match="but the bonds are stored as list: leave it out"):
        once(part, PairwiseForce(part, linear, c=2.0, active=True))
