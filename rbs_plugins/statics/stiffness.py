"""The stiffness of a whole problem: the tangents of its forces, put together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, dia_array

from rbs_core import BadInput
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
        self._tangents: list[Any] = [each.tangent() for each in (*forces, *following)]  # type: ignore[attr-defined]
        self._places = [np.concatenate([_numbers(problem, end) for end in each.ends]) for each in self._tangents]
        self._whole = [bool(len(p) == self.size and (p == np.arange(self.size)).all()) for p in self._places]
        self.symmetric = all(each.symmetric for each in self._tangents)
        self.constant = all(each.constant for each in self._tangents)
        self.shift: Vector | None = None

    def update(self) -> None:
        """Follows the present state; what does not depend on displacements is found at rest, whenever it is asked for.

        So it is the same to the bit in a run that is resumed.
        """
        problem, u = self._problem, self._problem.u.copy()
        if self.constant:
            problem.u[...] = 0.0
        problem.give()
        for each in self._tangents:
            each.update()
        problem.u[...] = u
        problem.give()

    def multiply(self, v: Vector, out: Vector) -> None:
        """Out = K v."""
        if self.shift is None:
            out.fill(0.0)
        else:
            np.multiply(self.shift, v, out=out)
        for tangent, place, whole in zip(self._tangents, self._places, self._whole, strict=True):
            if whole:
                tangent.multiply(v, out)
            else:
                own = np.zeros(len(place))
                tangent.multiply(v[place], own)
                out[place] += own

    def diagonal(self) -> Vector:
        """The diagonal of K."""
        out = np.zeros(self.size) if self.shift is None else self.shift.copy()
        for tangent, place in zip(self._tangents, self._places, strict=True):
            own = np.zeros(len(place))
            tangent.diagonal(own)
            out[place] += own
        return out

    @property
    def nbytes(self) -> int:
        """Bytes of all tangents, as far as they tell."""
        return sum(getattr(each, "nbytes", 0) for each in self._tangents)

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
        for tangent, place, whole in zip(self._tangents, self._places, self._whole, strict=True):
            own = tangent.matrix()
            own = own if whole else _embedded(own, place, self.size)
            total = own if total is None else total + own
        assert total is not None
        if self.shift is not None:
            total = total + dia_array((self.shift[None], [0]), shape=(self.size, self.size)).tocsr()
        return csr_array(total)


def _numbers(problem: Problem, part: Any) -> NDArray[np.int64]:
    place = problem.places[part]
    return np.arange(place.start, place.stop)


def _embedded(own: csr_array, place: NDArray[np.int64], size: int) -> csr_array:
    """A matrix of some unknowns as one of all; the places ascend within each part."""
    coo = own.tocoo()
    return csr_array((coo.data, (place[coo.row], place[coo.col])), shape=(size, size))
