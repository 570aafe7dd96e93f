"""What relations on bonds have in common: where the bonds are, which loops fit them, and what the loops take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Constitutive, Field, NotFinite, Part, Relation, Trigger, always
from rbs_core.honesty import not_finite
from rbs_core.part import Connection, Host, Lattice
from rbs_core.relation import Fields
from rbs_plugins.fields import density, displacement, force_density, intact, reference_position, volume
from rbs_plugins.loops import machine, roots, surface
from rbs_plugins.loops.joint import JointLoops
from rbs_plugins.loops.lattice import LatticeLoops
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.loops.rows import RowLoops

Arrays = Sequence[NDArray[Any]]
BondLoops = RowLoops | LatticeLoops | JointLoops


def unbreaking(recipe: Recipe, **changes: Any) -> Recipe:
    """A recipe for other sums over the same bonds, in which nothing fails."""
    return replace(
        recipe, criterion=None, criterion_arguments=(), potential=None, potential_arguments=(), freed=None,
        breakable=False, dissipation=False, late=False, **changes,
    )  # fmt: skip


def require_bonds(name: str, host: Host) -> None:
    """Raises BadInput if a part is not connected."""
    if isinstance(host, Host) and not host.connected:
        raise BadInput(f"{name} '{host.name}': the part has no bonds: call part.connect(horizon=...) first")


def precision_of(part: Part) -> type[np.floating[Any]]:
    """Type of the numbers in the fields of a part."""
    return np.float32 if part.precision == "single" else np.float64


def starts_of(relations: Sequence[Relation]) -> Any:
    """Which of the relations that are done together set their sum instead of adding to it; False if none does."""
    starts = np.array([bool(each.starts) for each in relations])
    return starts if starts.any() else False


def per_density(bounds: Mapping[Part, NDArray[np.float64]]) -> dict[Part, NDArray[np.float64]]:
    """Bounds of the stiffness, N/m^4, over the density, 1/s^2; parts without a density are left out."""
    return {part: bound / part[density] for part, bound in bounds.items() if density in part}


class BondRelation(Constitutive):
    """A constitutive relation on the bonds of a part, or on those of a connection.

    Args:
        host: connected part, or connection.
        when: trigger.

    Attributes:
        host: as given.
        ends: the parts whose nodes the bonds belong to, one or two.

    Raises:
        BadInput: if the part is not connected.
    """

    def __init__(self, host: Part | Connection, *, when: Trigger = always) -> None:
        super().__init__(host.ends[0] if isinstance(host, Connection) else host, when=when)
        require_bonds(type(self).__name__, host)
        self.host = host
        self.ends: tuple[Part, ...] = host.ends if isinstance(host, Connection) else (host,)
        self.connections = (host,) if isinstance(host, Connection) else ()
        self._bound: object = None  # the bonds that the loops were made for

    @property
    def label(self) -> str:
        return f"{type(self).__name__} '{self.host.name}'"

    def __repr__(self) -> str:
        own, name = super().__repr__(), type(self).__name__
        return own.replace(f"{name}({self.part.name}", f"{name}({self.host.name}", 1)

    # -- keys of a contract -----------------------------------------------------------------------------------------

    def at_nodes(self, *fields: Field) -> Fields:
        """Fields at the nodes of all ends, as a contract names them."""
        return fields if isinstance(self.host, Part) else tuple((end, field) for end in self.ends for field in fields)

    def at_bonds(self, *fields: Field) -> Fields:
        """Fields at the bonds, as a contract names them."""
        return fields if isinstance(self.host, Part) else tuple((self.host, field) for field in fields)

    def asked(self, *fields: Field) -> Fields:
        """Fields at nodes or bonds, as a contract names them."""
        return tuple(key for each in fields for key in (self.at_bonds if each.at == "bond" else self.at_nodes)(each))

    def is_changed(self, field: Field) -> bool:
        """True if some relation of the scene changes it, at any end."""
        hosts: tuple[Host, ...] = (self.host,) if field.at == "bond" else self.ends
        return any((host, field) in (self._changed or ()) for host in hosts)

    @property
    def may_have_broken(self) -> bool:
        """True if bonds are broken, or may be broken by some relation of the scene."""
        return self.is_changed(intact) or self.host.bonds.has_broken

    def uniform(self, field: Field) -> float | None:
        """The one value of a scalar field at nodes that is equal at all ends and never changes, or None."""
        values = {self.constant((end, field)) for end in self.ends}
        return values.pop() if len(values) == 1 else None

    def end_factors(self) -> NDArray[np.float64]:
        """(n, q) what the ends of bonds contribute to their factor, for recipes with a surface correction."""
        raise NotImplementedError

    # -- stiffness --------------------------------------------------------------------------------------------------

    def stiffness_bounds(self) -> dict[Part, NDArray[np.float64]]:
        """(n,) bound of the stiffness at each node of every part it acts on, N/m^4: what ω² is for a density of 1.

        No row of ∂(force density)/∂u has a larger sum of (norms of) entries. Called after `attach`.
        """
        return {}

    def squared_frequencies(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the squared angular frequency at each node, 1/s^2, of the parts that have a density."""
        return per_density(self.stiffness_bounds())

    def squared_frequency(self) -> NDArray[np.float64] | None:
        return self.squared_frequencies().get(self.part)

    # -- loops ------------------------------------------------------------------------------------------------------

    def processor(self) -> dict[str, Any]:
        """What of a recipe depends on the machine, on how bonds are stored and in which precision."""
        lattice = self.host.bonds.storage == "lattice"
        real = np.dtype(precision_of(self.part)).name if lattice else "float64"
        # lists wait for gathers, and divide meanwhile
        way = roots.way(real) if lattice else "hardware"
        return {"roots": way, "processor": machine.processor(), "real": real, "dimension": self.host.dimension}

    def present(self) -> tuple[Callable[[float, float], None], dict[Field, Arrays]]:
        """For loops of the present displacement: what to call with time and dt first, arrays in place of fields."""
        return lambda time, dt: None, {}

    def make_loops(
        self,
        recipe: Recipe,
        felt: Mapping[str, Field | Arrays],
        active: bool | None = None,
        instead: Mapping[Field, Arrays] | None = None,
    ) -> BondLoops:
        """The loops of a recipe for bonds as they are stored.

        Args:
            recipe: what is computed.
            felt: fields at nodes to which the loops add, or an array for each end, by the names of the loops; "out" is
                the first of them.
            active: as the user has chosen.
            instead: arrays, one for each end, that the loops get in place of those of a field; also of the
                displacement, and of the volume where a recipe is not uniform.

        Raises:
            BadInput: if nodes shall be skipped that cannot be.
        """
        self._bound = self.host.version
        stored = self.host.bonds.stored
        why = recipe.why_never_quiet(stored.lengths) if isinstance(stored, Lattice) else "the bonds are stored as list"
        if active and why is not None:
            raise BadInput(f"{self.label}: active=True skips nodes that nothing has reached, but {why}: leave it out")
        other = instead or {}
        at_nodes: dict[str, Field | Arrays] = {
            "displacement": other.get(displacement, displacement), "reference_position": reference_position, **felt
        }  # fmt: skip
        others: dict[str, Any] = {"cell": 1.0}
        if recipe.uniform:
            others["cell"] = self.uniform(volume)
        else:
            at_nodes["volume"] = other.get(volume, volume)
        for field in recipe.bond_fields:
            others[field.name] = self.raw(self.at_bonds(field)[0])
        for argument in recipe.arguments:
            if argument.kind == "parameter":
                others[f"p_{argument.name}"] = argument.value
            elif argument.field is not None and argument.field.at == "bond":
                others[argument.array] = self.raw(self.at_bonds(argument.field)[0])
            elif argument.field is not None:
                at_nodes[argument.array] = other.get(argument.field, argument.field)
        arrays = {name: self._arrays(given) for name, given in at_nodes.items()}
        changing = [name for name, given in at_nodes.items() if name not in felt and self._may_change(given)]
        if isinstance(self.host, Connection):
            return JointLoops(recipe, self.host, arrays, others, changing)
        inputs = {**{name: array[0] for name, array in arrays.items()}, **others}
        if recipe.surface:
            inputs |= surface.inputs(recipe, stored, self.end_factors())
        if isinstance(stored, Lattice):
            return LatticeLoops(recipe, self.host, inputs, why is None and active is not False, changing)
        return RowLoops(recipe, self.host, inputs)

    def _arrays(self, given: Field | Arrays) -> Arrays:
        """For each end the array of a field, or what is given instead."""
        return [self[end, given] for end in self.ends] if isinstance(given, Field) else given

    def _may_change(self, given: Field | Arrays) -> bool:
        return self.is_changed(given) if isinstance(given, Field) else True

    @property
    def outdated_bonds(self) -> bool:
        """True if the bonds have been searched again since the loops were made."""
        return self._bound != self.host.version

    def forces_are_finite(self) -> tuple[Part, Field, NDArray[Any]] | None:
        """The part, field and array that are not finite: displacement if it is the cause, otherwise the force."""
        for field in (displacement, force_density):
            for end in self.ends:
                if not np.isfinite(self[end, field]).all():
                    return end, field, self[end, field]
        return None

    def blame(self) -> NotFinite:
        """The error that names what is not finite."""
        found = self.forces_are_finite()
        if found is not None:
            part, field, array = found
            return not_finite(part, field.name, array)
        return NotFinite(f"the forces of '{self.host.name}' overflow: look at the loads and the time step")
