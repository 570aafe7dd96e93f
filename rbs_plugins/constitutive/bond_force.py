"""BondForce: what forces on bonds do in a run, whatever their law: loops, held damage, energies, tangents."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Part, Relation, Trigger, always
from rbs_core.part import Connection
from rbs_core.relation import Key
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bonded import BondLoops, BondRelation, starts_of, unbreaking
from rbs_plugins.constitutive.record import check_record
from rbs_plugins.fields import dissipation_density, force_density
from rbs_plugins.loops import BATCH_BELOW
from rbs_plugins.loops.joint import JointLoops
from rbs_plugins.loops.lattice import LatticeLoops
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.tangents import Tangent
from rbs_plugins.tangents.pairwise import SpringTangent


class BondForce(BondRelation):
    """Force densities from bonds, by a recipe that subclasses write.

    Args:
        host: connected part, or connection.
        linear: small displacements, see PairwiseForce.
        active: whether nodes that nothing has reached are skipped, see PairwiseForce.
        when: trigger.

    Attributes:
        hold: while True, forces are found as ever and no bond breaks, however far it is stretched. For relations that
            try displacements and take them back, as statics do.
    """

    def __init__(
        self, host: Part | Connection, *, linear: bool = False, active: bool | None = None, when: Trigger = always
    ) -> None:
        super().__init__(host, when=when)
        self.linear, self.hold = linear, False
        self._active = active
        self._warned = False  # of a step that is too large for new bonds
        self._called = False  # whether the loops hold the positions of an earlier force
        self._now = [0.0, 0.0]  # time and dt of the last force

    def recipe(self) -> Recipe:
        """What the loops compute."""
        raise NotImplementedError

    @property
    def recording(self) -> bool:
        """True if somebody wants to know the energy of the bonds that fail here."""
        return False

    def attach(self) -> None:
        check_record(self, [each for each in self._scene if isinstance(each, BondForce)])
        # made for the bonds that there are, when somebody asks
        self._energies: BondLoops | None = None
        self._held: BondLoops | None = None
        recipe = self.recipe()
        last = getattr(self, "_loops", None)
        felt = {"out": force_density, **({"dissipation": dissipation_density} if recipe.dissipation else {})}
        self._loops = self.make_loops(recipe, felt, self._active)
        if self._called and last is not None and last.position.shape == self._loops.position.shape:
            self._loops.position[...] = last.position  # a run that goes on in the same process

    def held_loops(self) -> BondLoops:
        """The loops of the force in which no bond fails, for the bonds that hold at present."""
        if self._held is None:
            recipe = self.recipe()
            if recipe.criterion is None:
                self._held = self._loops
            else:
                self._held = self.make_loops(unbreaking(recipe), {"out": force_density}, self._active)
        if isinstance(self._held, LatticeLoops) and self._held is not self._loops:
            self._held.begin()
        return self._held

    def tangent(self) -> Tangent:
        """How the forces resist a change of the present displacement; asked for after `attach`."""
        return SpringTangent(self)

    @property
    def follows_potential(self) -> bool:
        """True if both ends of every bond are pulled alike: then the tangent is symmetric."""
        return self.host.both if isinstance(self.host, Connection) else True

    @property
    def proportional(self) -> bool:
        """True if the law is known to be linear in the extensions."""
        return False

    def reset(self) -> None:
        self._called = False

    def begin(self, clock: Clock) -> None:
        self._loops.begin()
        if not self._called:
            self._loops.start()

    def state(self) -> dict[str, Any]:
        """The positions of the last force, where the energy of failing bonds is recorded from them."""
        return {"position": self._loops.position} if self._called and self.recording else {}

    def restore(self, state: dict[str, Any]) -> None:
        if "position" in state:
            self._loops.position[...] = state["position"]
            self._called = True

    def apply(self, clock: Clock) -> None:
        if self.outdated_bonds:
            self.attach()
            self._warn_of_step(clock)
        self._now = [clock.time, clock.dt]
        self._called |= not self.hold
        loops = self.held_loops() if self.hold else self._loops
        if not loops.add(clock.time, clock.dt, bool(self.starts)):
            raise self.blame()

    def _warn_of_step(self, clock: Clock) -> None:
        """Says once if bonds that were found during the run are too stiff for its step."""
        highest = max((float(each.max(initial=0.0)) for each in self.squared_frequencies().values()), default=0.0)
        if highest * clock.dt**2 > 4.0 and not self._warned:
            self._warned = True
            warnings.warn(
                f"{self.label}: the bonds found at step {clock.step} allow a time step of {2.0 / highest**0.5:.3g} s, "
                f"and it is {clock.dt:.3g} s: the run will blow up; give dt",
                stacklevel=2,
            )

    def can_start(self, key: Key) -> bool:
        return isinstance(self._loops, LatticeLoops)

    def batch_key(self) -> Hashable:
        small = len(self.host) < BATCH_BELOW and not self.host.searched_again
        return (type(self._loops), self._loops.kind) if small and not self.recording else None

    def batch(self, relations: Sequence[Relation]) -> Callable[[Clock], None]:
        forces = [each for each in relations if isinstance(each, BondForce)]
        every: Any = [each._loops for each in forces]
        merged = self._loops.merged(every)

        now = [0.0, 0.0]  # one for all
        start = starts_of(forces)
        for force in forces:
            force._called, force._now = True, now

        def apply(clock: Clock) -> None:
            now[:] = clock.time, clock.dt
            if not merged.add(clock.time, clock.dt, start):
                wrong = [each for each in forces if each.forces_are_finite() is not None]
                raise (wrong or forces)[0].blame()

        return apply

    def compile_energy(self, out: NDArray[np.float64]) -> None:
        """Makes `energy` ready; called after `attach` by whoever will ask for energies.

        Raises:
            BadInput: if this relation is not part of the scene.
        """
        if not hasattr(self, "_loops"):
            raise BadInput(f"{self.label} is asked for its energy and is not in the list of relations: list it")
        self._loops_of_energy().prepare_energy(out)

    def _loops_of_energy(self) -> BondLoops:
        if self._energies is None:
            self._energies = self.energy_loops()
        return self._energies

    @property
    def now(self) -> tuple[float, float]:
        """Time and dt of the last force, s."""
        return self._now[0], self._now[1]

    def energy_loops(self) -> BondLoops:
        """The loops that energies are asked from."""
        return self._loops

    def energy(self, out: NDArray[np.float64], part: Part | None = None) -> None:
        """Adds the strain energy density (J/m^3) of the present displacement to `out` (n,), of the nodes of a part."""
        time, dt = self._now
        loops = self._loops_of_energy()
        if isinstance(loops, JointLoops):
            loops.energy(out, time, dt, self.ends.index(part or self.part))
        else:
            loops.energy(out, time, dt)

    def stiffness_bounds(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the stiffness at each node, N/m^4: 2 Σ |df/ds| β V / |ξ| at rest (Gershgorin).

        For f = c s the step that follows from it, 2 / sqrt(max / ρ), is sqrt(2ρ / Σ cV/|ξ|) of Silling & Askari (2005).
        """
        found = {}
        for number, end in enumerate(self.ends):
            out = np.zeros(len(end))
            if isinstance(self._loops, JointLoops):
                self._loops.stiffness(out, number)
            else:
                self._loops.stiffness(out)
            found[end] = 2.0 * out
        return found

    @property
    def nbytes(self) -> int:
        """Positions of the last forces, as the loops want them."""
        return self._loops.nbytes if hasattr(self, "_loops") else 0

    def items(self) -> int:
        return len(self.host.bonds)

    def visited(self) -> int:
        return self._loops.visited
