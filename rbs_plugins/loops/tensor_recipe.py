"""What decides the text of correspondence loops, and what their texts for all representations of bonds share.

All sums are of numbers without dimension: lengths in horizons, volumes in mean volumes V0. With ξ and η so measured, w
the product of influence, partial volume and volume of the neighbor, and μ 1 while the bond holds,

    K_i = Σ μ w ξ⊗ξ        H_i = F_i − I = (Σ μ w η⊗ξ) K_i^-1        B_i = P_i K_i^-1 − g_i H_i
    δ L_i = Σ μ w [(B_i + B_j) ξ + (g_i + g_j) η]

which is T_i⟨ξ⟩ = ω (P_i K_i^-1 ξ + g_i z), z = Y⟨ξ⟩ − F_i ξ, in δ and V0 (Silling et al. 2007; Silling 2017). H is zero
to the bit for a translation, and B_i takes Σ μ w ξ, which is computed once, so that pass 2 looks at neighbors only.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rbs_core import Field
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import FAILS, Recipe, strict
from rbs_plugins.loops.source import STRICTLY, compilable, definitions

SECANTS = 6  # steps to the stretch across a plate or bar: superlinear, so the last ones change the last digits
TENSORS = ("F_i", "F_j", "P_i", "P_j")  # what criteria may ask for beside the names of bond laws
# K is singular if det K < SINGULAR (tr K / d)^d: bonds in nearly one plane, or along one line.
SINGULAR = {1: 1e-6, 2: 1e-3, 3: 1e-4}


@dataclass(frozen=True)
class TensorRecipe(Recipe):
    """Everything that decides the text of the loops.

    Attributes:
        case: "1-D", "stress", "strain" or "3-D".
        state: fields that the law takes along.
        thickness: closed form of F33 in plane stress, or None.
        thickness_arguments: resolved.
        gain: whether there is a zero-energy control.
        soft: arguments of the function that softens bonds, or None; rows only.
        even: whether g is the same for all nodes whose shape tensor is not singular; lattice only.
        softening: that function.
        slope: its derivative with respect to the stretch, for tangents.
        keeps: which tensors of a node are stored: letters of "FP".
        early: whether bonds can be tested before the deformation gradients are known.
    """

    case: str = "3-D"
    state: tuple[Field, ...] = ()
    thickness: Callable[..., Any] | None = None
    thickness_arguments: tuple[Argument, ...] = ()
    gain: bool = True
    even: bool = False
    softening: Callable[..., Any] | None = None
    slope: Callable[..., Any] | None = None
    soft_arguments: tuple[Argument, ...] = ()
    keeps: str = ""
    early: bool = True

    @property
    def bare(self) -> TensorRecipe:
        made = super().bare
        assert isinstance(made, TensorRecipe)

        def without(arguments: tuple[Argument, ...]) -> tuple[Argument, ...]:
            return tuple(replace(argument, value=None) for argument in arguments)

        return replace(
            made,
            thickness_arguments=without(self.thickness_arguments),
            soft_arguments=without(self.soft_arguments),
        )

    @property
    def laws(self) -> dict[str, Callable[..., Any]]:
        more = {"thickness": self.thickness, "soften": self.softening, "slope": self.slope}
        return {**super().laws, **{name: function for name, function in more.items() if function is not None}}

    @property
    def at_nodes(self) -> tuple[Argument, ...]:
        """Arguments of the functions of a node."""
        return (*self.law_arguments, *self.thickness_arguments)

    def entries_of(self, field: Field) -> int:
        """How many numbers a node has of a state."""
        return int(self.dimension ** len(field.entry(self.dimension)))

    @property
    def across(self) -> bool:
        """Whether a stretch across the plate or bar is to be found."""
        return self.case in ("1-D", "stress")

    def text(self, *loops: str) -> Text:
        """Loops as one module, with the laws that they call: what calls none is the same for all models."""
        across = self._of_nodes() if any("stretch_across(" in loop for loop in loops) else []
        calls = "".join([*loops, *across])
        laws = {name: function for name, function in self.laws.items() if re.search(rf"\b{name}\(", calls)}
        pieces = definitions(laws, single=self.real == "float32")
        names = None if pieces is not None else {name: _strict(function) for name, function in laws.items()}
        parts = [
            f"from numba import {self.real} as REAL",
            "from rbs_plugins.loops.bits import fused, root_guess",
            "from rbs_plugins.loops.machine import apart, narrower, no_gathers, widest",
            *(pieces or []),
            *across,
            *([FAILS] if "fails(" in calls else []),
            *loops,
        ]
        states = (field.name for field in self.state if field.shape == "tensor")
        return Text("\n\n".join(parts) + "\n", names, tuple(laws.values()), ("F", *TENSORS, *states))

    # -- stress of a node -------------------------------------------------------------------------------------------

    def _of_nodes(self) -> list[str]:
        """What the loops call for a node: `stretch_across`."""
        if not self.across:
            return []
        names, d = self.passed(), self.dimension
        entries = [f"h{a}{b}" for a in range(d) for b in range(d)]
        if self.thickness is not None:
            call = f"thickness({', '.join(self.value_of(a, 'F') for a in self.thickness_arguments)})"
            lines = [f"F = {gradient(d, 'h{a}{b}', 'REAL(1.0)')}", f"return REAL({call})"]
            return [strict("stretch_across", ", ".join([*entries, "stiff", *names]), *lines)]
        stress = self.call_law("F") + ("[0]" if self.state else "")
        residual = strict("across_stress", ", ".join([*entries, "t", *names]),
                          f"F = {gradient(d, 'h{a}{b}', 't', self.case)}", f"return REAL({stress}[2][2])")  # fmt: skip
        ask = f"across_stress({', '.join(entries)}, {{}}, {', '.join(names)})"
        secant = [f"there = {ask.format('t')}", "change = there - before",
                  "move = there * (t - last) / (change if change != 0 else REAL(1.0))",
                  "last, before = t, there", "t = t - (move if change != 0 else REAL(0.0))"]  # fmt: skip
        lines = ["last = REAL(1.0)", f"before = {ask.format('last')}", "t = last - before / stiff",
                 *(SECANTS * secant), "return t"]  # fmt: skip
        return [residual, strict("stretch_across", ", ".join([*entries, "stiff", *names]), *lines)]

    def passed(self) -> list[str]:
        """Names of what the functions of a node need beside F."""
        every = {a.name: a for a in (*self.at_nodes, *self.potential_arguments)}
        return list(dict.fromkeys(self.value_of(a, "F") for a in every.values() if a.name != "F"))

    def value_of(self, argument: Argument, F: str) -> str:
        """Source of an argument of a function of a node; states and fields are variables s_name."""
        if argument.kind == "parameter":
            return f"p_{argument.name}"
        if argument.kind == "clock":
            return argument.name
        return F if argument.name == "F" else f"s_{argument.name}"

    def call_law(self, F: str) -> str:
        """Source of a call of the law."""
        return f"law({', '.join(self.value_of(a, F) for a in self.law_arguments)})"

    def kinematics_of_node(self, sums: str, inverse: str) -> list[str]:
        """Lines from sums to H, F and `across`.

        Args:
            sums: pattern of Σ μ w η⊗ξ, {n} its number.
            inverse: pattern of K^-1, {n} the number of an entry, see `packed`.
        """
        d = self.dimension
        lines = []
        for a in range(d):
            for b in range(d):
                terms = [f"{sums.format(n=a * d + c)} * {inverse.format(n=packed(d, c, b))}" for c in range(d)]
                lines.append(f"h{a}{b} = ({' + '.join(terms)}) * per_horizon")
        if self.across:
            entries = [f"h{a}{b}" for a in range(d) for b in range(d)]
            lines.append(f"across = stretch_across({', '.join([*entries, 'stiff', *self.passed()])})")
        across = "across" if self.across else "REAL(1.0)"
        return [*lines, f"F = {gradient(d, 'h{a}{b}', across, self.case)}"]

    def stress_of_node(self, inverse: str, gain: str) -> list[str]:
        """Lines from F to P, new states `next_...` and B, `b00` and so on."""
        d = self.dimension
        results = ["P", *(f"next_{field.name}" for field in self.state)]
        lines = [f"{', '.join(results)} = {self.call_law('F')}"]
        for a in range(d):
            for b in range(d):
                terms = [f"P[{a}][{c}] * {inverse.format(n=packed(d, c, b))}" for c in range(d)]
                held = f" - {gain} * h{a}{b}" if self.gain else ""
                lines.append(f"b{a}{b} = {' + '.join(terms)}{held}")
        return lines

    def states(self, entry: Callable[[str, int], str]) -> list[str]:
        """Lines that set s_name of all states and fields that functions of a node ask for.

        Args:
            entry: source of component n of an array of that name.
        """
        lines, state = [], {field.name: field for field in self.state}
        for name in dict.fromkeys(a.name for a in (*self.at_nodes, *self.potential_arguments)):
            if name in state and state[name].shape == "tensor":
                held = [entry(f"state_{name}", n) for n in range(self.dimension**2)]
                lines.append(f"s_{name} = {deviatoric(self.dimension, held)}")
            elif name in state:
                lines.append(f"s_{name} = {entry(f'state_{name}', 0)}")
        fields = {a.name: a.array for a in (*self.at_nodes, *self.potential_arguments) if a.kind == "node"}
        return lines + [f"s_{name} = {entry(array, 0)}" for name, array in fields.items()]

    def new_states(self, entry: Callable[[str, int], str]) -> list[str]:
        """Lines that store new states."""
        lines = []
        for field in self.state:
            name, d = field.name, self.dimension
            if field.shape == "tensor":
                lines += [f"{entry(f'new_{name}', a * d + b)} = next_{name}[{a}][{b}]"
                          for a in range(d) for b in range(d)]  # fmt: skip
            else:
                lines.append(f"{entry(f'new_{name}', 0)} = next_{name}")
        return lines


def packed(d: int, a: int, b: int) -> int:
    """Number of an entry of a symmetric tensor of dimension d: the diagonal first, then 01, 02, 12."""
    return a if a == b else d + a + b - 1


def entries(d: int) -> int:
    """How many entries a symmetric tensor has."""
    return d * (d + 1) // 2


def gradient(d: int, pattern: str, across: str, case: str = "stress") -> str:
    """Source of F as 3 x 3 tuple from the entries of H (d x d) and the stretch across."""

    def one(a: int, b: int) -> str:
        if a < d and b < d:
            return ("REAL(1.0) + " if a == b else "") + pattern.format(a=a, b=b)
        return "REAL(0.0)" if a != b else across if d < 3 else "REAL(1.0)"

    return f"({', '.join('(' + ', '.join(one(a, b) for b in range(3)) + ')' for a in range(3))})"


def deviatoric(d: int, entries: list[str]) -> str:
    """Source of a 3 x 3 tuple from d x d entries: what is missing on the diagonal makes the trace vanish."""
    missing = {1: f"REAL(-0.5) * {entries[0]}", 2: f"-({entries[0]} + {entries[-1]})", 3: ""}[d]

    def one(a: int, b: int) -> str:
        if a < d and b < d:
            return entries[a * d + b]
        return missing if a == b else "REAL(0.0)"

    return f"({', '.join('(' + ', '.join(one(a, b) for b in range(3)) + ')' for a in range(3))})"


def inverse_of_shape(d: int, k: str) -> list[str]:
    """Lines that invert K, entries k0, k1, ... as packed, to i0, i1, ...; zeros, and `singular`, if there is none."""
    e = [k.format(n=n) for n in range(entries(d))]
    if d == 1:
        lines, cofactors = [f"determinant = {e[0]}", f"mean = {e[0]}", "scale = REAL(1.0)"], ["REAL(1.0)"]
    elif d == 2:
        lines = [f"determinant = {e[0]} * {e[1]} - {e[2]} * {e[2]}", f"mean = REAL(0.5) * ({e[0]} + {e[1]})",
                 "scale = mean * mean"]  # fmt: skip
        cofactors = [e[1], e[0], f"-{e[2]}"]
    else:
        xx, yy, zz, xy, xz, yz = e
        cofactors = [f"{yy} * {zz} - {yz} * {yz}", f"{xx} * {zz} - {xz} * {xz}", f"{xx} * {yy} - {xy} * {xy}",
                     f"{xz} * {yz} - {xy} * {zz}", f"{xy} * {yz} - {xz} * {yy}",
                     f"{xy} * {xz} - {yz} * {xx}"]  # fmt: skip
        lines = [f"determinant = {xx} * ({cofactors[0]}) + {xy} * ({cofactors[3]}) + {xz} * ({cofactors[4]})",
                 f"mean = ({xx} + {yy} + {zz}) / REAL(3.0)", "scale = mean * mean * mean"]  # fmt: skip
    lines += [f"singular = not (determinant > REAL({SINGULAR[d]}) * scale)",
              "inverted = REAL(0.0) if singular else REAL(1.0) / determinant"]  # fmt: skip
    return lines + [f"i{n} = inverted * ({cofactor})" for n, cofactor in enumerate(cofactors)]


def _strict(function: Any) -> Any:
    from numba import njit

    return njit(**STRICTLY)(compilable(function))
