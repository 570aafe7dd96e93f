"""What a run returns: where its time and its memory went."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rbs_core.memory import as_text

MOST, LEAST = 20, 1e-3  # rows of the table of memory, and share of all from which on something has a row


@dataclass
class Row:
    """Cost of one place in the list of relations.

    Attributes:
        name: label of the relation.
        calls: how often it was called.
        seconds: wall time of all calls, s.
        items: directed bonds that it worked for, in all calls.
        visited: those that it had to look at.
        nodes: nodes that one call works for.
    """

    name: str
    calls: int = 0
    seconds: float = 0.0
    items: int = 0
    visited: int = 0
    nodes: int = 0

    @property
    def saved(self) -> float:
        """Share of the directed bonds that did not have to be visited."""
        return 1.0 - self.visited / self.items if self.items else 0.0

    @property
    def rate(self) -> float | None:
        """Directed bonds per second in millions, None for a relation without bonds."""
        return self.items / self.seconds / 1e6 if self.items and self.seconds > 0 else None

    @property
    def worked(self) -> int:
        """Items that it worked for in all calls: directed bonds, or nodes where it has no bonds."""
        return self.items or self.nodes * self.calls

    @property
    def seconds_per_item(self) -> float | None:
        """Wall time per directed bond, or per node where it has no bonds, s; None for neither."""
        return self.seconds / self.worked if self.worked else None


@dataclass
class Held:
    """Memory of one thing.

    Attributes:
        owner: name of the part or connection, or label of the relation.
        name: of the field; "bonds" for their neighbors, "loops" for what a relation keeps beside fields.
        at: "node", "bond", "part", or "" for what is no field.
        nbytes: bytes.
    """

    owner: str
    name: str
    at: str
    nbytes: int


@dataclass
class Report:
    """What `Analysis.run` returns; `print(report)` shows the table of times, `print(report.memory_table())` memory.

    Attributes:
        rows: one per relation, in order.
        steps: steps done in this run.
        step: number of the last step.
        time: simulated time reached, s.
        seconds: wall time of the steps, s.
        prepare_seconds: wall time of checking, allocating and compiling, s.
        stopped: "finished", "interrupted", or "failed" where the run ended in an error.
        nbytes: memory of all fields and bonds, and of what the relations keep beside them, bytes.
        storages: how the bonds of each part are stored, by its name.
        memory: the same memory thing by thing, the largest first.
    """

    rows: list[Row] = field(default_factory=list)
    steps: int = 0
    step: int = 0
    time: float = 0.0
    seconds: float = 0.0
    prepare_seconds: float = 0.0
    stopped: str = "finished"
    nbytes: int = 0
    storages: dict[str, str] = field(default_factory=dict)
    memory: list[Held] = field(default_factory=list)

    def __str__(self) -> str:
        width = max([8, *(len(row.name) for row in self.rows)])
        head = f"{'calls':>7} {'items':>7} {'seconds':>9} {'share':>7} {'ns/item':>8} {'Mbond/s':>9} {'saved':>6}"
        lines = [f"   {'relation':<{width}}  {head}"]
        for number, row in enumerate(self.rows):
            share = row.seconds / self.seconds if self.seconds > 0 else 0.0
            items = _short(row.worked / row.calls) if row.calls and row.worked else ""
            each = "" if row.seconds_per_item is None else f"{row.seconds_per_item * 1e9:.3g}"
            rate = "" if row.rate is None else f"{row.rate:.1f}"
            saved = f"{row.saved:.0%}" if row.saved else ""
            cost = f"{row.calls:>7} {items:>7} {row.seconds:>9.3f} {share:>7.1%} {each:>8} {rate:>9} {saved:>6}"
            lines.append(f"{number:>2} {row.name:<{width}}  {cost}".rstrip())
        lines.append(
            f"{self.steps} steps in {self.seconds:.2f} s (prepared in {self.prepare_seconds:.2f} s), {self.stopped} at "
            f"step {self.step}, time {self.time:.6g} s; fields, bonds and relations hold {as_text(self.nbytes)}"
        )
        if self.storages:
            stored = [f"'{name}' as {storage}" for name, storage in self.storages.items()]
            lines.append(f"bonds stored: {', '.join(stored[:10])}{', ...' if len(stored) > 10 else ''}")
        return "\n".join(lines)

    def memory_table(self) -> str:
        """A line for every field, for the bonds and for what relations keep, the largest first."""
        if not self.memory:
            return ""
        large = [each for each in self.memory[:MOST] if each.nbytes >= LEAST * self.nbytes]
        rows = [(each.owner, each.name, each.at, as_text(each.nbytes)) for each in large]
        widths = [max([6, *(len(row[column]) for row in rows)]) for column in range(3)]
        lines = ["   " + "  ".join(f"{word:<{w}}" for word, w in zip(("of", "what", "at"), widths, strict=True))]
        lines[0] += "      memory"
        for row in rows:
            words = "  ".join(f"{word:<{width}}" for word, width in zip(row[:3], widths, strict=True))
            lines.append(f"   {words}  {row[3]:>10}")
        rest = self.memory[len(large) :]
        if rest:
            lines.append(f"   and {len(rest)} more  {as_text(sum(each.nbytes for each in rest))}")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """The same as plain numbers, for result.json."""
        return {
            "steps": self.steps,
            "step": self.step,
            "time": self.time,
            "seconds": self.seconds,
            "prepare_seconds": self.prepare_seconds,
            "stopped": self.stopped,
            "bytes": self.nbytes,
            "storages": self.storages,
            "relations": [
                {"name": row.name, "calls": row.calls, "seconds": row.seconds, "bonds": row.items, "saved": row.saved}
                | {"nodes": row.nodes, "seconds_per_item": row.seconds_per_item}
                for row in self.rows
            ],
            "memory": [vars(each).copy() for each in self.memory],
        }

    @classmethod
    def from_dict(cls, numbers: Mapping[str, Any]) -> Report:
        """The report that `as_dict` was made of; keys that are missing, as in older files, count as zero."""
        rows = []
        for each in numbers.get("relations", ()):
            items = each.get("bonds", 0)
            visited = round(items * (1.0 - each.get("saved", 0.0)))
            rows.append(Row(each["name"], each["calls"], each["seconds"], items, visited, each.get("nodes", 0)))
        plain = ("steps", "time", "seconds", "prepare_seconds", "stopped", "storages")
        report = cls(rows, **{name: numbers[name] for name in plain if name in numbers})
        report.step, report.nbytes = numbers.get("step", report.steps), numbers.get("bytes", 0)
        report.memory = [Held(**each) for each in numbers.get("memory", ())]
        return report


def _short(count: float) -> str:
    """A count in at most five characters: 950, 25.3k, 7.05M."""
    for unit in ("", "k", "M"):
        if count < 999.5:
            return f"{count:.0f}" if not unit else f"{count:.3g}{unit}"
        count /= 1000
    return f"{count:.3g}G"
