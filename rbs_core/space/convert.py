"""Points and vectors of one coordinate system in another, by way of their lowest common ancestor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.bases import combined, reciprocal
from rbs_core.space.checks import FloatArray, as_real, as_text, require_finite
from rbs_core.space.system import CoordinateSystem

# A component is dropped on the way back to 1-D or 2-D when it is below this fraction of the largest one met.
FLATNESS = 1e-12


def convert(points: ArrayLike, source: CoordinateSystem, target: CoordinateSystem) -> FloatArray:
    """Points of one system in coordinates of another, by way of their lowest common ancestor.

    Args:
        points: shape (n, d), or (d,) for one point; d = 1, 2 or 3, missing components count as 0.
        source: the system that the points are given in.
        target: the system that they are wanted in; the same one gives a copy.

    Returns:
        A new float64 array of the shape of `points`.

    Raises:
        BadInput: when the systems belong to different trees; when points in 1-D or 2-D leave their line or plane
            (by more than 1e-12 of the largest coordinate met on the way); for other shapes and for NaN or infinity;
            for coordinates that a system does not have, such as a negative radius.
    """
    array = _rows_from(points, "points")
    up, down = _way(source, target)
    if source is target:
        return array
    full, dimension = _padded(array), array.shape[-1]
    scale = np.abs(full).max(initial=0.0)
    mappings = [system.placement()[0] for system in (*up, *down)]
    steps = [mapping.to_parent for mapping in mappings[: len(up)]]
    for step in (*steps, *(mapping.from_parent for mapping in mappings[len(up) :])):
        full = step(full)
        scale = max(scale, np.abs(full).max(initial=0.0))
    _require_flat(full, dimension, FLATNESS * scale, f"{source.path} to {target.path}: points")
    return np.ascontiguousarray(full[:, :dimension]).reshape(array.shape)


def convert_vectors(
    vectors: ArrayLike, points: ArrayLike, source: CoordinateSystem, target: CoordinateSystem
) -> FloatArray:
    """Vectors at points of one system, in components of another.

    Components belong to the basis of a system at the point: in Cartesian systems its axes with the lengths they have,
    in cylindrical and spherical ones unit vectors along the coordinate lines (stretched as their axes are), in custom
    ones the tangents of the coordinate lines. So a displacement, a velocity or a force stays the same arrow.

    Args:
        vectors: components in the source, shape (n, d), or (d,) for one; missing components count as 0.
        points: where they are, in coordinates of the source (m, rad), of the same shape.
        source: the system that vectors and points are given in.
        target: the system that the vectors are wanted in; the same one gives a copy.

    Returns:
        A new float64 array of the shape of `vectors`.

    Raises:
        BadInput: as `convert`; for different shapes; where a system on the way down has no basis at a point, such as
            a child of a cylindrical system on the axis of that; where a kind of coordinates has no basis at all.
    """
    array, places = _rows_from(vectors, "vectors"), _rows_from(points, "points")
    if array.shape != places.shape:
        raise BadInput(
            f"vectors has shape {array.shape}, points has {places.shape}; give one point per vector, in the same shape"
        )
    up, down = _way(source, target)
    if source is target:
        return array
    full, where, dimension = _padded(array), _padded(places), array.shape[-1]
    largest = np.zeros(2)
    for system, step in (*((system, _raised) for system in up), *((system, _lowered) for system in down)):
        largest = np.maximum(largest, [np.abs(full).max(initial=0.0), np.abs(where).max(initial=0.0)])
        full, where = step(full, where, system)
    way = f"{source.path} to {target.path}"
    for rows, largest_before, what in zip((full, where), largest, ("vectors", "points"), strict=True):
        tolerance = FLATNESS * max(largest_before, np.abs(rows).max(initial=0.0))
        _require_flat(rows, dimension, tolerance, f"{way}: {what}")
    return np.ascontiguousarray(full[:, :dimension]).reshape(array.shape)


def _raised(vectors: FloatArray, points: FloatArray, system: CoordinateSystem) -> tuple[FloatArray, FloatArray]:
    """Vectors and points of a system, in its parent."""
    mapping, parent = system.placement()
    changes = combined(vectors, np.moveaxis(mapping.basis(points), 1, 0))  # of the parent's coordinates
    above = mapping.to_parent(points)
    return changes * _scales(parent, above), above


def _lowered(vectors: FloatArray, points: FloatArray, system: CoordinateSystem) -> tuple[FloatArray, FloatArray]:
    """Vectors and points of the parent of a system, in the system."""
    mapping, parent = system.placement()
    scales = _scales(parent, points)
    own = mapping.from_parent(points)
    dual = reciprocal(mapping.basis(own))
    lost = np.flatnonzero((scales == 0.0).any(axis=1) | np.isnan(dual).any(axis=(1, 2)))
    if lost.size:
        raise BadInput(
            f"{system.path} has no basis at {as_text(own[lost[0]])} (points[{lost[0]}]), where a coordinate of "
            f"{parent.path} or of itself leads nowhere; leave points on such an axis or in such a center out"
        )
    return ((vectors / scales)[:, None, :] * dual).sum(axis=2), own


def _scales(system: CoordinateSystem, points: FloatArray) -> FloatArray:
    """Basis vectors per unit of each coordinate at points (n, 3); all 1 in a root, which is straight."""
    return np.ones_like(points) if system.mapping is None else system.mapping.scales(points)


def _rows_from(values: ArrayLike, what: str) -> FloatArray:
    """A copy as float64 of shape (n, d) or (d,)."""
    array = np.array(as_real(values, what), dtype=np.float64)
    if array.ndim not in (1, 2) or not 1 <= array.shape[-1] <= 3:
        raise BadInput(
            f"{what} has shape {array.shape}; give (n, d), or (d,) for one of them, with d = 1, 2 or 3 "
            "(many in 1-D: shape (n, 1))"
        )
    require_finite(array, what)
    return array


def _padded(array: FloatArray) -> FloatArray:
    """Rows (n, 3) with zeros for missing components."""
    rows = array.reshape(-1, array.shape[-1])
    full = np.zeros((len(rows), 3))
    full[:, : rows.shape[1]] = rows
    return full


def _way(source: CoordinateSystem, target: CoordinateSystem) -> tuple[list[CoordinateSystem], list[CoordinateSystem]]:
    """The systems to leave upwards from the source, and those to enter downwards to the target."""
    for system, what in ((source, "source"), (target, "target")):
        if not isinstance(system, CoordinateSystem):
            raise BadInput(f"{what} = {system!r} is no CoordinateSystem; give world or a system below it")
    shared = _common_ancestor(source, target)
    return _line_below(shared, source), _line_below(shared, target)[::-1]


def _common_ancestor(source: CoordinateSystem, target: CoordinateSystem) -> CoordinateSystem:
    """The deepest system that is above both (or one of them)."""
    a: CoordinateSystem | None = source
    b: CoordinateSystem | None = target
    while a is not b:
        # The deeper one climbs; at equal depth both must, the second in the next round.
        if b is None or (a is not None and a.depth >= b.depth):
            a = a.parent if a is not None else None
        else:
            b = b.parent
    if a is None:
        raise BadInput(
            f"{source.path!r} and {target.path!r} belong to different trees; make both children of one system, "
            "such as world"
        )
    return a


def _line_below(top: CoordinateSystem, bottom: CoordinateSystem) -> list[CoordinateSystem]:
    """The systems from `bottom` up to, but without, `top`."""
    systems: list[CoordinateSystem] = []
    system: CoordinateSystem | None = bottom
    while system is not None and system is not top:
        systems.append(system)
        system = system.parent
    return systems


def _require_flat(full: FloatArray, dimension: int, tolerance: float, way: str) -> None:
    """Refuse to drop components that are not zero."""
    dropped = np.abs(full[:, dimension:])
    if dropped.size and dropped.max() > tolerance:
        row, column = np.unravel_index(np.argmax(dropped), dropped.shape)
        raise BadInput(
            f"{way}[{row}] gets {'xyz'[dimension + int(column)]} = {full[row, dimension + column]:.6g} and "
            f"leaves {dimension} dimension{'s' if dimension > 1 else ''}; give 3-D points (add the missing zeros)"
        )
