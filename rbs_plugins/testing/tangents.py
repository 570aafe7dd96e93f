"""Checks of tangents, for relations that offer them: against differences of forces, and as matrices."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.fields import volume
from rbs_plugins.loops import SERIAL_BELOW
from rbs_plugins.tangents import Tangent
from rbs_plugins.testing.specimen import MANY, SMALL, SPACING, Array, NotApplicable, RelationClass, Specimen, body

LISTS = ("grid", "jittered")
TINY = {1: (12,), 2: (5, 5), 3: (4, 3, 3)}
FAR = 0.05  # spacings: a displacement by which every part of a tangent counts
CENTRAL = 1e-6  # of differences against the tangent, relative to its largest entry
EXACT = 1e-12


def check_tangent(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """K is −d(V f)/du for damage that is held: column by column against central differences of `apply`, to 1e-6.

    The displacement would break bonds, if the relation takes `fracture`: `hold` keeps them.
    """
    specimen = _held(relation_class, dimension, cloud, **arguments)
    u = specimen.rough(FAR)
    tangent = _tangent(specimen, u)
    whole = tangent.matrix().toarray()
    step = SMALL * SPACING
    columns = []
    for index in np.ndindex(*u.shape):
        one, two = u.copy(), u.copy()
        one[index] += step
        two[index] -= step
        columns.append(_forces(specimen, two) - _forces(specimen, one))
        columns[-1] /= one[index] - two[index]
    _near("tangent − differences of forces", whole - np.array(columns).T, CENTRAL * _largest(whole))


def check_tangent_matrix(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """K as a matrix: product and diagonal, symmetry, what feels no force, and no negative stiffness at rest."""
    specimen = _held(relation_class, dimension, cloud, **arguments)
    u = specimen.rough(FAR)
    tangent = _tangent(specimen, u)
    matrix = tangent.matrix()
    matrix.check_format()
    assert matrix.has_sorted_indices, "columns are not sorted"
    whole = matrix.toarray()
    largest = _largest(whole)
    limit = EXACT * largest
    v = np.random.default_rng(4).uniform(-1.0, 1.0, len(whole))
    out = largest * v
    tangent.multiply(v, out)
    _near("product − that of the matrix", out - largest * v - whole @ v, limit)
    out = largest * v
    tangent.diagonal(out)
    _near("diagonal − that of the matrix", out - largest * v - np.diag(whole), limit)
    if tangent.symmetric:
        _near("K − its transpose", whole - whole.T, limit)
    if not tangent.grounded:
        _near("force of a translation", whole.reshape(len(whole), -1, dimension).sum(axis=1), limit)
    _forces(specimen, np.zeros_like(u))
    tangent.update()
    again = tangent.matrix()
    assert np.array_equal(again.indptr, matrix.indptr), "the same bonds make another structure"
    assert np.array_equal(again.indices, matrix.indices), "the same bonds make another structure"
    still, X = again.toarray(), specimen.part.positions / SPACING
    turns = relation_class.role == "constitutive" and not tangent.grounded  # a load may turn with the body
    for a in range(dimension if turns else 0):
        for b in range(a):
            turn = np.zeros_like(X)
            turn[:, a], turn[:, b] = X[:, b], -X[:, a]
            _near("force of a small rotation at rest", still @ turn.ravel(), limit * np.abs(X).max())
    if tangent.symmetric:
        lowest = float(np.linalg.eigvalsh(still).min())
        assert lowest >= -limit, (
            f"K at rest has the negative eigenvalue {lowest:.3g}, its largest entry is {largest:.3g}"
        )


def check_tangent_threads(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """One thread and two give the same matrix, product and diagonal to the bit."""
    if getattr(numba.config, "NUMBA_NUM_THREADS", 1) < 2:
        raise NotApplicable("this machine has one core")
    specimen = _held(relation_class, dimension, cloud, shape=MANY[dimension], **arguments)
    assert len(specimen.part.bonds) >= SERIAL_BELOW, "too small a body: it would run on one thread anyway"
    tangent = _tangent(specimen, specimen.rough(FAR))
    v = np.random.default_rng(4).uniform(-1.0, 1.0, tangent.size)
    found = []
    threads = numba.get_num_threads()
    try:
        for count in (1, 2):
            numba.set_num_threads(count)
            tangent.update()
            product, diagonal = np.zeros_like(v), np.zeros_like(v)
            tangent.multiply(v, product)
            tangent.diagonal(diagonal)
            found.append((tangent.matrix().data.copy(), product, diagonal))
    finally:
        numba.set_num_threads(threads)
    for what, one, two in zip(("matrix", "product", "diagonal"), *found, strict=True):
        assert np.array_equal(one, two), f"the {what} differs by up to {np.abs(one - two).max()}"


def _held(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> Specimen:
    """A tiny specimen, some bonds broken, that breaks no more."""
    if not hasattr(relation_class, "tangent"):
        raise NotApplicable(f"{relation_class.__name__} offers no tangent")
    if cloud not in LISTS:
        raise NotApplicable("tangents are for bonds stored as list")
    if "fracture" in inspect.signature(relation_class).parameters:
        arguments = {"fracture": CriticalStretch(0.01), **arguments}
    shape = arguments.pop("shape", TINY[dimension])
    specimen = Specimen(relation_class, body(dimension, cloud, shape=shape), **arguments)
    hold = getattr(specimen.relation, "hold", None)
    assert hold is False, f"{relation_class.__name__} has a tangent(), and needs an attribute hold, False at first"
    specimen.relation.hold = True  # type: ignore[attr-defined]
    return specimen


def _tangent(specimen: Specimen, u: Array) -> Tangent:
    """The tangent at a displacement."""
    _forces(specimen, u)
    tangent: Tangent = specimen.relation.tangent()  # type: ignore[attr-defined]
    assert tangent.ends == (specimen.part,), f"the tangent takes displacements of {tangent.ends}"
    tangent.update()
    return tangent


def _forces(specimen: Specimen, u: Array) -> Array:
    """(dN,) forces on the nodes, N."""
    return (specimen.force(u) * specimen.part[volume][:, None]).ravel()


def _largest(whole: Array) -> float:
    found = float(np.abs(whole).max())
    if found == 0.0:
        raise NotApplicable("nothing resists: the relation feels nothing here")
    return found


def _near(what: str, values: Array, limit: float) -> None:
    worst = float(np.abs(values).max())
    assert worst <= limit, f"{what}: {worst:.3g}, and {limit:.3g} is allowed"


TANGENTS: dict[Callable[..., None], tuple[str, ...]] = dict.fromkeys(
    (check_tangent, check_tangent_matrix, check_tangent_threads), LISTS
)
