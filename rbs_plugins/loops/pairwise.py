"""Bond loops: generated source around a plain law, one module per law, dimension and set of inputs.

The hot loop of the force is what LLVM vectorises: no branch, no store, unsigned neighbor indices, the law inlined. It
counts failing bonds only; a row with any is done again by the cold loop behind it, which breaks them. Kinematics, law
and criterion are compiled strictly (no reordering), so both ends of a bond get the same stretch to the bit and break
together; only the sums over a row may be reordered. A row is always summed in the same way, whatever the threads.

On a bond, ξ is the reference bond, y the current positions, d = y_j - y_i:
    length = |d|,  stretch = length / |ξ| - 1,  force density_i += law * β * V_j * d / length      (Silling 2000)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rbs_plugins.loops import cache
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.source import STRICT, compilable, definitions, plain

# Nodes and weights of Gauss-Legendre with 5 points on [0, 1], for potentials that nobody has given.
_GAUSS = ((0.04691007703066802, 0.11846344252809454), (0.23076534494715845, 0.23931433524968324),
          (0.5, 0.28444444444444444), (0.7692346550528415, 0.23931433524968324),
          (0.9530899229693319, 0.11846344252809454))  # fmt: skip
_PANELS = 8
_SLOPE_STEP = 1e-6


@dataclass(frozen=True)
class Recipe:
    """Everything that decides the text of the loops.

    Attributes:
        dimension: 1, 2 or 3.
        law, criterion, potential: plain functions; the last two may be None.
        law_arguments, criterion_arguments, potential_arguments: resolved, in the order of the functions.
        intact: whether bonds may be broken.
        breakable: whether some bonds may not break.
        fraction: whether neighbors count with a volume fraction.
        uniform: whether all volumes are equal.
        dissipation: whether the energy of breaking bonds is recorded.
        late: whether a failing bond carries its force for the rest of the step.
    """

    dimension: int
    law: Callable[..., Any]
    law_arguments: tuple[Argument, ...]
    criterion: Callable[..., Any] | None = None
    criterion_arguments: tuple[Argument, ...] = ()
    potential: Callable[..., Any] | None = None
    potential_arguments: tuple[Argument, ...] = ()
    intact: bool = False
    breakable: bool = False
    fraction: bool = False
    uniform: bool = True
    dissipation: bool = False
    late: bool = False


@dataclass
class _Text:
    """Source of one loop: its parameters and the pieces that the loops share."""

    recipe: Recipe
    used: list[Argument]

    @property
    def names(self) -> list[str]:
        """Parameters of the loop, in order."""
        r = self.recipe
        flags = (("intact", r.intact), ("breakable", r.breakable), ("volume_fraction", r.fraction),
                 ("volume", not r.uniform), ("before", r.dissipation), ("dissipation", r.dissipation))  # fmt: skip
        arrays = dict.fromkeys(a.array for a in self.used if a.field is not None)
        scalars = dict.fromkeys(f"p_{a.name}" for a in self.used if a.kind == "parameter")
        flagged = [name for name, there in flags if there]
        return ["offsets", "neighbors", "inverse", "y", "out", *flagged, *arrays, *scalars, "cell", "time", "dt"]

    def function(self, name: str, *body: str) -> str:
        """The whole function: one parallel loop over nodes with the given body."""
        lines = [cache.SUMS, f"def {name}({', '.join(self.names)}):", "    broken = 0", "    wrong = 0",
                 "    for i in prange(offsets.size - 1):", *(f"        {line}" for line in (*self.head(), *body)),
                 "    return broken, wrong"]  # fmt: skip
        return "\n".join(lines)

    def head(self) -> list[str]:
        """Slices of the row and values at the node."""
        r = self.recipe
        rows = ["neighbors", "inverse", *(["intact"] if r.intact else []), *(["breakable"] if r.breakable else []),
                *(["volume_fraction"] if r.fraction else [])]  # fmt: skip
        rows += [a.array for a in self.used if a.kind == "bond" and a.array not in rows]
        lines = ["begin, end = offsets[i], offsets[i + 1]"]
        lines += [f"row_{name} = {name}[begin:end]" for name in dict.fromkeys(rows)]
        lines += [f"y{k} = y[i, {k}]" for k in range(r.dimension)]
        ends = dict.fromkeys(a.array for a in self.used if a.kind == "node" and a.name.endswith("_i"))
        return lines + [f"here_{name} = {name}[i]" for name in ends]

    def bond(self) -> list[str]:
        """Kinematics of bond q of the row."""
        axes = range(self.recipe.dimension)
        here = ", ".join(f"y{k}" for k in axes)
        there = ", ".join(f"y[j, {k}]" for k in axes)
        lines = ["j = row_neighbors[q]", f"{', '.join(f'd{k}' for k in axes)}, length = kinematics({here}, {there})",
                 "stretch = stretch_of(length, row_inverse[q])"]  # fmt: skip
        wanted = {a.name for a in self.used}
        if wanted & {"reference_length", "extension"}:
            lines.append("reference_length = 1.0 / row_inverse[q]")
        if "extension" in wanted:
            lines.append("extension = length - reference_length")
        return lines

    def weight(self) -> str:
        """Volume factor of the neighbor inside the sum, " * ..." or nothing."""
        return (" * row_volume_fraction[q]" if self.recipe.fraction else "") + (
            "" if self.recipe.uniform else " * volume[j]"
        )

    @property
    def after(self) -> str:
        """Volume factor behind the sum."""
        return " * cell" if self.recipe.uniform else ""


def call(name: str, arguments: tuple[Argument, ...], **replaced: str) -> str:
    """Source of a call of a law inside a loop."""
    return f"{name}({', '.join(replaced.get(a.name) or value_of(a) for a in arguments)})"


def value_of(argument: Argument) -> str:
    """Source of the value of an argument inside a loop, for bond q to neighbor j."""
    if argument.kind == "parameter":
        return f"p_{argument.name}"
    if argument.kind == "bond":
        return f"row_{argument.array}[q]"
    if argument.kind == "node":
        return f"here_{argument.array}" if argument.name.endswith("_i") else f"{argument.array}[j]"
    return argument.name


def _force(r: Recipe) -> str:
    used = [*r.law_arguments, *r.criterion_arguments, *(r.potential_arguments if r.dissipation else ())]
    text = _Text(r, used)
    axes = range(r.dimension)
    zero = [f"f{k} = 0.0" for k in axes]
    pull = f"pull = {call('law', r.law_arguments)}{text.weight()} / length"
    add = [f"f{k} += pull * d{k}" for k in axes]
    holds = ["holds = row_intact[q] != 0"] if r.intact else []
    keep = ["pull = pull if holds else 0.0"] if r.intact else []
    loop = [*text.bond(), *holds]
    may = " & (row_breakable[q] != 0)" if r.breakable else ""
    count, cold = [], []
    if r.criterion is not None:
        fails = f"fails({call('criterion', r.criterion_arguments)}){may}"
        count = [f"failing += holds & {fails}"]
        record = _record(r, text) if r.dissipation else []
        released = [] if r.late else ["            holds = False"]
        lost = [f"    dissipation[i] += lost{text.after}"] if r.dissipation else []
        cold = ["if failing > 0:", *(f"    {line}" for line in zero), *(["    lost = 0.0"] if r.dissipation else []),
                "    for q in range(row_neighbors.size):", *(f"        {line}" for line in loop),
                f"        if holds & {fails}:", "            row_intact[q] = 0", *released,
                *(f"            {line}" for line in record),
                f"        {pull}", *(f"        {line}" for line in (*keep, *add)),
                *lost, "    broken += failing"]  # fmt: skip
    finite = " and ".join(f"isfinite(f{k})" for k in axes)
    return text.function(
        "force", *zero, *(["failing = 0"] if count else []), "for q in range(row_neighbors.size):",
        *(f"    {line}" for line in (*loop, *count, pull, *keep, *add)), *cold,
        *(f"out[i, {k}] += f{k}{text.after}" for k in axes), f"if not ({finite}):", "    wrong += 1",
    )  # fmt: skip


def _record(r: Recipe, text: _Text) -> list[str]:
    """Energy that goes into a bond that fails now, so that the energy balance of velocity Verlet closes.

    In that scheme a step takes half of the force of its start and half of that of its end. If the bond carries nothing
    at the end, it has taken its potential at the positions before and half of the work of the force of then. If it
    still carries its force (late), it has taken its potential now and will take half of the work of its force in the
    step to come, in which it is taken to lengthen as much as in this one.
    """
    axes = range(r.dimension)
    here, there = (", ".join(f"before[{end}, {k}]" for k in axes) for end in "ij")
    lines = [
        f"{', '.join(f'o{k}' for k in axes)}, length_old = kinematics({here}, {there})",
        "stretch_old = stretch_of(length_old, row_inverse[q])",
        "reference_length = 1.0 / row_inverse[q]",
    ]
    old = {"stretch": "stretch_old", "length": "length_old", "extension": "stretch_old * reference_length"}
    at, along, size = ({}, "d", "length") if r.late else (old, "o", "length_old")
    path = " + ".join(f"{along}{k} * (d{k} - o{k})" for k in axes)
    return [*lines, f"work = 0.5 * {call('law', r.law_arguments, **at)} * ({path}) / {size}",
            f"lost += 0.5 * ({_potential_call(r, **at)} + work){text.weight()}"]  # fmt: skip


def _potential_call(r: Recipe, **replaced: str) -> str:
    if r.potential is not None:
        return call("potential", r.potential_arguments, **replaced)
    fixed = tuple(a for a in r.law_arguments if a.kind != "kinematic")
    passed = [value_of(a) for a in fixed]
    return f"potential({', '.join([replaced.get('stretch', 'stretch'), '1.0 / row_inverse[q]', *passed])})"


def _energy(r: Recipe) -> str:
    text = _Text(r, [*r.law_arguments, *r.potential_arguments])
    held = f"0.5 * {_potential_call(r)}{text.weight()}"
    body = [*text.bond(), f"held = {held}", *(["held = held if row_intact[q] != 0 else 0.0"] if r.intact else [])]
    return text.function(
        "energy", "total = 0.0", "for q in range(row_neighbors.size):", *(f"    {line}" for line in body),
        "    total += held", f"out[i] += total{text.after}",
    )  # fmt: skip


def _stiffness(r: Recipe) -> str:
    """Sum of |d law / d stretch| / |ξ| β V over the family at rest; of a kink the steeper side."""
    text = _Text(r, list(r.law_arguments))
    rest = {"length": "(1.0 + {0}) * reference_length", "stretch": "{0}", "extension": "{0} * reference_length"}

    def law_at(stretch: str) -> str:
        swapped = {name: formula.format(stretch) for name, formula in rest.items()}
        return call("law", r.law_arguments, **swapped)

    body = ["j = row_neighbors[q]", "reference_length = 1.0 / row_inverse[q]", f"middle = {law_at('0.0')}",
            f"up = abs({law_at(f'{_SLOPE_STEP}')} - middle)", f"down = abs(middle - {law_at(f'-{_SLOPE_STEP}')})",
            f"total += max(up, down) * row_inverse[q]{text.weight()}"]  # fmt: skip
    return text.function(
        "stiffness", "total = 0.0", "for q in range(row_neighbors.size):", *(f"    {line}" for line in body),
        f"out[i] += total / {_SLOPE_STEP}{text.after}",
    )  # fmt: skip


def _quadrature(r: Recipe) -> str:
    """Potential = |ξ| ∫ law d(stretch) from 0 to the stretch, by Gauss-Legendre on panels."""
    fixed = [f"a_{a.name}" for a in r.law_arguments if a.kind != "kinematic"]
    names = {"stretch": "x", "length": "(1.0 + x) * size", "extension": "x * size", "reference_length": "size"}
    values = [names[a.name] if a.kind == "kinematic" else f"a_{a.name}" for a in r.law_arguments]
    terms = [
        line
        for point, weight in _GAUSS
        for line in (
            f"        x = stretch * (panel + {point}) / {_PANELS}",
            f"        total += {weight} * law({', '.join(values)})",
        )
    ]
    return "\n".join([STRICT, f"def potential({', '.join(['stretch', 'size', *fixed])}):", "    total = 0.0",
                      f"    for panel in range({_PANELS}):", *terms,
                      f"    return total * stretch * size / {_PANELS}"])  # fmt: skip


def _kinematics(dimension: int) -> str:
    axes = range(dimension)
    here, there = (", ".join(f"{end}{k}" for k in axes) for end in "ab")
    square = " + ".join(f"d{k} * d{k}" for k in axes)
    return "\n".join(
        [STRICT, f"def kinematics({here}, {there}):", *(f"    d{k} = b{k} - a{k}" for k in axes),
         f"    return {', '.join(f'd{k}' for k in axes)}, sqrt({square})", "",
         STRICT, "def stretch_of(length, inverse):", "    return length * inverse - 1.0", "",
         STRICT, "def fails(answer):", "    return answer != 0"]
    )  # fmt: skip


def build(recipe: Recipe) -> tuple[Any, dict[str, list[str]]]:
    """The module with `force`, `energy` and `stiffness`, and the parameter names of each, in order."""
    functions = {"law": recipe.law, "criterion": recipe.criterion, "potential": recipe.potential}
    functions = {name: function for name, function in functions.items() if function is not None}
    pieces = definitions(functions)
    names = None if pieces is not None else {name: _strict(function) for name, function in functions.items()}
    parts = [*(pieces or []), _kinematics(recipe.dimension)]
    if recipe.potential is None:
        parts.append(_quadrature(recipe))
    parts += [_force(recipe), _energy(recipe), _stiffness(recipe)]
    module = cache.load("\n\n".join(parts) + "\n", names)
    signatures = {}
    for name in ("force", "energy", "stiffness"):
        code = plain(getattr(module, name)).__code__
        signatures[name] = list(code.co_varnames[: code.co_argcount])
    return module, signatures


def _strict(function: Any) -> Any:
    from numba import njit

    return njit(error_model="numpy", forceinline=True)(compilable(function))
