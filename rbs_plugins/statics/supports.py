"""Which pieces of a problem can still move as rigid bodies: a stiffness has no inverse then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from rbs_core import BadInput, Connection
from rbs_plugins.loops.joint import End
from rbs_plugins.statics.problem import Problem

RANK = 1e-8  # singular values below this share of the largest count as none


@dataclass(frozen=True)
class LoosePiece:
    """Nodes that hang together and are not held.

    Attributes:
        numbers: of their unknowns.
        nodes: how many there are.
        motion: what they can do, in words.
        where: one of the unknowns, named.
    """

    numbers: NDArray[np.int64]
    nodes: int
    motion: str
    where: str

    def __str__(self) -> str:
        return f"{self.nodes} nodes that hang together can {self.motion} (among them {self.where})"


def loose_pieces(problem: Problem) -> list[LoosePiece]:
    """The pieces, joined by bonds that hold, whose prescribed displacements leave a rigid motion free."""
    count, label = _pieces(problem)
    dimension = problem.parts[0].dimension
    ends = [End(part) for part in problem.parts]
    moved = [u.reshape(-1, dimension) for u in (problem.u[place] for place in problem.places.values())]
    positions = np.concatenate([
        e.origin + (part.positions + u) @ e.turn.T for e, part, u in zip(ends, problem.parts, moved, strict=True)
    ])  # fmt: skip
    turns = np.repeat([end.turn for end in ends], [len(part) for part in problem.parts], axis=0)
    held = problem.fixed.reshape(-1, dimension)
    order = np.argsort(label, kind="stable")
    bounds = np.searchsorted(label[order], np.arange(count + 1))
    found = []
    for piece in range(count):
        nodes = order[bounds[piece] : bounds[piece + 1]]
        free = _free_motion(positions[nodes], turns[nodes], held[nodes])
        if free is not None:
            numbers = (nodes[:, None] * dimension + np.arange(dimension)).ravel()
            found.append(LoosePiece(numbers, len(nodes), free, problem.named(int(numbers[0]))))
    return found


def require_supports(problem: Problem, owner: str) -> None:
    """Refuses a problem in which a piece can move as a rigid body.

    Raises:
        BadInput: names the piece, and how it can move.
    """
    loose = loose_pieces(problem)
    if loose:
        more = f" and {len(loose) - 1} more pieces" if len(loose) > 1 else ""
        raise BadInput(
            f"{owner}: {loose[0]}{more}: prescribe displacements there (BoundaryDomain(part, region, displacement=...) "
            "in boundaries=), or connect it to what is held"
        )


def _pieces(problem: Problem) -> tuple[int, NDArray[np.int32]]:
    """Number of pieces, and that of each node, all parts one behind the other."""
    first = {part: place.start // part.dimension for part, place in problem.places.items()}
    total = problem.size // problem.parts[0].dimension
    starts, ends = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for host in problem.hosts:
        offsets, neighbors = host.bonds.as_rows()
        if isinstance(host, Connection):
            nodes = np.concatenate([first[end] + own for end, own in zip(host.ends, host.nodes, strict=True)])
        else:
            nodes = first[host] + np.arange(len(host))  # type: ignore[index]
        holds = host.bonds.intact if host.bonds.has_broken else slice(None)
        starts.append(np.repeat(nodes, np.diff(offsets))[holds])
        ends.append(nodes[neighbors][holds])
    i, j = np.concatenate(starts), np.concatenate(ends)
    graph = coo_array((np.ones(len(i), np.int8), (i, j)), shape=(total, total))
    count, label = connected_components(graph.tocsr(), directed=False)
    return int(count), label


def _free_motion(positions: NDArray[np.float64], turns: NDArray[np.float64], held: NDArray[np.bool_]) -> str | None:
    """A rigid motion that the held components of some nodes allow, in words; None if there is none."""
    dimension = positions.shape[1]
    centre = positions.mean(axis=0)
    arms = (positions - centre) / (np.abs(positions - centre).max() or 1.0)
    modes = [np.broadcast_to(np.eye(dimension)[k], positions.shape) for k in range(dimension)]
    names = [f"move along {'xyz'[k]}" for k in range(dimension)]
    for a, b, name in ((0, 1, "z"), (1, 2, "x"), (2, 0, "y")):
        if max(a, b) < dimension:
            turn = np.zeros(positions.shape)
            turn[:, a], turn[:, b] = -arms[:, b], arms[:, a]
            modes.append(turn)
            names.append(f"turn about {name}" if dimension == 3 else "turn")
    if not held.any():
        return names[0]
    # components of a motion in the own axes of a part are held
    table = np.stack([np.einsum("nak,na->nk", turns, mode)[held] for mode in modes], axis=1)
    # one node, or nodes on a line, do not turn in every way: only what moves some node counts
    every = np.stack([mode.ravel() for mode in modes], axis=1)
    sizes, moving = np.linalg.eigh(every.T @ every)
    moving = moving[:, sizes > RANK * sizes[-1]]
    values, vectors = np.linalg.eigh((table @ moving).T @ (table @ moving))
    if values[0] > RANK * max(values[-1], 1.0):
        return None
    share = np.abs(moving @ vectors[:, 0])
    turns_too = share[dimension:].max(initial=0.0) > RANK  # a turn about a pin moves the centre as well
    return names[dimension + int(np.argmax(share[dimension:]))] if turns_too else names[int(np.argmax(share))]
