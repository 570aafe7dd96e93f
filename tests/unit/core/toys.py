"""Relations, fields and parts as small as possible, for tests of the kernel."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadCheckpoint, Checkpoint, Field, Part, Relation, Trigger, always, every


def field(name: str, at: str = "node", shape: str = "scalar", unit: str = "1", **more: Any) -> Field:
    """A field that means nothing."""
    return Field(name, at, shape, unit, name, f"The toy {name}.", **more)


a, b, c, d = (field(name) for name in "abcd")
total = field("total", at="part")
strength = field("strength", at="bond")


def line(n: int = 4, name: str = "line", horizon: float | None = None) -> Part:
    """n nodes at 0.5, 1.5, ... on a line, connected if a horizon is given."""
    part = Part(name, rbs.Box(size=float(n), center=n / 2)).discretize(1.0)
    return part if horizon is None else part.connect(horizon)


class Toy(Relation):
    """A relation with any contract; `do(relation, clock)` is its work, `log` remembers its calls."""

    def __init__(
        self,
        part: Part,
        do: Callable[[Toy, Any], None] | None = None,
        *,
        reads: tuple[Field, ...] = (),
        writes: tuple[Field, ...] = (),
        updates: tuple[Field, ...] = (),
        adds: tuple[Field, ...] = (),
        offers: tuple[Field, ...] = (),
        role: str = "relation",
        when: Trigger = always,
        **parameters: Any,
    ) -> None:
        super().__init__(part, when=when)
        self.reads, self.writes, self.updates, self.adds, self.offers = reads, writes, updates, adds, offers
        self.role, self.do = role, do  # type: ignore[misc]
        self.log: list[Any] = []

    def attach(self) -> None:
        self.log.append("attach")

    def begin(self, clock: rbs.Clock) -> None:
        self.log.append("begin")

    def apply(self, clock: rbs.Clock) -> None:
        self.log.append(clock.step)
        if self.do is not None:
            self.do(self, clock)

    def close(self) -> None:
        self.log.append("close")

    @property
    def steps(self) -> list[int]:
        """Numbers of the steps in which it ran."""
        return [entry for entry in self.log if isinstance(entry, int)]


class Stiff(Toy):
    """Gives each node a squared angular frequency, 1/s^2: Stiff(part, squares=[...])."""

    def squared_frequency(self) -> np.ndarray:
        return np.asarray(self.parameters["squares"], dtype=float)


def plus(field: Field, value: float = 1.0) -> Callable[[Toy, Any], None]:
    """Work: adds a number to every entry of a field."""

    def work(relation: Toy, clock: rbs.Clock) -> None:
        relation[field][...] += value

    return work


class Private(Toy):
    """Keeps a number, a text and an array beside the fields; nothing before it has run."""

    count, last = 0, np.zeros(2)

    def apply(self, clock):
        self.count += 1
        self.last = np.array([clock.time, self.count * 0.1])
        self[a][...] += self.last[1]

    def state(self):
        return {"count": self.count, "text": "Δ", "last": self.last} if self.count else {}

    def restore(self, state):
        assert state["text"] == "Δ"
        self.count, self.last = state["count"], state["last"]


def oscillators(path: Path, when: rbs.Trigger = rbs.always) -> tuple[Part, rbs.Analysis]:
    """Four springs by symplectic Euler, a failing one, a measure now and then, a private counter."""
    part = line(horizon=1.0)
    part[d] = [1.0, 2.0, 3.0, 4.0]

    def pull(self, clock):
        self[c][...] -= self[d] * (self[a] - 1.0)

    def snap(self, clock):
        if clock.step % 7 == 0:
            self[rbs.intact][clock.step % 6] = 0

    relations = [
        Toy(part, lambda self, clock: self[b].__iadd__(clock.dt * self[c]), reads=(c,), updates=(b,)),
        Toy(part, lambda self, clock: self[a].__iadd__(clock.dt * self[b]), reads=(b,), updates=(a,)),
        Toy(part, pull, reads=(a, d), adds=(c,)),
        Toy(part, snap, updates=(rbs.intact,)),
        Toy(part, lambda self, clock: self[total].__iadd__(self[a].sum()), reads=(a,), updates=(total,), when=every(3)),
        Private(part, updates=(a,), when=every(4)),
    ]
    return part, rbs.Analysis([*relations, Checkpoint(path, when=when)], dt=0.1)


def held(part: Part) -> dict[str, bytes]:
    """Every bit of every field."""
    return {each.name: part[each].tobytes() for each in part.fields}


def refused(analysis: rbs.Analysis, parts: list[rbs.Part], path: Path, message: str, **arguments) -> None:
    """The file is refused with the message, and the analysis is as before."""
    analysis.prepare()
    before = [held(part) for part in parts]
    with pytest.raises(BadCheckpoint, match=message):
        analysis.run(steps=10, resume=path, **arguments)
    assert [held(part) for part in parts] == before
    assert analysis.clock.step == 0
