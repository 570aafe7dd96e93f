"""Coordinates of one's own: a mapping and its inverse as plain functions, checked on sample points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.bases import INDEPENDENCE
from rbs_core.space.checks import Bounds, FloatArray, as_points, as_text
from rbs_core.space.mapping import Framed

Function: TypeAlias = Callable[[FloatArray], ArrayLike]
BoundsFunction: TypeAlias = Callable[[FloatArray, FloatArray], tuple[ArrayLike, ArrayLike]]

# Part of the size of the samples by which a point may miss itself after a way there and back.
INVERSE = 1e-9
# Part of the size of a derivative by which a given one may differ from differences of the function.
DERIVATIVE = 1e-6
# Distance of the points of a central difference of fourth order, as a part of the size of the samples: its own error
# of 1e-12/30 of the fifth derivative and the round-off of 1e-16/1e-3 are about equal.
STEP = 1e-3
# Places and weights of Gauss in the interval from 0 to 1: exact for polynomials of degree 5.
GAUSS = (0.5 + 0.5 * np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0]), np.array([5.0, 8.0, 5.0]) / 18)


class Custom(Framed):
    """A mapping of one's own: parent = origin + to_parent(own) @ axes.

    Components of vectors belong to the tangents of the coordinate lines: where one unit along each own coordinate
    leads. Without `jacobian` the tangents are central differences of fourth order, good to about twelve digits where
    the function is smooth over a thousandth of the size of the samples.

    Args:
        to_parent: function of points (n, 3) in own coordinates; returns those in the frame of the axes, (n, 3).
        from_parent: its inverse.
        origin: own origin in the parent's coordinates (m), 1 to 3 components; missing ones are 0.
        axes: of the frame, in the parent's coordinates, as those of `Cartesian`: any lengths but zero, any angles.
        samples: points (n, 3) in own coordinates where the functions are checked, typical for those that will come:
            64 points between -1 and 1 if not given.
        jacobian: function of points (n, 3); returns (n, 3, 3) with [:, i, j] the derivative of the frame's
            coordinate j by the own coordinate i, so that row i is a tangent.
        bounds: function of the smallest and largest own coordinates of a box, (3,) each, that may be infinite;
            returns a box in the frame around its image. Without it bounds are infinite.

    Raises:
        BadInput: where the functions are not inverse to each other, or return something else than finite numbers of
            the same shape; where the tangents are linearly dependent, `jacobian` is not the derivative of `to_parent`,
            or `bounds` leaves out images of the samples; and as `Cartesian`.
    """

    maker = "custom"

    def __init__(
        self,
        to_parent: Function,
        from_parent: Function,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        axes: Sequence[ArrayLike] | None = None,
        *,
        samples: ArrayLike | None = None,
        jacobian: Function | None = None,
        bounds: BoundsFunction | None = None,
    ) -> None:
        super().__init__(origin, axes)
        needed = {"to_parent": to_parent, "from_parent": from_parent}
        wanted = {name: function for name, function in (("jacobian", jacobian), ("bounds", bounds)) if function}
        self._functions: dict[str, Callable[..., Any]] = {**needed, **wanted}
        for name, function in self._functions.items():
            if not callable(function):
                raise BadInput(f"{name} = {function!r} is no function; give one of points (n, 3)")
        self._given = None if samples is None else as_points(samples, "samples").copy()
        points = _spread() if self._given is None else self._given
        if points.shape[1] != 3 or not len(points):
            raise BadInput(f"samples has shape {points.shape}; give at least one point, shape (n, 3)")
        size = np.abs(points).max(axis=0)
        self._size = np.where(size > 0.0, size, size.max() or 1.0)
        images = self._require_inverse(points)
        self._require_tangents(points, images)
        self._require_bounds(points, images)

    def _require_inverse(self, points: FloatArray) -> FloatArray:
        """Images of the samples, refused unless they lead back."""
        images = self._straight(points)
        back = self._own(images)
        wrong = np.flatnonzero((np.abs(back - points) > INVERSE * self._size).any(axis=1))
        if wrong.size:
            row = wrong[0]
            raise BadInput(
                f"{self._name('from_parent')} is not the inverse of {self._name('to_parent')}: the sample "
                f"{as_text(points[row])} goes to {as_text(images[row])} and comes back as {as_text(back[row])}; give "
                "functions that undo each other, or samples=points of shape (n, 3) from the domain where they do"
            )
        return images

    def _require_tangents(self, points: FloatArray, images: FloatArray) -> None:
        tangents = self._tangents(points)
        volume = np.linalg.norm(tangents, axis=2).prod(axis=1)
        wrong = np.flatnonzero(~(np.abs(np.linalg.det(tangents)) > INDEPENDENCE * volume))
        if wrong.size:
            row = wrong[0]
            raise BadInput(
                f"{self._name('to_parent')} is flat at the sample {as_text(points[row])}: its derivatives "
                f"{as_text(tangents[row])} are linearly dependent; leave such points out of the samples"
            )
        if "jacobian" not in self._functions:
            return
        differences = self._differences(points)
        large = np.abs(differences).max(axis=(1, 2)) + np.abs(images).max(initial=0.0) / self._size.max()
        off = (np.abs(tangents - differences).max(axis=(1, 2)) > DERIVATIVE * large).nonzero()[0]
        if off.size:
            row = off[0]
            raise BadInput(
                f"{self._name('jacobian')} is not the derivative of {self._name('to_parent')}: at the sample "
                f"{as_text(points[row])} it is {as_text(tangents[row])}, differences give {as_text(differences[row])};"
                " give [:, i, j] = derivative of coordinate j by own coordinate i (or leave it out)"
            )

    def _require_bounds(self, points: FloatArray, images: FloatArray) -> None:
        least, most = self._box(points.min(axis=0), points.max(axis=0))
        slack = INVERSE * np.abs(images).max()
        wrong = np.flatnonzero(((images < least - slack) | (images > most + slack)).any(axis=1))
        if wrong.size:
            raise BadInput(
                f"{self._name('bounds')} gives {as_text(least)} to {as_text(most)} for the box of all samples, but "
                f"{as_text(points[wrong[0]])} goes to {as_text(images[wrong[0]])}; give a box around all images"
            )

    def _straight(self, points: FloatArray) -> FloatArray:
        return self._called("to_parent", points, points.shape)

    def _own(self, points: FloatArray) -> FloatArray:
        return self._called("from_parent", points, points.shape)

    def _tangents(self, points: FloatArray) -> FloatArray:
        if "jacobian" not in self._functions:
            return self._differences(points)
        return self._called("jacobian", points, (len(points), 3, 3))

    def _differences(self, points: FloatArray) -> FloatArray:
        """Tangents from central differences of fourth order."""
        tangents = np.empty((len(points), 3, 3))
        for axis, size in enumerate(self._size):
            shift = np.zeros(3)
            shift[axis] = STEP * size
            near = self._straight(points + shift) - self._straight(points - shift)
            far = self._straight(points + 2 * shift) - self._straight(points - 2 * shift)
            tangents[:, axis] = (8 * near - far) / (12 * shift[axis])
        return tangents

    def _called(self, name: str, points: FloatArray, shape: tuple[int, ...]) -> FloatArray:
        """What a function returns for a copy of the points, refused unless it has the shape and is finite."""
        with np.errstate(all="ignore"):  # what is outside of the domain shows below, with the point
            values = np.asarray(self._functions[name](points.copy()))
        if values.shape != shape or values.dtype.kind not in "biuf":
            raise BadInput(
                f"{self._name(name)} returns {values.dtype} of shape {values.shape} for points of shape "
                f"{points.shape}; return real numbers of shape {shape}"
            )
        wrong = np.flatnonzero(~np.isfinite(values.reshape(len(points), -1)).all(axis=1))
        if wrong.size:
            raise BadInput(
                f"{self._name(name)} returns {as_text(values[wrong[0]])} for {as_text(points[wrong[0]])}; give points "
                "from its domain (where they are samples: samples=points of shape (n, 3))"
            )
        return values.astype(np.float64)

    def cell_volumes(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """What cells measure in the parent, by three points of Gauss along each axis."""
        count, dimension = lower.shape
        sides, total = upper - lower, np.zeros(count)
        for picked in np.ndindex((3,) * dimension):
            points = np.zeros((count, 3))
            points[:, :dimension] = lower + sides * GAUSS[0][list(picked)]
            blocks = self._tangents(points)[:, :dimension, :dimension]
            total += np.abs(np.linalg.det(blocks)) * GAUSS[1][list(picked)].prod()
        volumes: FloatArray = total * sides.prod(axis=1) * self.frame.volume_factor(dimension)
        return volumes

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """What `bounds` says of a box, in the parent's coordinates; all of space without it."""
        return self.frame.bounds_to_parent(*self._box(lower, upper))

    def _box(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        if "bounds" not in self._functions:
            return np.full(3, -np.inf), np.full(3, np.inf)
        low, high = (np.array(side, dtype=np.float64) for side in self._functions["bounds"](lower.copy(), upper.copy()))
        if low.shape != (3,) or high.shape != (3,) or not (low <= high).all():
            raise BadInput(
                f"{self._name('bounds')} returns {as_text(low)} and {as_text(high)} for {as_text(lower)} and "
                f"{as_text(upper)}; return the smallest and the largest coordinates, (3,) each"
            )
        return low, high

    def _name(self, name: str) -> str:
        """The name of an argument with that of its function."""
        return f"{name} = {_qualified(self._functions[name])}"

    def arguments(self) -> str:
        """The arguments as they could be typed, functions by their names, those that were not given left out."""
        functions = [_qualified(self._functions[name]) for name in ("to_parent", "from_parent")]
        others = [
            f"{name}={_qualified(self._functions[name])}" for name in ("jacobian", "bounds") if name in self._functions
        ]
        samples = [] if self._given is None else [f"samples={as_text(self._given)}"]
        return ", ".join([*functions, super().arguments(), *samples, *others])


def _qualified(function: object) -> str:
    return str(getattr(function, "__qualname__", repr(function)))


def _spread() -> FloatArray:
    """64 points that fill the cube from -1 to 1 evenly, none of them on its surface or on an axis."""
    ratio = 1.2207440846057596  # the root of x^4 = x + 1: its powers are hard to approach by fractions
    steps = np.outer(np.arange(1, 65), ratio ** -np.arange(1.0, 4.0))
    return 2.0 * (steps % 1.0) - 1.0
