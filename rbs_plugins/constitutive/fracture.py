"""Failure of bonds: criteria are plain functions that are true when the bond fails; Damage is what remains visible."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Connection, Field, Geometry, Measure, Part, Relation, Trigger, always
from rbs_core.part import Host
from rbs_core.relation import Fields
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bonded import require_bonds
from rbs_plugins.constitutive.strength import GRADED, is_graded, set_limits
from rbs_plugins.fields import breakable, critical_stretch, damage, intact, volume
from rbs_plugins.loops.damage import JointDamage, JointShare, damage_loops, family_volumes

if TYPE_CHECKING:
    from rbs_plugins.constitutive.pairwise import PairwiseForce


def beyond_tension(stretch, s0):
    """True if stretched beyond s0."""
    return stretch > s0


def beyond_compression(stretch, s0):
    """True if shortened beyond s0."""
    return stretch < -s0


def beyond_both(stretch, s0, s0_compression):
    """True if stretched beyond s0 or shortened beyond s0_compression."""
    return (stretch > s0) | (stretch < -s0_compression)


class Criterion:
    """When bonds fail: a plain function of what laws may ask for, true when the bond breaks for good.

    Args:
        function: e.g. `def fails(stretch, s0): return stretch > s0`. Both ends of a bond ask it, so it must give the
            same answer from either end.
        within: only bonds with both ends in this geometry, or in the node set of this name, may break; all if it is
            not given.
        release: "at once" (a failing bond carries no force any more) or "next step" (it carries its force until the end
            of the step in which it fails, as in programs that test for failure behind the sum of forces; that costs
            more energy, in proportion to the time step).
        **parameters: numbers that the function asks for.

    Raises:
        BadInput: if `within` is no geometry and no name, or on an unknown release; where the force is made, if the part
            has no such node set (with the nearest names).
    """

    RELEASES = ("at once", "next step")
    scales: tuple[str, ...] = ()  # positive fields of nodes without which it says no at rest, whatever their values

    def __init__(
        self,
        function: Callable[..., Any],
        *,
        within: Geometry | str | None = None,
        release: str = "at once",
        **parameters: float,
    ) -> None:
        if within is not None and not isinstance(within, Geometry | str):
            text = f"{type(self).__name__}: within={within!r} must be a geometry such as Box, or the name of a node set"
            raise BadInput(text)
        if release not in self.RELEASES:
            raise BadInput(f"{type(self).__name__}: release={release!r} must be one of {', '.join(self.RELEASES)}")
        self.function, self.within, self.release, self._parameters = function, within, release, parameters

    def parameters(self, force: PairwiseForce) -> dict[str, float]:
        """The numbers of the function, for the force that it belongs to."""
        return dict(self._parameters)

    def function_for(self, force: PairwiseForce) -> Callable[..., Any]:
        """The function, for the force that it belongs to."""
        return self.function

    def feeders(self, force: PairwiseForce) -> tuple[Relation, ...]:
        """Relations that must run in front of that force, because the function asks for what they compute."""
        return ()

    def mark(self, force: PairwiseForce) -> None:
        """Says which bonds of a force may break; does nothing without `within`."""
        if self.within is None:
            return
        part = force.host
        before = part.raw(breakable).copy() if breakable in part else None
        part.bonds.mark(breakable, self._region(part, self.within))
        if before is not None and not np.array_equal(part.raw(breakable), before):
            part.raw(breakable)[...] = before
            raise BadInput(f"part '{part.name}' has two criteria with different regions (within=): use one region")

    def _region(self, part: Host, within: Geometry | str) -> Any:
        """The geometry, or the mask of the node set of a name."""
        if isinstance(within, Geometry):
            return within
        if not isinstance(part, Part):
            raise BadInput(f"{self!r}: '{part.name}' is a connection, which has no node sets: give a geometry")
        inside = np.zeros(len(part), np.bool_)
        inside[part.where(within)] = True
        part.bonds.fields.given.add(breakable)  # a name does not tell which nodes those are, for checkpoints
        return inside

    def __repr__(self) -> str:
        given = "".join(f", {name}={value!r}" for name, value in self._parameters.items())
        return f"{type(self).__name__}({self.function.__name__}{given}{self._options})"

    @property
    def _options(self) -> str:
        region = "" if self.within is None else f", within={self.within!r}"
        return region if self.release == "at once" else f"{region}, release={self.release!r}"


class CriticalStretch(Criterion):
    """A bond fails once it is stretched (or shortened) beyond a limit (Silling & Askari 2005).

    Args:
        s0: critical stretch; or give the fracture energy instead. A number, or a limit for each node: an array (n,), a
            function of the positions (n, d) such as Weibull, or the field critical_stretch, which the script sets.
        fracture_energy: G0, J/m^2; the stretch follows from it and the constants of the force that this belongs to. A
            number, an array or a function.
        mode: "tension", "compression" or "both".
        compression: critical shortening for "both", positive; as s0 if not given.
        within: only bonds with both ends in this geometry, or in the node set of this name, may break.
        release: "at once" or "next step", see Criterion.
        rule: limit of a bond between nodes that differ: the "mean" of both, or the "minimum", the weaker one.

    Raises:
        BadInput: unless exactly one of s0 and fracture_energy is given and positive, on an unknown mode or rule, or on
            a limit of its own for compression where limits differ from node to node.
    """

    MODES: ClassVar[dict[str, Callable[..., Any]]] = {
        "tension": beyond_tension,
        "compression": beyond_compression,
        "both": beyond_both,
    }

    def __init__(
        self,
        s0: Any = None,
        *,
        fracture_energy: Any = None,
        mode: str = "tension",
        compression: float | None = None,
        within: Geometry | str | None = None,
        release: str = "at once",
        rule: str = "mean",
    ) -> None:
        if rule not in GRADED:
            raise BadInput(f"CriticalStretch: rule={rule!r} must be one of {', '.join(GRADED)}")
        if mode not in self.MODES:
            raise BadInput(f"CriticalStretch: mode={mode!r} must be one of {', '.join(self.MODES)}")
        if (s0 is None) == (fracture_energy is None):
            raise BadInput("CriticalStretch: give either the stretch s0 or the fracture_energy, not both or none")
        if compression is not None and mode != "both":
            raise BadInput(f"CriticalStretch: compression= belongs to mode='both', not to mode={mode!r}")
        self.graded = is_graded(s0) or is_graded(fracture_energy)
        if self.graded and compression is not None:
            raise BadInput("CriticalStretch: where limits differ from node to node, compression= has none of its own")
        for name, value in (("s0", s0), ("fracture_energy", fracture_energy), ("compression", compression)):
            if value is not None and not self.graded and not (np.isfinite(value) and value > 0):
                raise BadInput(f"CriticalStretch: {name}={value} must be positive and finite")
        super().__init__(GRADED[rule][mode] if self.graded else self.MODES[mode], within=within, release=release)
        self.s0, self.fracture_energy, self.mode, self.compression = s0, fracture_energy, mode, compression
        self.rule, self.scales = rule, (critical_stretch.name,) if self.graded else ()

    def mark(self, force: PairwiseForce) -> None:
        """Says which bonds may break, and sets the limits of nodes that differ."""
        super().mark(force)
        if self.graded:
            energy = self.s0 is None
            set_limits(force, self.fracture_energy if energy else self.s0, energy)

    def parameters(self, force: PairwiseForce) -> dict[str, float]:
        if self.graded:
            return {}
        s0 = self.s0
        if s0 is None:
            assert self.fracture_energy is not None
            s0 = force.critical_stretch(self.fracture_energy)
        if self.mode != "both":
            return {"s0": s0}
        return {"s0": s0, "s0_compression": s0 if self.compression is None else self.compression}

    def limits(self, force: PairwiseForce, i: NDArray[Any], j: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Critical stretch of bonds in tension and in compression, (m,) each; infinite where they cannot fail.

        Args:
            force: whose bonds they are.
            i: (m,) numbers of their starts among the nodes of the host.
            j: (m,) those of their ends.
        """
        shape, endless = i.shape, np.full(i.shape, np.inf)
        if self.graded:
            hosts: Any = force.host.nodes if isinstance(force.host, Connection) else (slice(None),)
            at = np.concatenate([end[critical_stretch][n] for end, n in zip(force.ends, hosts, strict=True)])
            limit = np.minimum(at[i], at[j]) if self.rule == "minimum" else 0.5 * (at[i] + at[j])
            both = (limit, limit)
        else:
            given = self.parameters(force)
            both = (np.full(shape, given["s0"]), np.full(shape, given.get("s0_compression", given["s0"])))
        tension = both[0] if self.mode != "compression" else endless
        compression = both[1] if self.mode != "tension" else endless
        if self.within is None:
            return tension, compression
        may = force.host.raw(breakable) != 0
        return np.where(may, tension, np.inf), np.where(may, compression, np.inf)

    def __repr__(self) -> str:
        limit = _short(self.s0) if self.s0 is not None else f"fracture_energy={_short(self.fracture_energy)}"
        more = "" if self.compression is None else f", compression={self.compression!r}"
        more += f", rule={self.rule!r}" if self.graded else ""
        return f"CriticalStretch({limit}, mode={self.mode!r}{more}{self._options})"


