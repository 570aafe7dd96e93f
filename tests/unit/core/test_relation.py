"""A relation: its arguments, and what it may fetch."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput, Relation, UndeclaredField, every
from tests.unit.core.toys import Toy, a, b, c, field, line, strength, total


class Spring(Relation):
    """With every kind of argument."""

    def __init__(self, part, stiffness, *, law=None, others=(), when=rbs.always, **parameters):
        super().__init__(part, when=when)


def law(stretch):
    return stretch


def test_the_first_argument_is_a_part():
    with pytest.raises(BadInput, match="Toy: the first argument must be a Part, got 'plate'"):
        Toy("plate")


def test_when_is_a_trigger():
    with pytest.raises(BadInput, match=r"Toy: when=25 must be a trigger such as every\(25\)"):
        Toy(line(), when=25)


def test_wrong_arguments_are_python_errors():
    with pytest.raises(TypeError, match="stiffness"):
        Spring(line())
    with pytest.raises(TypeError, match="unexpected"):
        Relation(line(), colour="red")


def test_arguments_are_remembered_by_name_however_they_were_given():
    part = line()
    by_place, by_name = Spring(part, 3.0, s0=0.1), Spring(s0=0.1, stiffness=3.0, part=part)
    assert by_place.parameters == by_name.parameters == {"stiffness": 3.0, "s0": 0.1}


def test_repr_shows_what_was_given_and_no_more():
    part = line()
    assert repr(Spring(part, 3.0)) == "Spring(line, stiffness=3.0)"
    spring = Spring(part, np.zeros((4, 2)), law=law, others=[Toy(part), a], when=every(3), s0=(1, None))
    assert repr(spring) == (
        "Spring(line, stiffness=<array (4, 2)>, law=law, others=[Toy 'line', a], when=every(3), s0=(1, None))"
    )
    assert spring.label == "Spring 'line'"


def test_a_relation_that_overrides_nothing_does_nothing():
    relation, clock = Relation(line()), rbs.Clock(1.0)
    relation.attach(), relation.begin(clock), relation.apply(clock), relation.close()
    assert relation.state() == {}
    relation.restore({})
    assert relation.squared_frequency() is None
    assert relation.items() == 0
    assert relation.reads == relation.writes == relation.updates == relation.adds == relation.offers == ()


@pytest.mark.parametrize(
    ("kind", "role"),
    [
        (rbs.Constitutive, "constitutive"),
        (rbs.Integrator, "integrator"),
        (rbs.Boundary, "boundary"),
        (rbs.Measure, "measure"),
        (rbs.Exporter, "exporter"),
        (rbs.Statics, "statics"),
        (rbs.Checkpoint, "checkpoint"),
        (rbs.Relation, "relation"),
    ],
)
def test_roles(kind, role):
    assert kind.role == role
    assert issubclass(kind, Relation)


@pytest.mark.parametrize("word", ["reads", "writes", "updates", "adds"])
def test_a_declared_field_is_the_array_of_the_part(word):
    part = line()
    relation = Toy(part, **{word: (a,)})
    relation[a][2] = 5.0
    assert part[a].tolist() == [0.0, 0.0, 5.0, 0.0]


def test_fields_live_at_nodes_bonds_or_the_part():
    part = line(3, horizon=1.0)
    relation = Toy(part, updates=(a, strength, total))
    assert [relation[each].shape for each in (a, strength, total)] == [(3,), (4,), ()]


def test_an_undeclared_field_is_refused_even_if_it_is_there():
    part = line()
    part[b] = 1.0
    with pytest.raises(UndeclaredField, match=r"Toy 'line' fetches 'b', which its contract does not name.*of Toy"):
        Toy(part, reads=(a,))[b]


def test_an_offer_is_there_only_if_taken():
    relation = Toy(line(), offers=(a, b))
    relation.join(frozenset([(relation.part, a)]), frozenset([(relation.part, a)]), False)
    assert (relation.wants(a), relation.wants(b)) == (True, False)
    relation[a][:] = 1.0
    with pytest.raises(UndeclaredField, match="'b'"):
        relation[b]


def test_in_a_watched_run_what_is_only_read_cannot_be_written():
    part = line()
    relation = Toy(part, reads=(a, b), writes=(b,), updates=(c,))
    relation.join(frozenset(), frozenset([(relation.part, b), (relation.part, c)]), True)
    with pytest.raises(ValueError, match="read-only"):
        relation[a][0] = 1.0
    relation[b][0] = relation[c][0] = 1.0
    part[a][0] = 1.0  # the array itself stays writable
    relation.join(frozenset(), frozenset([(relation.part, b), (relation.part, c)]), False)
    relation[a][0] = 2.0  # not watched, not checked


def test_a_constant_is_a_field_that_is_equal_everywhere_and_never_changes():
    part = line(horizon=1.0)
    part[a], part[b], part[c] = 8000.0, [1.0, 2.0, 3.0, 4.0], 1.0
    relation = Toy(part, reads=(a, b, c))
    assert relation.constant(a) is None  # nobody knows yet what the scene changes
    relation.join(frozenset(), frozenset([(relation.part, c)]), False)
    assert relation.constant(a) == 8000.0
    assert isinstance(relation.constant(a), float)
    assert relation.constant(b) is None
    assert relation.constant(c) is None


def test_a_field_without_entries_is_no_constant():
    with pytest.warns(UserWarning, match="1 nodes have no bond"):
        part = line(1, horizon=1.0)
    relation = Toy(part, reads=(strength,))
    relation.join(frozenset(), frozenset(), False)
    assert relation.constant(strength) is None


def test_tensors_too():
    part = line()
    stiffness = field("stiffness", shape="tensor")
    relation = Toy(part, reads=(stiffness,))
    assert relation[stiffness].shape == (4, 1, 1)


def test_a_field_of_another_part_is_named_as_a_pair():
    """What contact and interfaces need: a contract may speak of two parts."""
    here, there = line(), line(name="other")

    class Pull(Toy):
        def __init__(self, part, other):
            super().__init__(part)
            self.other = other
            self.reads, self.adds = ((other, a),), (b, (other, b))

        def apply(self, clock):
            self[b] += self[self.other, a]
            self[self.other, b] -= self[self.other, a]

    there[a] = 2.0
    pull = Pull(here, there)
    assert pull.parts == [here, there]
    assert pull.keys("reads", "adds") == [(there, a), (here, b), (there, b)]
    analysis = Analysis([pull])
    analysis.run(steps=2, dt=1.0, progress=False, debug=True)
    assert analysis.parts == [here, there]
    # cleared in every step, in both parts
    assert (here[b] == 2.0).all()
    assert (there[b] == -2.0).all()
    with pytest.raises(UndeclaredField):
        pull[a]


def test_a_relation_of_other_nodes_or_bonds_is_refused():
    """Constants and node lists were taken from the part as it was."""
    part = line(horizon=1.0)
    toy = Toy(part)
    part.connect(2.0)
    assert toy.outdated
    with pytest.raises(BadInput, match=r"Toy 'line' was made for other nodes or bonds .*: make the relation again"):
        Analysis([toy]).prepare()
    part = line()
    early = Toy(part)
    part.connect(1.0)
    assert not early.outdated  # it took nothing from bonds
    part.discretize(0.5)
    assert early.outdated
