"""The stiffness of a whole problem: the tangents of its forces, put together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, dia_array

from rbs_core import BadInput, always
from rbs_core.trigger import Clock
from rbs_plugins.statics.problem import Problem, Vector


class Stiffness:
    """K = −∂(forces)/∂u of all unknowns of a problem, N/m, as a product, a diagonal, or a matrix.

    Args:
        problem: attached.
        owner: name for messages.

    Attributes:
        size: number of unknowns.
        symmetric: whether K is.
        constant: whether K is the same for all displacements.
        grounded: whether one of the tangents pulls bodies back to their places.
        shift: (size,) what is added to the diagonal, N/m, e.g. masses over squared time steps; None for nothing.

    Raises:
        BadInput: if a force has no tangent.
    """

    def __init__(self, problem: Problem, owner: str) -> None:
        self._problem, self.size = problem, problem.size
        forces = [each for each in problem.given if each.role == "constitutive"]
        without = [each for each in forces if not hasattr(each, "tangent")]
        if without:
            raise BadInput(
                f"{owner}: {without[0].label} has no tangent(), the derivative of its force: take "
                "AdaptiveDynamicRelaxation, which needs none"
            )
        following = [each for each in problem.loads if hasattr(each, "tangent")]
        self._all = [_Placed(each, problem) for each in (*forces, *following)]
        self._acting = self._all
        tangents = [each.tangent for each in self._all]
        self.symmetric = all(each.symmetric for each in tangents)
        self.constant = all(each.constant for each in tangents) and all(each.when == always for each in forces)
        self.grounded = any(each.grounded for each in tangents)
        self.shift: Vector | None = None

    def update(self, clock: Clock) -> None:
        """Follows the present state; what does not depend on displacements is found at rest, whenever it is asked for.

        So it is the same to the bit in a run that is resumed.
        """
        problem, u = self._problem, self._problem.u.copy()
        if self.constant:
            problem.u[...] = 0.0
        problem.give()
        self._acting = [each for each in self._all if each.relation.when(clock)]
        for each in self._acting:
            each.tangent.update()
        problem.u[...] = u
        problem.give()

    def multiply(self, v: Vector, out: Vector) -> None:
        """Out = K v."""
        if self.shift is None:
            out.fill(0.0)
        else:
            np.multiply(self.shift, v, out=out)
        for each in self._acting:
            if each.whole:
                each.tangent.multiply(v, out)
            else:
                own = np.zeros(len(each.place))
                each.tangent.multiply(v[each.place], own)
                out[each.place] += own

    def diagonal(self) -> Vector:
        """The diagonal of K."""
        out = np.zeros(self.size) if self.shift is None else self.shift.copy()
        for each in self._acting:
            own = np.zeros(len(each.place))
            each.tangent.diagonal(own)
            out[each.place] += own
        return out

    @property
    def nbytes(self) -> int:
        """Bytes of all tangents, as far as they tell."""
        return sum(getattr(each.tangent, "nbytes", 0) for each in self._all)

    def rigid_motions(self) -> NDArray[np.float64]:
        """(size, 1, 3 or 6) what translations and turns of the whole move, all parts as if in one system."""
        d = self._problem.parts[0].dimension
        X = np.concatenate([part.positions for part in self._problem.parts]) + self._problem.u.reshape(-1, d)
        X = X - X.mean(axis=0)
        modes = [np.broadcast_to(np.eye(d)[k], X.shape) for k in range(d)]
        for a in range(d):
            for b in range(a):
                turn = np.zeros_like(X)
                turn[:, a], turn[:, b] = X[:, b], -X[:, a]
                modes.append(turn)
        return np.stack([mode.ravel() for mode in modes], axis=1)

    def matrix(self) -> csr_array:
        """K as compressed rows."""
        total = None
        for each in self._acting:
            own = each.tangent.matrix()
            own = own if each.whole else _embedded(own, each.place, self.size)
            total = own if total is None else total + own
        if total is None:
            total = csr_array((self.size, self.size))
        if self.shift is not None:
            total = total + dia_array((self.shift[None], [0]), shape=(self.size, self.size)).tocsr()
        return csr_array(total)


class _Placed:
    """The tangent of a relation among all unknowns.

    Attributes:
        place: numbers of its unknowns.
        whole: whether those are all, in order.
    """

    def __init__(self, relation: Any, problem: Problem) -> None:
        self.relation, self.tangent = relation, relation.tangent()
        ends = [problem.places[end] for end in self.tangent.ends]
        self.place = np.concatenate([np.arange(each.start, each.stop) for each in ends])
        self.whole = np.array_equal(self.place, np.arange(problem.size))


def _embedded(own: csr_array, place: NDArray[np.int64], size: int) -> csr_array:
    """A matrix of some unknowns as one of all; the places ascend within each part."""
    coo = own.tocoo()
    return csr_array((coo.data, (place[coo.row], place[coo.col])), shape=(size, size))
