"""Relations that do something else than their contracts say are caught by a watched run."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadLaw, DishonestRelation, NotFinite, UndeclaredField
from rbs_core.honesty import Watch, check_finite, not_finite
from tests.scenes import plate
from tests.unit.core.toys import Toy, a, b, c, field, line, plus, strength, total


def watched(*relations, steps=2):
    return rbs.Analysis(list(relations)).run(steps=steps, dt=0.5, debug=True)


def read(part):
    """A relation that makes a field of the part known to the scene."""
    return Toy(part, reads=(a,))


@numba.njit
def fill(array):
    for i in range(array.size):
        array[i] = 1.0


def given(n=4):
    part = line(n, horizon=1.0)
    part[a], part[b] = 1.0, 2.0
    return part


# -- the lies -------------------------------------------------------------------------------------------------------


def test_a_hidden_field():
    with pytest.raises(UndeclaredField, match="Toy 'line' fetches 'b', which its contract does not name"):
        watched(Toy(given(), lambda self, clock: self[b], reads=(a,)))


def test_writes_that_leaves_a_gap():
    def half(self, clock):
        self[c][: 2 if clock.step > 1 else 4] = 1.0

    with pytest.raises(DishonestRelation) as caught:
        watched(Toy(given(), half, writes=(c,)))
    assert str(caught.value) == (
        "step 2 (time 1 s), relation 0 (Toy 'line'): it says that it writes 'c' of part 'line' and left entry [2] "
        "unset (or NaN): set every entry, or name it under updates"
    )


def test_writes_that_only_adds():
    with pytest.raises(DishonestRelation, match="writes 'c' of part 'line' and left entry"):
        watched(Toy(given(), plus(c), writes=(c,)))


def test_writes_that_never_looks_at_a_whole_number_field():
    counts = field("counts", dtype="int32")
    with pytest.raises(DishonestRelation, match=r"'counts' .* left entry \[0\] unset"):
        watched(Toy(given(), writes=(counts,)))


@pytest.mark.parametrize(
    "store",
    [
        lambda array: array.__setitem__(0, 5.0),
        lambda array: array.fill(5.0),
        lambda array: np.add(array, 1.0, out=array),
        lambda array: array.sort(),
        fill,
    ],
    ids=["item", "fill", "out", "sort", "numba"],
)
def test_a_store_into_a_field_that_is_only_read(store):
    part = given()
    message = r"step 1 .* relation 0 \(Toy 'line'\).* stores into a field that its contract only reads .*under updates"
    with pytest.raises(DishonestRelation, match=message):
        watched(Toy(part, lambda self, clock: store(self[a]), reads=(a,)))
    assert (part[a] == 1.0).all()


def test_the_first_forces_are_watched_too():
    """Made for the initial state, before the first step."""
    part = given()
    kick, liar = Toy(part, reads=(c,)), Toy(part, lambda self, clock: self[a].fill(0.0), reads=(a,), adds=(c,))
    with pytest.raises(DishonestRelation, match=r"step 0 .*relation 1"):
        watched(kick, liar)


def test_a_compiled_store_is_caught_where_it_is_compiled():
    class Early(Toy):
        def attach(self):
            fill(self[a])

    with pytest.raises(DishonestRelation, match="Early 'line' stores into a field that its contract only reads"):
        watched(Early(given(), reads=(a,)))


@pytest.mark.parametrize(
    ("each", "change"),
    [
        (a, lambda self, clock: self.part[a].__setitem__(1, 7.0)),
        (strength, lambda self, clock: self.part[strength].__setitem__(1, 7.0)),
        (total, lambda self, clock: self.part[total].__setitem__((), 7.0)),
        (rbs.volume, lambda self, clock: self.part[rbs.volume].__setitem__(1, 7.0)),
        (rbs.intact, lambda self, clock: self.part[rbs.intact].__setitem__(1, 0)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_going_past_the_contract(each, change):
    """Through self.part everything can be reached: nothing forbids it, but the watch sees what changed."""
    part = given()
    part.bonds.need_list("the test")
    part[strength], part[total], part[rbs.intact] = 1.0, 1.0, 1
    message = rf"step 1 .*relation 1 .*it changed '{each.name}' of part 'line', which its contract does not name"
    with pytest.raises(DishonestRelation, match=message):
        watched(read(part), Toy(part, change, reads=(a,), updates=(c,)))


def test_changing_another_part():
    one, two = given(), line(name="two")
    two[a] = 1.0
    with pytest.raises(DishonestRelation, match="it changed 'a' of part 'two'"):
        watched(Toy(one, lambda self, clock: two[a].fill(3.0), updates=(a,)), read(two))


# -- the truth ------------------------------------------------------------------------------------------------------


def test_an_honest_scene_passes_with_the_same_numbers():
    def run(debug):
        scene = plate(n=10, speed=100.0, s0=0.005)
        scene.analysis().run(steps=12, debug=debug)
        return {each.name: scene.part[each].copy() for each in scene.part.fields}

    plain, careful = run(False), run(True)
    assert plain.keys() == careful.keys()
    assert all(np.array_equal(plain[name], careful[name]) for name in plain)
    assert plain["damage"].max() > 0.0


def test_every_word_may_be_used_as_it_says():
    part = given()
    flags = field("flags", dtype="bool")

    def work(self, clock):
        self[c][:] = self[a]
        self[b][0] += 1.0
        self[total][...] += 1.0
        self[flags][:] = True

    watched(Toy(part, work, reads=(a,), writes=(c, flags), updates=(b,), adds=(total,)))
    assert part[c].tolist() == part[a].tolist()


def test_an_offer_may_be_updated_when_somebody_reads_it():
    part = given()
    watched(Toy(part, plus(c), offers=(c,)), Toy(part, reads=(c,)))
    assert part[c][0] == 2.0


def test_nan_that_was_there_is_no_change():
    part = given()
    part[a][1] = np.nan
    watched(read(part), Toy(part, plus(c), updates=(c,)))


def test_nobody_watches_without_debug():
    part = given()
    rbs.Analysis([Toy(part, lambda self, clock: self.part[b].fill(9.0), reads=(a,))]).run(steps=1, dt=1.0)
    assert part[b][0] == 9.0


def test_the_watch_alone():
    part = given()
    relation = Toy(part, writes=(c,))
    part.store("node").allocate(c)
    watch = Watch([relation])
    watch.before(relation)
    assert np.isnan(part[c]).all()
    with pytest.raises(DishonestRelation):
        watch.after(relation)


def test_other_errors_of_a_relation_are_its_own():
    def fail(self, clock):
        raise BadLaw("nothing to do with stores")

    with pytest.raises(BadLaw, match=r"^nothing to do with stores$"):
        watched(Toy(given(), fail, reads=(a,)))


# -- finite numbers -------------------------------------------------------------------------------------------------


def test_the_first_entry_that_is_not_finite_is_named():
    part = given()
    part[a][2:] = np.nan, np.inf
    with pytest.raises(NotFinite, match=r"'a' of node 2 at \[2.5\] in part 'line' is nan: look at the loads"):
        check_finite([(part, b), (part, a)])
    vector = np.zeros((4, 2))
    vector[3, 1] = -np.inf
    assert "'u' of node 3 at [3.5] in part 'line' is -inf" in str(not_finite(part, "u", vector))


def test_bonds_and_parts_have_no_position():
    part = given()
    assert str(not_finite(part, "e", np.array(np.nan))).startswith("'e' in part 'line' is nan")
    assert str(not_finite(part, "e", np.array([0.0] * 5 + [np.inf]))).startswith("'e' in part 'line' is inf")


def test_whole_numbers_are_always_finite():
    part = given()
    part[rbs.intact] = 1
    check_finite([(part, rbs.intact), (part, a)])
