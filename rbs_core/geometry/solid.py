"""Shapes that fill part of space and know their exact distance."""

from __future__ import annotations

import numpy as np

from rbs_core.geometry.base import Geometry
from rbs_core.space.checks import BoolArray, Bounds, FloatArray


class Solid(Geometry):
    """A shape that fills part of space and knows its exact distance: closed, its surface belongs to it.

    A subclass has `dimension`, `_parameters`, `_kinds`, `_distance`, `_projection` and `_reaches`.
    """

    @property
    def bounds(self) -> Bounds:
        """Smallest and largest coordinates, as small a box as there is."""
        return bounds_of(self)

    def _contains(self, points: FloatArray) -> BoolArray:
        inside: BoolArray = self._distance(points) <= self._round_off(points)
        return inside


def bounds_of(geometry: Geometry) -> Bounds:
    """Bounds of a geometry of known dimension, by how far it reaches along the axes."""
    axes = np.eye(geometry.dimension or 1)
    # 0 is added and subtracted from so that no bound is -0.0.
    upper = np.array([geometry._reaches(axis) + 0.0 for axis in axes])
    lower = np.array([0.0 - geometry._reaches(-axis) for axis in axes])
    return lower, upper