def _short(limit: Any) -> str:
    """A limit in a few words; arrays are told apart by the fields that they set."""
    if isinstance(limit, Field):
        return limit.name
    return f"<array {np.shape(limit)}>" if np.ndim(limit) else getattr(limit, "__name__", repr(limit))


class Damage(Measure):
    """Broken share of each family by volume: φ = 1 − Σ μV / ΣV (Silling & Askari 2005).

    Args:
        part: connected part.
        connections: of this part, whose bonds count, too; those that are searched again cannot.
        when: trigger.

    Raises:
        BadInput: on a connection of other parts, or at the start of a run on one that is searched again.

    Bonds that a pre-crack has cut count as broken; removed ones (`bonds.remove`) never were. A node without bonds has
    damage 0.
    """

    example = {}
    writes = (damage,)
    storages = ("list", "lattice")

    def __init__(self, part: Part, connections: Sequence[Connection] = (), *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        require_bonds(type(self).__name__, part)
        self.connections = (connections,) if isinstance(connections, Connection) else tuple(connections)
        for each in self.connections:
            if not isinstance(each, Connection) or part not in each.ends:
                raise BadInput(f"{self.label}: {each!r} is no connection of this part")

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """The state of all bonds, and the volumes at their ends."""
        ends = [(end, volume) for each in self.connections for end in each.ends]
        return tuple(dict.fromkeys([intact, (self.part, volume), *((c, intact) for c in self.connections), *ends]))

    def attach(self) -> None:
        for each in self.connections:
            if each.searched_again:
                raise BadInput(f"{self.label}: the bonds of '{each.name}' are searched again: leave it out")
        stored = self.part.bonds.stored
        self._loops, self._kept = damage_loops(stored, self.raw(intact), self[volume], self[damage])
        if self.connections:
            shares = [JointShare(each, self.part, self.raw((each, intact))) for each in self.connections]
            self._joint = JointDamage(family_volumes(stored, self[volume]), shares)

    def apply(self, clock: Clock) -> None:
        for loop in self._loops:
            loop()
        if self.connections:
            self._joint.add(self[damage])

    @property
    def nbytes(self) -> int:
        """Volumes in the order in which the loops want them."""
        return getattr(self, "_kept", 0)

    def items(self) -> int:
        return len(self.part.bonds)
