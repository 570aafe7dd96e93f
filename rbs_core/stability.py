"""The largest stable step of an explicit scheme, from bounds that the relations give for each node."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import UnstableStep
from rbs_core.part import Part
from rbs_core.relation import Relation

UNKNOWN_STEP = "no relation of this scene knows a stable time step (is a density missing?): give dt"


@dataclass(frozen=True)
class Limit:
    """The stable time step, s, and the node that sets it."""

    dt: float
    part: Part
    node: int

    def refusal(self, dt: float) -> UnstableStep:
        """The error about a larger step."""
        where = self.part.positions[self.node].tolist()
        return UnstableStep(
            f"dt={dt:.6g} s is above the stable step {self.dt:.6g} s, which node {self.node} of part "
            f"'{self.part.name}' at {where} sets: the run would explode. Take dt={0.8 * self.dt:.3g} (or leave it "
            "out), or force_dt=True if you know better"
        )


def largest_stable_step(relations: Sequence[Relation]) -> Limit | None:
    """2 / (largest angular frequency) over all parts and nodes; None if no relation has a say.

    Forces on one part stiffen each other, so their bounds of the squared frequency add up node by node.
    """
    limits = []
    totals: dict[Part, NDArray[np.float64]] = {}
    for relation in dict.fromkeys(relations):
        for part, bound in relation.squared_frequencies().items():
            totals[part] = totals[part] + bound if part in totals else bound
    for part, total in totals.items():
        if total.max() > 0:
            limits.append(Limit(2.0 / math.sqrt(total.max()), part, int(total.argmax())))
    return min(limits, key=lambda limit: limit.dt, default=None)
