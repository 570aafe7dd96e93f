"""Dilatation: how much the family of a node has grown, the sum that the ordinary state-based solid is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

from rbs_core import BadInput, Part, Relation, Trigger, always
from rbs_core.part import Connection
from rbs_core.relation import Fields, Key
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bonded import BondRelation, precision_of, starts_of
from rbs_plugins.constitutive.corrections import set_partial_volume
from rbs_plugins.constitutive.influence import Influence, influence_at, set_influence
from rbs_plugins.fields import (
    dilatation,
    displacement,
    intact,
    inverse_weighted_volume,
    reference_position,
    volume,
    volume_fraction,
)
from rbs_plugins.loops import BATCH_BELOW
from rbs_plugins.loops.arguments import fields, resolve
from rbs_plugins.loops.lattice import LatticeLoops
from rbs_plugins.loops.recipe import Recipe

WEIGHTED_VOLUMES = ("initial", "intact", "full")


def growth(extension, reference_length, influence, inverse_weighted_volume_i, dimension):
    """What a bond adds to the dilatation of its node: d ω |ξ| e / m."""
    return dimension * influence * reference_length * extension * inverse_weighted_volume_i


def weight(reference_length, influence):
    """What a bond adds to the weighted volume of its node: ω |ξ|²."""
    return influence * reference_length * reference_length


class Dilatation(BondRelation):
    """Dilatation of each family: ϑ_i = d/m_i Σ_j μ β ω |ξ| e V_j, e of a bond its extension, m_i = Σ_j β ω |ξ|² V_j.

    Args:
        part: connected part, or a connection: its bonds count for the nodes of both parts.
        influence: ω of |ξ| and δ: a plain function, or the name of one in `rbs_plugins.constitutive.influence`.
        weighted_volume: m over the bonds that were there at the "initial" state, cut ones among them; over those that
            are "intact", found anew when bonds break; or of the "full" family, the integral over the whole ball.
        partial_volume: as of PairwiseForce.
        linear: small displacements, see PairwiseForce.
        within: the dilatations of the two parts, for a connection.
        when: trigger.

    Raises:
        BadInput: on an unknown rule, an influence that is negative or not finite, or a connection without `within`.
        BadLaw: if the influence function takes other arguments.

    In a uniform deformation of small strain ϑ is the trace of the strain; of a 2-D part that of the strain in the plane
    (in plane stress the volume changes by (1 − 2ν)/(1 − ν) of it). In 3-D it is θ of Silling et al. (2007), eq. 62.
    """

    role = "measure"
    example = {}
    storages = ("list", "lattice")

    def __init__(
        self,
        part: Part | Connection,
        influence: Influence | str = "constant",
        *,
        weighted_volume: str = "initial",
        partial_volume: str = "none",
        linear: bool = False,
        within: Sequence[Dilatation] = (),
        when: Trigger = always,
    ) -> None:
        super().__init__(part, when=when)
        if weighted_volume not in WEIGHTED_VOLUMES:
            known = ", ".join(WEIGHTED_VOLUMES)
            raise BadInput(f"{self.label}: weighted_volume={weighted_volume!r} must be one of {known}")
        self.influence, self.rule, self._linear = influence, weighted_volume, linear
        self.adds = self.at_nodes(dilatation)
        self._fraction = set_partial_volume(part, partial_volume)
        self.given = set_influence(part, influence, self.label)
        self._arguments = tuple(resolve(growth, part, {"dimension": float(part.dimension), **self.given}))
        self._weights = tuple(resolve(weight, part, self.given))
        self._links: list[Dilatation] = []
        for each in self._check_within(within):
            each.link(self)
        if isinstance(part, Part) and inverse_weighted_volume not in part:
            part[inverse_weighted_volume] = 0.0  # until a run begins: then bonds and volumes are what they are
        self._holding = 0  # tells whether bonds have broken since the last look

    def _check_within(self, within: Sequence[Dilatation]) -> list[Dilatation]:
        if isinstance(self.host, Part):
            return []
        found = [each for end in self.ends for each in within if each.host is end]
        if len(found) != len(self.ends):
            raise BadInput(
                f"{self.label}: families reach across the connection: give within=, the dilatations of "
                f"{' and '.join(repr(end.name) for end in self.ends)}"
            )
        if any((each.influence, each.rule) != (self.influence, self.rule) for each in found):
            raise BadInput(f"{self.label}: influence and weighted_volume must be those of its parts")
        return found

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Displacement, nodes and bonds."""
        more = [*([volume_fraction] if self._fraction else []), *([intact] if self.may_have_broken else [])]
        asked = [each for each in fields([*self._arguments, *self._weights]) if each is not inverse_weighted_volume]
        own = [] if self.rule == "intact" and isinstance(self.host, Part) else [inverse_weighted_volume]
        return self.asked(displacement, reference_position, volume, *more, *asked, *own)

    @property
    def updates(self) -> Fields:  # type: ignore[override]
        """The weighted volumes, where they follow the bonds."""
        return (inverse_weighted_volume,) if self.rule == "intact" and isinstance(self.host, Part) else ()

    # -- weighted volume --------------------------------------------------------------------------------------------

    def link(self, joint: Dilatation) -> None:
        """Takes a connection of the part into account, in place of an earlier one."""
        self._links = [*(link for link in self._links if link.host is not joint.host), joint]

    def links_among(self, scene: Sequence[Relation]) -> list[Dilatation]:
        """Dilatations of connections that add to that of the part in a scene."""
        return [link for link in self._links if link in scene]

    def weigh(self) -> None:
        """Finds the weighted volumes of the nodes of the part, over its own bonds and those of its connections."""
        if self.rule == "full":
            self._hold(np.full(len(self.part), full_weighted_volume(self)))
        else:
            self._hold(self._shares(self.part) + sum(link._shares(self.part) for link in self._links))

    def _hold(self, m: NDArray[np.float64]) -> None:
        inverse = np.zeros(len(self.part))
        np.divide(1.0, m, out=inverse, where=m > 0)  # a node that has lost all bonds feels nothing
        self.part[inverse_weighted_volume] = inverse

    def _shares(self, part: Part) -> NDArray[np.float64]:
        """What the bonds of the host add to the weighted volumes (n,) of a part, m^5."""
        sums = [np.zeros(len(end), precision_of(end)) for end in self.ends]
        only_intact = self.rule == "intact" and self.host.bonds.has_broken
        still = {displacement: [np.zeros((len(end), end.dimension), precision_of(end)) for end in self.ends]}
        recipe = self._recipe(weight, self._weights, only_intact)
        loops = self.make_loops(recipe, {"out": sums}, active=False, instead=still)
        loops.begin()
        loops.add(0.0, 0.0)
        return sums[self.ends.index(part)].astype(np.float64)

    def _recipe(self, law: Callable[..., Any], arguments: tuple[Any, ...], broken: bool) -> Recipe:
        return Recipe(
            law=law, law_arguments=arguments, sums="total", linear=self._linear, intact=broken, fraction=self._fraction,
            uniform=self.uniform(volume) is not None, scales=("inverse_weighted_volume", "influence"),
            **self.processor(),
        )  # fmt: skip

    # -- sums -------------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        if isinstance(self.host, Part):
            self.weigh()
        self._loops = self.loops({"out": dilatation})

    def loops(self, felt: Any) -> Any:
        """Loops that add the dilatation to a field, or to an array for each end."""
        return self.make_loops(self._recipe(growth, self._arguments, self.may_have_broken), felt)

    def begin(self, clock: Clock) -> None:
        self._loops.begin()

    def apply(self, clock: Clock) -> None:
        if self.outdated_bonds:
            self.attach()
        if self.updates and self._broke():
            self.weigh()
        self._loops.add(clock.time, clock.dt, bool(self.starts))

    def _broke(self) -> bool:
        """True if bonds have broken since somebody asked."""
        hosts = [self.host, *(link.host for link in self._links)]
        # bits are only ever cleared, so that no sum of words comes back
        now = sum(int(host.raw(intact).sum(dtype=np.int64)) for host in hosts if intact in host)
        before, self._holding = self._holding, now
        return now != before

    def can_start(self, key: Key) -> bool:
        return isinstance(self._loops, LatticeLoops)

    def batch_key(self) -> Hashable:
        small = len(self.host) < BATCH_BELOW and not self.updates and not self.host.searched_again
        return ("dilatation", type(self._loops), self._loops.kind) if small else None

    def batch(self, relations: Sequence[Relation]) -> Callable[[Clock], None]:
        every: Any = [each._loops for each in relations if isinstance(each, Dilatation)]
        merged = self._loops.merged(every)
        start = starts_of(relations)

        def apply(clock: Clock) -> None:
            merged.add(clock.time, clock.dt, start)

        return apply

    @property
    def nbytes(self) -> int:
        """What the loops keep."""
        return self._loops.nbytes if hasattr(self, "_loops") else 0

    def items(self) -> int:
        return len(self.host.bonds)

    def visited(self) -> int:
        return self._loops.visited


