"""The force that holds a region in its prescribed motion."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from rbs_core import BadInput, Everywhere, Field, Measure, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.fields import force_density, reaction_force, volume
from rbs_plugins.measures.places import place_for


class ReactionForce(Measure):
    """Force that holds the nodes of a region, R = −Σ (L + b) V, N, in coordinates of the part.

    Args:
        part: the part.
        region: a BoundaryDomain that prescribes a motion, or whatever names nodes: a geometry, mask, indices, node set.
        field: where to write it; another vector field of parts if there are several regions.
        when: trigger.

    Raises:
        BadInput: on a region without nodes, a boundary domain that prescribes a load, or is of another part, or a field
            that is no vector of the part.

    The support pushes with R on the part. That is the balance at rest or at constant velocity; where the motion is
    accelerated the support gives Σ ρ a V more. It stands behind the forces of a step, and reads what the whole scene
    has put into `force_density`: loads on the same nodes belong to it.
    """

    example: ClassVar[Any] = {"region": Everywhere()}
    reads = (force_density, volume)

    def __init__(self, part: Part, region: Any, *, field: Field = reaction_force, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        self.field = place_for(self.label, field, reaction_force)
        self.writes = (field,)
        if isinstance(region, BoundaryDomain):
            if region.part is not part:
                raise BadInput(f"{self.label}: {region.label} is of another part: measure it there")
            if not region.moves:
                raise BadInput(f"{self.label}: {region.label} prescribes a load: give one that prescribes a motion")
            self.nodes = region.nodes
        else:
            self.nodes = part.where(region)
        if not len(self.nodes):
            raise BadInput(f"{self.label}: no node lies in {region!r}: check the region or the spacing")

    def apply(self, clock: Clock) -> None:
        forces = self[force_density][self.nodes].astype(np.float64) * self[volume][self.nodes][:, None]
        self[self.field][...] = -forces.sum(axis=0)
