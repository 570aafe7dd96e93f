"""The part of a surface that lies in a region, as a surface that bonds can cross."""

from __future__ import annotations

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry
from rbs_core.geometry.described import common_dimension, require_kind
from rbs_core.geometry.nearest import shared
from rbs_core.geometry.surfaces import Surface, Surfaces
from rbs_core.space.checks import BoolArray, Bounds, FloatArray

# Part of the size by which a search begins beside the point that it is about.
BESIDE = 1e-3


class Cropped(Surface):
    """The part of a flat surface in a region; usually written `surface & region` or `surface - region`.

    A bond crosses it when it crosses the surface, and meets its plane in the region or at most a tolerance beside it.
    `Plane((0, 0, 0), (0, 0, 1)) & HalfSpace((0, 0, 0), (1, 0, 0))` is a half plane.

    Its projection is exact where that of the surface lies in the region, and for convex regions up to 100 turns of an
    iteration; elsewhere it is a point of it that need not be the nearest.

    Args:
        surface: what bonds can cross.
        region: a geometry of the same dimension.

    Raises:
        BadInput: for something else, for different dimensions, and in `crosses` for a surface that is not flat.
    """

    _kinds = {"surface": "geometry", "region": "geometry"}

    def __init__(self, surface: Surface, region: Geometry) -> None:
        require_kind(surface, Surface, "surface")
        require_kind(region, Geometry, "region")
        common_dimension(surface, region)
        if isinstance(surface, Surfaces):
            raise BadInput(f"surface = {surface!r} is several; crop them one by one, or write surface & region")
        self.surface, self.region = surface, region

    @property
    def dimension(self) -> int:
        """That of the surface."""
        return self.surface.dimension

    @property
    def bounds(self) -> Bounds:
        """What the region leaves of those of the surface."""
        return self.region._inside(*self.surface.bounds)

    @property
    def size(self) -> float:
        """The diagonal of the bounds; where they are infinite, the larger of both sizes."""
        return super().size or max(self.surface.size, self.region.size)

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        crossing = np.zeros(len(starts), dtype=np.bool_)
        found, places, tolerance = self.surface._meetings(starts, ends)
        if found.size:
            crossing[found] = self._covers(places, tolerance)
        return crossing

    def _covers(self, places: FloatArray, tolerance: FloatArray) -> BoolArray:
        """Which places of the surface are in the region, or at most a tolerance beside it."""
        try:
            near: BoolArray = self.region._distance(places) <= tolerance
        except BadInput:  # a region that knows no distance has no tolerance either
            return self.region._contains(places)
        return near

    def _cure(self) -> str | None:
        return self.surface._cure()

    def _heights(self, points: FloatArray) -> FloatArray:
        return self.surface._heights(points)

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        return self.surface._margins(starts, ends)

    def _contains(self, points: FloatArray) -> BoolArray:
        return self.surface._contains(points) & self.region._contains(points)

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.maximum(self.surface._distance(points), self.region._distance(points))

    def _projection(self, points: FloatArray) -> FloatArray:
        result = self.surface._projection(points)
        # The last resort begins a little beside: from a middle between two ways out no turn leads away.
        for start, convex in ((points, True), (points, False), (points + BESIDE * self.size, False)):
            rest = np.flatnonzero(self.region._status(result, self._tolerance(result)) > 0)
            if rest.size:
                result[rest] = shared(self.region, self.surface, start[rest], convex)
        return result

    def _parameters(self) -> dict[str, object]:
        return {"surface": self.surface, "region": self.region}

    def __repr__(self) -> str:
        return f"({self.surface!r} & {self.region!r})"