class PresentDilatation:
    """The dilatation of the present displacement, of all nodes of some parts, beside the field.

    Args:
        scene: relations, the dilatations among them.
        ends: the parts.

    Attributes:
        arrays: for each part (n,), as `refresh` has found them.
    """

    def __init__(self, scene: Sequence[Relation], ends: Sequence[Part]) -> None:
        self._found = [each for each in scene if isinstance(each, Dilatation) and set(each.ends) & set(ends)]
        every = dict.fromkeys([*ends, *(end for each in self._found for end in each.ends)])
        self._buffers = {end: np.zeros(len(end), precision_of(end)) for end in every}
        self.arrays = [self._buffers[end] for end in ends]
        self._loops = [each.loops({"out": [self._buffers[end] for end in each.ends]}) for each in self._found]
        for loops in self._loops:
            loops.begin()

    def refresh(self, time: float, dt: float) -> None:
        """Sums anew."""
        for buffer in self._buffers.values():
            buffer.fill(0.0)
        for each, loops in zip(self._found, self._loops, strict=True):
            if each.may_have_broken:
                loops.begin()
            loops.add(time, dt)


def full_weighted_volume(of: Dilatation) -> float:
    """The m of a whole family: ∫ ω |ξ|² dV over the ball of radius δ (disk × thickness, line × area), m^5."""
    part, horizon = of.part, of.host.bonds.horizon
    around = {1: 2.0 * (part.area or 1.0), 2: 2.0 * math.pi * (part.thickness or 1.0), 3: 4.0 * math.pi}[part.dimension]
    omega = influence_at(of.influence, horizon, part.spacing, of.label)
    moment, _ = quad(lambda r: omega(r) * r ** (part.dimension + 1), 0.0, horizon, limit=200)
    return around * moment
