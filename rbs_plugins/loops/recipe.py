"""What decides the text of bond loops, and what the texts for all representations of bonds have in common.

On a bond, ξ is the reference bond, y the current positions, d = y_j - y_i:
    length = |d|,  stretch = length / |ξ| - 1,  force density_i += law * β * V_j * d / length      (Silling 2000)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rbs_core import Field
from rbs_plugins.fields import bond_energy, bond_extension, bond_force, breakable, intact, volume_fraction
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.pieces import FAILS, indented, quadrature, strict
from rbs_plugins.loops.source import STRICTLY, compilable, definitions, plain

__all__ = ["FAILS", "SLOPE_STEP", "Body", "Recipe", "indented", "kinematic_values", "strict"]

SLOPE_STEP = 1e-6
BINARY_STEP = 2.0**-20  # by which a small stretch changes without a rounding error


def kinematic_values(stretch: float, length: float) -> dict[str, float]:
    """What a law may ask about the deformation of a bond of some reference length."""
    deformed = (1.0 + stretch) * length
    return {"stretch": stretch, "extension": stretch * length, "length": deformed, "reference_length": length}


@dataclass(frozen=True)
class Recipe:
    """Everything that decides the text of the loops.

    Attributes:
        dimension: 1, 2 or 3.
        law, criterion, potential: plain functions; the last two may be None.
        sums: what the loops are for: "force", Σ law β V d/|d|, or "total", Σ law β V of any scalar law; "tensor",
            Σ law β V η⊗ξ (η = d − ξ), or "moment", Σ law β V d/|d|⊗ξ: d × d components, for bonds of one part only;
            "work", no sum: the work of the law on each bond.
        still, scales: names of fields that are zero where nothing has moved yet, and of those that only multiply:
            a law that asks for no others may be zero at rest all the same.
        freed: energy that a failing bond frees, where this is not its potential; asks for what the law asks for.
        slope: d law / d stretch, for tangents, with its own arguments; by differences if there is none.
        law_arguments, criterion_arguments, potential_arguments: resolved, in the order of the functions.
        intact: whether bonds may be broken.
        breakable: whether some bonds may not break.
        fraction: whether neighbors count with a volume fraction.
        surface: how factors of the ends of a bond make one of the bond, see `surface`; "" if there are none.
        uniform: whether all volumes are equal.
        dissipation: whether the energy of breaking bonds is recorded.
        linear: whether displacements are small: extensions η·ξ/|ξ|, forces along the reference bond.
        late: whether a failing bond carries its force for the rest of the step.
        real: type in which a lattice computes, "float64" or "float32"; rows always compute in double precision.
        roots: how inverse lengths are computed, "hardware" or "newton", see `roots`.
        processor: kind of machine that the loops are for, see `machine`.
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
    surface: str = ""
    uniform: bool = True
    dissipation: bool = False
    late: bool = False
    linear: bool = False
    sums: str = "force"
    freed: Callable[..., Any] | None = None
    slope: Callable[..., Any] | None = None
    slope_arguments: tuple[Argument, ...] = ()
    still: tuple[str, ...] = ()
    scales: tuple[str, ...] = ()
    real: str = "float64"
    roots: str = "hardware"
    processor: str = "other"

    @property
    def bare(self) -> Recipe:
        """The same without the values of parameters: recipes that are equal then have the same text."""

        def without(arguments: tuple[Argument, ...]) -> tuple[Argument, ...]:
            return tuple(replace(argument, value=None) for argument in arguments)

        return replace(
            self,
            law_arguments=without(self.law_arguments),
            criterion_arguments=without(self.criterion_arguments),
            potential_arguments=without(self.potential_arguments),
            slope_arguments=without(self.slope_arguments),
        )

    @property
    def laws(self) -> dict[str, Callable[..., Any]]:
        """The functions that there are, by the names that the loops call them by."""
        every = {"law": self.law, "criterion": self.criterion, "potential": self.potential, "freed": self.freed,
                 "slope": self.slope}  # fmt: skip
        return {name: function for name, function in every.items() if function is not None}

    @property
    def arguments(self) -> tuple[Argument, ...]:
        """Arguments of all functions."""
        return (*self.law_arguments, *self.criterion_arguments, *self.potential_arguments, *self.slope_arguments)

    @property
    def bond_fields(self) -> list[Field]:
        """Fields at bonds that the loops take whatever the functions ask for."""
        work = [bond_energy, bond_force, bond_extension] if self.sums == "work" else []
        flags = ((intact, self.intact), (breakable, self.breakable), (volume_fraction, self.fraction))
        return [*work, *(field for field, there in flags if there)]

    @property
    def of_force(self) -> tuple[Argument, ...]:
        """Arguments of the functions that a force needs."""
        return (*self.law_arguments, *self.criterion_arguments, *(self.potential_arguments if self.dissipation else ()))

    @property
    def of_energy(self) -> tuple[Argument, ...]:
        """Arguments of the functions that an energy needs."""
        return (*self.law_arguments, *self.potential_arguments)

    @property
    def newton(self) -> bool:
        """Whether roots are computed by multiplications."""
        return self.roots == "newton"

    def slopes(self, lengths: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """|d law / d stretch| at rest of bonds of these lengths, the steeper side of a kink, without compiling.

        None for a law that asks for more than the deformation of its bond and parameters, or that Python cannot follow.
        """
        if any(argument.kind not in ("kinematic", "parameter") for argument in self.law_arguments):
            return None
        found = {}
        for length in np.unique(lengths).tolist():
            try:
                low, middle, high = (self.force_at(stretch, length) for stretch in (-SLOPE_STEP, 0.0, SLOPE_STEP))
            except Exception:  # whatever a user's function raises: the compiler says it better
                return None
            found[length] = max(abs(high - middle), abs(middle - low)) / SLOPE_STEP
        return np.array([found[length] for length in lengths.tolist()])

    def why_never_quiet(self, lengths: NDArray[np.float64]) -> str | None:
        """Why a bond of one of these lengths may feel something or fail at rest; None if it cannot."""
        functions = {"law": (self.law, self.law_arguments, 0.0)}
        if self.criterion is not None:
            functions["criterion"] = (self.criterion, self.criterion_arguments, False)
        for name, (function, arguments, still) in functions.items():
            fields = self._resting_fields(arguments)
            known = [a.kind in ("kinematic", "parameter") or a.name in fields for a in arguments]
            if not all(known):
                return f"its {name} depends on more than the bond's own deformation"
            for length in np.unique(lengths).tolist():
                at_rest = {**kinematic_values(0.0, length), **fields}
                try:
                    answer = plain(function)(*(at_rest.get(a.name, a.value) for a in arguments))
                except Exception as error:  # whatever a user's function raises
                    return f"its {name} cannot be evaluated at rest ({error})"
                if answer != still:
                    return f"its {name} is {answer} at rest"
        return None

    def _resting_fields(self, arguments: tuple[Argument, ...]) -> dict[str, float]:
        """Values at rest of fields of which that is known: 0 of those that are still, any of those that scale."""
        values = {**dict.fromkeys(self.scales, 1.0), **dict.fromkeys(self.still, 0.0)}
        names = {a.name: a.name[:-2] if a.kind == "node" else a.name for a in arguments if a.field is not None}
        return {name: values[field] for name, field in names.items() if field in values}

    def force_at(self, stretch: float, length: float) -> float:
        """The law for a bond of some reference length, in plain Python."""
        values = kinematic_values(stretch, length)
        return float(plain(self.law)(*(values.get(a.name, a.value) for a in self.law_arguments)))

    def text(self, *loops: str) -> Text:
        """Laws and loops as one module."""
        pieces = definitions(self.laws, single=self.real == "float32")
        names = None if pieces is not None else {name: _strict(function) for name, function in self.laws.items()}
        parts = [
            f"from numba import {self.real} as REAL",
            "from rbs_plugins.loops.bits import fused, root_guess",
            "from rbs_plugins.loops.machine import narrower, no_gathers, widest",
            *(pieces or []),
            *([quadrature(self.law_arguments)] if self.potential is None else []),
            *loops,
        ]
        return Text("\n\n".join(parts) + "\n", names, tuple(self.laws.values()))


def _strict(function: Any) -> Any:
    from numba import njit

    return njit(**STRICTLY)(compilable(function))


class Body(ABC):
    """Pieces of the text of one loop; subclasses say how a representation spells what belongs to a bond.

    Attributes:
        recipe: of the loop.
        used: arguments of the functions in it.
    """

    hints: ClassVar[dict[str, tuple[str, ...]]] = {}  # what functions begin with, by the processor
    size = "reference_length"  # |ξ| of a bond
    inverse = ""  # 1 / |ξ|

    def __init__(self, recipe: Recipe, used: tuple[Argument, ...]) -> None:
        self.recipe, self.used = recipe, used

    @abstractmethod
    def value(self, argument: Argument) -> str:
        """Source of the value of an argument that is a bond field or a node field."""

    @property
    @abstractmethod
    def weight(self) -> str:
        """Volume factor of the neighbor inside the sum, " * ..." or nothing."""

    @property
    def after(self) -> str:
        """Volume factor behind the sum."""
        return " * cell" if self.recipe.uniform else ""

    @property
    def head(self) -> list[str]:
        """Lines with which the functions of loops begin."""
        return list(self.hints.get(self.recipe.processor, ()))

    @property
    def axes(self) -> range:
        """The components."""
        return range(self.recipe.dimension)

    def products(self, pattern: str, other: str | None = None) -> str:
        """The sum over components of the squares of a pattern with {k}, or of its products with another one."""
        factors = [(pattern.format(k=k), (other or pattern).format(k=k)) for k in self.axes]
        total = "{} * {}".format(*factors[0])
        for a, b in factors[1:]:
            total = f"fused({a}, {b}, {total})"
        return total

    def each(self, pattern: str, between: str = ", ") -> str:
        """The pattern once per component, {k} its number."""
        return between.join(pattern.format(k=k) for k in self.axes)

    @property
    def numbers(self) -> list[str]:
        """Parameters of the loop that are numbers."""
        given = dict.fromkeys(f"p_{a.name}" for a in self.used if a.kind == "parameter")
        return [*given, "cell", "time", "dt"]

    def call(self, name: str, arguments: tuple[Argument, ...], **replaced: str) -> str:
        """Source of a call of a law."""
        return f"{name}({', '.join(replaced.get(a.name) or self._value(a) for a in arguments)})"

    def swapped(self, arguments: tuple[Argument, ...]) -> dict[str, str]:
        """Sources for `call` as seen from the other end of a bond; nothing if both see the same."""
        turned = {"_i": "_j", "_j": "_i"}
        each = [a for a in arguments if a.kind == "node"]
        return {a.name: self.value(replace(a, name=a.name[:-2] + turned[a.name[-2:]])) for a in each}

    def _value(self, argument: Argument) -> str:
        if argument.kind == "parameter":
            return f"p_{argument.name}"
        return self.value(argument) if argument.field is not None else argument.name

    def potential(self, **replaced: str) -> str:
        """Source of the energy of a bond."""
        r = self.recipe
        if r.potential is not None:
            return self.call("potential", r.potential_arguments, **replaced)
        passed = [self._value(a) for a in r.law_arguments if a.kind != "kinematic"]
        return f"potential({', '.join([replaced.get('stretch', 'stretch'), self.size, *passed])})"

    @property
    def fails(self) -> str:
        """Source of the question whether a bond fails, if it holds."""
        assert self.recipe.criterion is not None
        return f"fails({self.call('criterion', self.recipe.criterion_arguments)})"

    def record(self) -> list[str]:
        """Energy that goes into a bond that fails now, so that the energy balance of velocity Verlet closes.

        In that scheme a step takes half of the force of its start and half of that of its end. If the bond carries
        nothing at the end, it has taken its potential at the positions before and half of the work of the force of
        then. If it still carries its force (late), it has taken its potential now and will take half of the work of its
        force in the step to come, in which it is taken to lengthen as much as in this one.

        The text expects d and length of now, o, stretch_old and length_old of before, and adds to `lost`.
        """
        late = self.recipe.late
        old = {"stretch": "stretch_old", "length": "length_old", "extension": "stretch_old * reference_length"}
        at, along, size = ({}, "d", "length") if late else (old, "o", "length_old")
        path = self.each(along + "{k} * (d{k} - o{k})", " + ")
        arguments = self.recipe.law_arguments
        if self.recipe.linear:
            path, size = "(stretch - stretch_old) * reference_length", "1.0"
        work = f"work = 0.5 * {self.call('law', arguments, **at)} * ({path}) / {size}"
        freed = self.potential(**at) if self.recipe.freed is None else self.call("freed", arguments, **at)
        return [work, f"lost += 0.5 * ({freed} + work){self.weight}"]

    def law_at(self, stretch: str) -> str:
        """Source of the law at another stretch."""
        other = {"length": "(1.0 + {0}) * reference_length", "stretch": "{0}", "extension": "{0} * reference_length"}
        swapped = {name: formula.format(stretch) for name, formula in other.items()}
        return self.call("law", self.recipe.law_arguments, **swapped)

    def steepness(self) -> list[str]:
        """Sets `steepness`, d law / d stretch now: given, or by central differences."""
        if self.recipe.slope is not None:
            return [f"steepness = {self.call('slope', self.recipe.slope_arguments)}"]
        return [f"above, below = stretch + {BINARY_STEP}, stretch - {BINARY_STEP}",
                f"steepness = ({self.law_at('above')} - {self.law_at('below')}) / (above - below)"]  # fmt: skip

    def slope(self) -> list[str]:
        """Adds |d law / d stretch| / |ξ| β V at rest to `total`; of a kink the steeper side."""
        return [f"middle = {self.law_at('0.0')}", f"up = abs({self.law_at(f'{SLOPE_STEP}')} - middle)",
                f"down = abs(middle - {self.law_at(f'-{SLOPE_STEP}')})",
                f"total += max(up, down) * {self.inverse}{self.weight}"]  # fmt: skip
