"""At which load each bond of a linear equilibrium would fail."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.part import Connection, Host
from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.loops.joint import End
from rbs_plugins.statics.problem import Problem, Vector

ROUND_OFF = 1e-10  # stretches below this share of the largest are none


def require_linear(problem: Problem, owner: str) -> None:
    """Refuses forces and loads that are not linear, and criteria that are no critical stretch.

    Raises:
        BadInput: names the relation, and what to take.
    """
    for force in problem.given:
        if not getattr(force, "linear", False):
            raise BadInput(f"{owner}: {force.label} is not linear: make it with linear=True, or take Newton")
        criterion = getattr(force, "fracture", None)
        if criterion is not None and not isinstance(criterion, CriticalStretch):
            raise BadInput(
                f"{owner}: {force.label} fails by {criterion!r}; only a CriticalStretch tells at which load a "
                "bond fails: take that, or Newton"
            )
    for load in problem.loads:
        if hasattr(load, "tangent"):
            raise BadInput(
                f"{owner}: {load.label} depends on displacements, so it is no multiple of what it is at rest: "
                "take a dead load, BoundaryDomain(force=...), or Newton"
            )
    if not any(getattr(force, "fracture", None) for force in problem.given):
        raise BadInput(f"{owner}: no force has a criterion, so that nothing can fail: give fracture=, or take "
                       "Newton")  # fmt: skip


class BondLimits:
    """The bonds of a force, and at which stretch each fails.

    Args:
        force: with a CriticalStretch.
        holds: (m,) state of the bonds.
        problem: whose unknowns the ends are.
    """

    def __init__(self, force: PairwiseForce, holds: NDArray[Any], problem: Problem) -> None:
        self.host, self._holds = force.host, holds
        offsets, neighbors = force.host.bonds.as_rows()
        self._i = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        self._j = neighbors.astype(np.int64)
        nodes = np.concatenate(self.host.nodes) if isinstance(self.host, Connection) else np.arange(len(self.host))
        self._nodes = nodes
        first = self._unknowns(problem)
        positions = force.host.bonds.positions
        bond = positions[self._j] - positions[self._i]
        self._direction = bond / np.sum(bond * bond, axis=1)[:, None]
        self._at = (first[self._i], first[self._j])
        self._turns = _turns(force.host)
        criterion = force.fracture
        assert isinstance(criterion, CriticalStretch)
        self._tension, self._compression = criterion.limits(force, self._i, self._j)

    def _unknowns(self, problem: Problem) -> NDArray[np.int64]:
        """(n, d) numbers of the unknowns of the nodes of the host."""
        parts = self.host.ends if isinstance(self.host, Connection) else (self.host,)
        own = self.host.nodes if isinstance(self.host, Connection) else (np.arange(len(self.host)),)
        d = self.host.dimension
        each = [
            problem.places[part].start + nodes[:, None] * d + np.arange(d)
            for part, nodes in zip(parts, own, strict=True)
        ]
        return np.concatenate(each)

    def shares(self, u: Vector) -> NDArray[np.float64]:
        """(m,) stretch over critical stretch; zero for what has failed."""
        i, j = self._at
        moved = [u[numbers] if self._turns is None else np.einsum("nak,nk->na", self._turns[end], u[numbers])
                 for numbers, end in ((i, self._i), (j, self._j))]  # fmt: skip
        stretch = np.sum((moved[1] - moved[0]) * self._direction, axis=1)
        share = np.maximum(stretch / self._tension, -stretch / self._compression)
        strained = np.abs(stretch) > ROUND_OFF * np.abs(stretch).max(initial=0.0)
        return np.where(strained & (self._holds != 0), share, 0.0)

    def ends(self, bonds: NDArray[np.int64]) -> list[tuple[int, int]]:
        """Nodes of some bonds, each pair once."""
        i, j = self._nodes[self._i[bonds]], self._nodes[self._j[bonds]]
        once = self._i[bonds] < self._j[bonds]
        return list(zip(i[once].tolist(), j[once].tolist(), strict=True))


def _turns(host: Host) -> NDArray[np.float64] | None:
    """(n, d, d) from components in the part of each node to those in which the bonds are; None if they are the same."""
    if not isinstance(host, Connection):
        return None
    ends = [End(part) for part in host.ends]
    if not any(end.may_move for end in ends):
        return None
    return np.repeat([end.turn for end in ends], [len(nodes) for nodes in host.nodes], axis=0)
