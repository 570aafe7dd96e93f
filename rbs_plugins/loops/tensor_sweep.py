"""The frame of correspondence loops over a lattice: range of cells -> block of cells -> steps -> cells."""

from __future__ import annotations

from collections.abc import Callable

from rbs_plugins.loops.lattice_text import CHUNK, PLAIN, LatticeBody
from rbs_plugins.loops.recipe import indented
from rbs_plugins.loops.tensor_recipe import TensorRecipe

BLOCK = {1: 1024, 2: 256, 3: 256}  # cells
AT_ONCE = {1: 1, 2: 2, 3: 2}  # steps


class Sums:
    """Pieces of the text of one loop over families.

    Args:
        r: recipe.
        name: of the function.
        sums: how many sums a cell has, `s0` and so on.
        arrays: by-cell arrays that a step looks at: name -> (number of rows, 0 for a flat one, where: letters of "ifb"
            for the cell itself, ahead and back).
        tables: (h, k) numbers of a step: name -> k.
    """

    def __init__(
        self, r: TensorRecipe, name: str, sums: int, arrays: dict[str, tuple[int, str]], tables: dict[str, int]
    ) -> None:
        self.r, self.name, self.sums, self.tables = r, name, sums, tables
        self.arrays = arrays if r.uniform else {**arrays, "volume": (0, "fb")}
        self.count = AT_ONCE[r.dimension]

    def _passed(self) -> dict[str, str]:
        """Parameters of the innermost function, and what is passed."""
        found = {}
        for name, (rows, where) in self.arrays.items():
            for n, row in enumerate([f"{k}, " for k in range(rows)] or [""]):
                suffix = str(n) if rows else ""
                if "i" in where:
                    found[f"here_{name}{suffix}"] = f"{name}[{row}a:e]"
                for step in range(self.count):
                    if "f" in where:
                        found[f"ahead{step}_{name}{suffix}"] = f"{name}[{row}a + s{step}:e + s{step}]"
                    if "b" in where:
                        found[f"back{step}_{name}{suffix}"] = f"{name}[{row}a - s{step}:e - s{step}]"
        for step in range(self.count):
            found[f"forth_bits{step}"] = f"bits[words[k + {step}], a:e]"
            found[f"back_bits{step}"] = f"bits[words[k + {step}], a - s{step}:e - s{step}]"
            found[f"bit{step}"] = f"masks[k + {step}]"
            for name, columns in self.tables.items():
                found |= {f"{name}{step}_{n}": f"{name}[k + {step}, {n}]" for n in range(columns)}
        return found | {f"own{n}": f"own{n}" for n in range(self.sums)}

    def text(
        self,
        step: Callable[[int], list[str]],
        close: list[str],
        *,
        stores: dict[str, int],
        numbers: tuple[str, ...] = (),
    ) -> str:
        """The function.

        Args:
            step: lines for the cell q and step number n.
            close: lines for the cell a + q when its sums, `own0[q]` and so on, are complete.
            stores: arrays by cell that `close` uses: name -> number of rows, 0 for a flat one.
            numbers: names that are passed on to `close`.
        """
        r, passed = self.r, self._passed()
        hints = [*LatticeBody.hints.get(r.processor, ()), "apart()"]
        holds = [
            line
            for n in range(self.count)
            for line in (f"f{n} = (forth_bits{n}[q] & bit{n}) != 0", f"b{n} = (back_bits{n}[q] & bit{n}) != 0")
        ]
        lines = [*(f"s{n} = own{n}[q]" for n in range(self.sums)), *holds,
                 *(line for n in range(self.count) for line in step(n)),
                 *(f"own{n}[q] = s{n}" for n in range(self.sums))]  # fmt: skip
        sweep = [*hints, "for q in range(own0.size):", *indented(lines)]
        slices: dict[str, str] = {}
        for name, rows in stores.items():
            slices |= {f"{name}{n}": f"{name}[{n}, a:e]" for n in range(rows)} if rows else {name: f"{name}[a:e]"}
        sums = {f"own{n}": f"own{n}" for n in range(self.sums)}
        ends = [*hints, "wrong = 0", "for q in range(own0.size):", *indented(close), "return wrong"]
        steps = ", ".join(f"s{n}" for n in range(self.count))
        starts = ", ".join(f"steps[k + {n}]" for n in range(self.count))
        block = [
            f"e = min(a + {BLOCK[r.dimension]}, top)",
            *(line for n in range(self.sums) for line in (f"own{n} = room[thread, {n}, :e - a]", f"own{n}[:] = 0")),
            f"for k in range(0, steps.size, {self.count}):",
            f"    {steps} = {starts}",
            f"    sweep({', '.join(passed.values())})",
            f"answer |= close({', '.join([*slices.values(), *sums, *numbers])})",
        ]
        whole = [*hints[:-1], "answer = 0", "for c in range(begin, end):",
                 f"    top = min(margin + (c + 1) * {CHUNK}, last)",
                 f"    for a in range(margin + c * {CHUNK}, top, {BLOCK[r.dimension]}):", *indented(block, 2),
                 "return answer"]  # fmt: skip
        arrays = dict.fromkeys([*self.arrays, *stores])
        names = [*arrays, "bits", "steps", "words", "masks", *self.tables, "room", "margin", "last", *numbers]
        return "\n\n".join([
            "\n".join([PLAIN, f"def sweep({', '.join(passed)}):", *indented(sweep)]),
            "\n".join([PLAIN, f"def close({', '.join([*slices, *sums, *numbers])}):", *indented(ends)]),
            "\n".join([PLAIN, f"def {self.name}(begin, end, thread, {', '.join(names)}):", *indented(whole)]),
        ])  # fmt: skip

    def volume(self, n: int, way: str) -> str:
        """Volume factor of the cell ahead or back."""
        return "" if self.r.uniform else f" * {way}{n}_volume[q]"
