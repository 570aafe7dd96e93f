"""Relation: feeds some fields of a part from others, when its trigger says so.

The contract of a relation is data: tuples of fields under four words, from which the analysis derives what to
allocate, clear, check and save (see `rbs_core.contract`):

    reads    looked at
    writes   every entry is set
    updates  changed in place, or only some entries
    adds     accumulated: several relations may add; cleared before the first of them in every step

and a fifth, `offers`: updated as well, but only in scenes where some relation reads it. A field of another part than
the relation's own is named as a pair (part, field).
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Hashable, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput, UndeclaredField
from rbs_core.fields import Field
from rbs_core.part import Connection, Host, Part
from rbs_core.trigger import Clock, Trigger, always

Key = tuple[Host, Field]
Fields = tuple[Field | Key, ...]


WORDS = ("reads", "writes", "updates", "adds", "offers")


class Relation:
    """Base of everything that happens in a step.

    Args:
        part: the part whose fields it feeds.
        when: trigger; every step if not given.

    A subclass declares its fields (class attributes, or instance attributes and properties where they depend on the
    arguments), fetches arrays by `self[field]` in `attach`, and works in `apply`.

    `example` says how to make a typical instance, for the conformance suite: keyword arguments beside the part, or,
    where they depend on the part, a static method that takes a connected part and returns them (None for a part that
    the relation is not made for). The first argument is the part unless the example names it, e.g. a connection.
    Relations among the arguments run in front of this one.

    `storages` names the representations of bonds that a relation with bond fields in its contract can work with. The
    arrays of a lattice's bond fields cannot be written, so what changes bonds through `self[field]` needs the list.
    `connections` names those whose bonds it works for. `feeders` are relations that must run in front of this one:
    where they are not listed themselves, the analysis puts them in front of the forces of a step. `owns` are relations
    that this one applies itself, as often as it needs, as a static solver does with its forces: they need not be
    listed, and what they name belongs to its own contract. `stays` is True for
    relations that touch more than a contract can name, files or coordinate systems: no other relation is moved across
    them to save time.
    """

    role: ClassVar[str] = "relation"
    stays: ClassVar[bool] = False
    example: ClassVar[Any] = None
    reads: Fields = ()
    writes: Fields = ()
    updates: Fields = ()
    adds: Fields = ()
    offers: Fields = ()
    storages: tuple[str, ...] = ("list",)
    connections: tuple[Connection, ...] = ()
    feeders: tuple[Relation, ...] = ()
    owns: tuple[Relation, ...] = ()

    _given_arguments: dict[str, Any]

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        # `__new__` takes anything: help and editors shall see what `__init__` takes
        own = inspect.signature(cls.__init__)
        cls.__signature__ = own.replace(parameters=list(own.parameters.values())[1:])  # type: ignore[attr-defined]

    def __new__(cls, *args: Any, **kwargs: Any) -> Relation:
        """Remembers the arguments, for `repr` and for the fingerprint of a checkpoint."""
        made = super().__new__(cls)
        # partial: what is missing is for __init__ to complain about, and copying makes an object without arguments
        bound = inspect.signature(cls.__init__).bind_partial(made, *args, **kwargs)
        named: dict[str, Any] = {}
        for name, value in list(bound.arguments.items())[1:]:
            kind = bound.signature.parameters[name].kind
            named.update(value if kind is inspect.Parameter.VAR_KEYWORD else {name: value})
        made._given_arguments = named
        return made

    def __init__(self, part: Part, *, when: Trigger = always) -> None:
        if not isinstance(part, Part):
            raise BadInput(f"{type(self).__name__}: the first argument must be a Part, got {part!r}")
        if not isinstance(when, Trigger):
            raise BadInput(f"{type(self).__name__}: when={when!r} must be a trigger such as every(25)")
        self.part = part
        self.when = when
        self._made_for = part.version
        self._offered: frozenset[Key] = frozenset()
        self._changed: frozenset[Key] | None = None
        self._strict = False
        self.starts: frozenset[Key] = frozenset()
        self._scene: Sequence[Relation] = ()

    # -- what a subclass overrides ----------------------------------------------------------------------------------

    def attach(self) -> None:
        """Called once, after allocation and before the first step: fetch arrays, compile."""

    def reset(self) -> None:
        """Forgets what an earlier run has left in the relation; called before a run that begins at step 0."""

    def begin(self, clock: Clock) -> None:
        """Called once before the first step of a run, when the fields hold their initial or resumed values."""

    def apply(self, clock: Clock) -> None:
        """Called in every step in which the trigger says yes."""

    def close(self) -> None:
        """Called after the last step, an interruption or an error: close files."""

    def state(self) -> dict[str, Any]:
        """What the relation keeps beside fields and a checkpoint must hold: numbers, strings, arrays."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Takes back what `state` gave; called after `attach` and before `begin` of a resumed run."""

    def squared_frequency(self) -> NDArray[np.float64] | None:
        """(n,) bound of the squared angular frequency that this relation gives each node, 1/s^2; None if it has no say.

        The bounds of all relations of a part add up; an explicit step is stable up to 2 / sqrt(largest sum). Called
        after `attach`.
        """
        return None

    def squared_frequencies(self) -> dict[Part, NDArray[np.float64]]:
        """The same for every part that the relation acts on."""
        bound = self.squared_frequency()
        return {} if bound is None else {self.part: bound}

    def items(self) -> int:
        """Directed bonds that one call works for, for the table of times; 0 if it has no bonds."""
        return 0

    def node_items(self) -> int:
        """Nodes that one call works for, for the table of times: those of its part, unless it knows better."""
        return len(self.part) if self.part.version[0] else 0

    def visited(self) -> int:
        """Those among them that the last call has looked at: all, unless some have nothing to say."""
        return self.items()

    def can_start(self, key: Key) -> bool:
        """True if `apply` can set a field that it adds to, without looking at what it holds.

        Where it is the first that adds, the field need not be cleared then: during a run `starts` names such fields.
        """
        return False

    @property
    def nbytes(self) -> int:
        """Bytes of what the relation keeps beside the fields, as far as that grows with the part."""
        return 0

    def batch_key(self) -> Hashable:
        """Relations with equal keys can be applied by one call of `batch`; None (default) for one that cannot.

        Asked after `attach`. Only relations that act in every step are done together, and only where their contracts do
        not touch each other.
        """
        return None

    def batch(self, relations: Sequence[Relation]) -> Callable[[Clock], None]:
        """A function that applies all these relations, this one among them."""
        raise NotImplementedError

    # -- what a subclass uses ---------------------------------------------------------------------------------------

    @property
    def outdated(self) -> bool:
        """True if the part got other nodes or bonds since the relation was made, with what it took from them."""
        nodes, bonds = self._made_for
        now = self.part.version
        return (nodes != now[0] and nodes > 0) or (bonds is not None and bonds != now[1])

    def keys(self, *words: str) -> list[Key]:
        """What the contract names under some of its words, as pairs (part, field), each once.

        Of the relations that it owns: what they add up it sets, as it clears the sums itself, and what one of them
        makes for another nobody else need give.
        """
        named = [each for word in words for each in getattr(self, word)]
        keys = dict.fromkeys(each if isinstance(each, tuple) else (self.part, each) for each in named)
        if self.owns:
            made = dict.fromkeys(key for each in self.owns for key in each.keys("writes", "adds"))
            given = {word: [key for each in self.owns for key in each.keys(word)] for word in WORDS}
            given |= {"writes": list(made), "adds": [], "reads": [key for key in given["reads"] if key not in made]}
            keys.update(dict.fromkeys(key for word in words for key in given[word]))
        return list(keys)

    @property
    def household(self) -> list[Relation]:
        """The relations that it owns, with theirs, and itself."""
        return [*dict.fromkeys(each for own in self.owns for each in own.household), self]

    @property
    def parts(self) -> list[Part]:
        """The parts that the contract speaks of, its own first."""
        return [host for host in self.hosts if isinstance(host, Part)]

    @property
    def hosts(self) -> list[Host]:
        """The parts, and connections of parts, that the contract speaks of, its own part first."""
        owned = [host for each in self.owns for host in each.hosts]
        return list(dict.fromkeys([self.part, *self.connections, *owned, *(host for host, _ in self.keys(*WORDS))]))

    def __getitem__(self, field: Field | Key) -> NDArray[Any]:
        """The array of a declared field of the part; `self[other, field]` of another part.

        Raises:
            UndeclaredField: if the contract does not name it, or names it as an offer that nobody took.
        """
        return self._fetch(field, raw=False)

    def raw(self, field: Field | Key) -> NDArray[Any]:
        """The same, as the store really holds it: for loops over the bonds of a lattice.

        Raises:
            UndeclaredField: as `self[field]`.
        """
        return self._fetch(field, raw=True)

    def _fetch(self, field: Field | Key, raw: bool) -> NDArray[Any]:
        key = field if isinstance(field, tuple) else (self.part, field)
        part, field = key
        changed = {*self.keys("writes", "updates", "adds"), *self._offered}
        if key not in changed and key not in self.keys("reads"):
            raise UndeclaredField(
                f"{self.label} fetches '{field.name}', which its contract does not name: add it to reads, writes, "
                f"updates or adds of {type(self).__name__}"
            )
        store = part.store(field.at)
        array = store.raw(field) if raw else store.allocate(field)
        if self._strict and key not in changed:
            array = array.view()
            array.flags.writeable = False
        return array

    __iter__ = None  # a relation is no sequence, although it has items: `[force]` is meant where a list is asked for

    def __setitem__(self, field: Field | Key, value: Any) -> None:
        """Sets every entry; also what `self[field] += ...` ends with.

        Raises:
            UndeclaredField: if the contract does not say that the relation changes the field.
        """
        array = self[field]
        key = field if isinstance(field, tuple) else (self.part, field)
        if key not in self.keys("writes", "updates", "adds") and key not in self._offered:
            raise UndeclaredField(
                f"{self.label} sets '{key[1].name}', which its contract only reads: name it under writes, updates "
                "or adds"
            )
        if value is not array:
            array[...] = value

    def constant(self, field: Field | Key) -> float | None:
        """The one value of a scalar field that is equal everywhere and that no relation of the scene changes, or None.

        Loops take it as a number: nothing to load. Before the relation is part of a prepared scene it is None.
        """
        key = field if isinstance(field, tuple) else (self.part, field)
        if self._changed is None or key in self._changed:
            return None
        array = self[key]
        return float(array.flat[0]) if array.size and (array == array.flat[0]).all() else None

    def wants(self, field: Field | Key) -> bool:
        """True if some relation of the scene reads this offer."""
        return (field if isinstance(field, tuple) else (self.part, field)) in self._offered

    def choose_storage(self) -> None:
        """Bonds that the contract names become a list if the relation can work with nothing else.

        Raises:
            BadInput: if the user wants a lattice there.
        """
        for host, field in self.keys(*WORDS):
            if field.at == "bond" and host.bonds.storage not in self.storages:
                host.bonds.need_list(self.label)

    # -- what the analysis uses -------------------------------------------------------------------------------------

    def join(
        self, offered: frozenset[Key], changed: frozenset[Key], strict: bool, scene: Sequence[Relation] = ()
    ) -> None:
        """Called by the analysis when the contracts are known: taken offers, what changes, all relations."""
        self._offered, self._changed, self._strict, self._scene = offered, changed, strict, scene

    @property
    def label(self) -> str:
        """Name in reports."""
        return f"{type(self).__name__} '{self.part.name}'"

    def identity(self) -> dict[str, Any]:
        """What makes this relation the same one in a resumed run: its parameters, and functions that a class fixes."""
        return self.parameters

    @property
    def parameters(self) -> dict[str, Any]:
        """The arguments that were given, without the part."""
        return {name: value for name, value in self._given_arguments.items() if not isinstance(value, Host)}

    def __repr__(self) -> str:
        given = "".join(f", {name}={_short(value)}" for name, value in self.parameters.items())
        return f"{type(self).__name__}({self.part.name}{given})"


Relation.__init_subclass__()  # its own signature, for help and editors, too


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size > 6:
        return f"<array {value.shape}>"
    if isinstance(value, Field):
        return value.name
    if isinstance(value, list | tuple):
        inner = ", ".join(_short(item) for item in value)
        return f"[{inner}]" if isinstance(value, list) else f"({inner})"
    if isinstance(value, Relation):
        return value.label
    if callable(value) and hasattr(value, "__name__"):
        return str(value.__name__)
    return repr(value)
